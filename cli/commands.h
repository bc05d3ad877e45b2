// The subcommands of `skywave`, one file each.
#pragma once

#include <vector>

#include "cli/command.h"

namespace skywave {

Command RenderCommand();
Command DenoiseCommand();
Command MergeCommand();
Command RelightCommand();
Command BatchCommand();
Command InfoCommand();
Command PathsCommand();
Command CompareCommand();
Command StrategiesCommand();
Command ConvergeCommand();
Command BenchCommand();
Command ProbeCommand();
Command OptionsCommand();

// Returns all of them, in the order of the help text.
std::vector<Command> AllCommands();

}  // namespace skywave
