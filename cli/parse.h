// Maps the command line to a subcommand and its options with CLI11.
#pragma once

#include <exception>
#include <string>
#include <string_view>
#include <vector>

#include "base/error.h"
#include "cli/command.h"

namespace skywave {

inline constexpr std::string_view kProgramDescription =
    "Skywave renders scenes lit by illumination maps (HDR light probes) on multicore CPUs.";

// Parses the arguments of main(), prints help or an error, and runs the subcommand. Returns the
// exit code of the program.
int RunCommandLine(int argc, char** argv, const std::vector<Command>& commands);

// What the program prints about an exception, and its exit code.
struct ErrorDescription {
  std::string text;
  int exit_code;
};
ErrorDescription DescribeError(const std::exception_ptr& thrown);

// Spells the options that `text` mentions in backticks (OptionError) as flags.
std::string SpellFlags(std::string_view text);

// The message of an error: "--photons 0 --caustic-photons 0: why".
std::string Message(const OptionError& error);

}  // namespace skywave
