// Maps the command line to a subcommand and its options with CLI11.
#pragma once

#include <vector>

#include "cli/command.h"

namespace skywave {

// Parses the arguments of main(), prints help or an error, and runs the subcommand. Returns the
// exit code of the program.
int RunCommandLine(int argc, char** argv, const std::vector<Command>& commands);

}  // namespace skywave
