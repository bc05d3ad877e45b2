#include "cli/commands.h"

namespace skywave {

std::vector<Command> AllCommands() {
  return {RenderCommand(), MergeCommand(),   BatchCommand(),      InfoCommand(),
          PathsCommand(),  CompareCommand(), StrategiesCommand(), ConvergeCommand(),
          BenchCommand(),  ProbeCommand(),   OptionsCommand()};
}

}  // namespace skywave
