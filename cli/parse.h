// The command line: arguments to a subcommand and its options, by CLI11.
#pragma once

#include <vector>

#include "cli/command.h"

namespace skywave {

// Parses the arguments of main(), prints help or what is wrong with them, and runs the subcommand.
// Returns the exit code of the program.
int RunCommandLine(int argc, char** argv, const std::vector<Command>& commands);

}  // namespace skywave
