#include "cli/commands.h"

namespace skywave {

std::vector<Command> AllCommands() {
  return {RenderCommand(), BatchCommand(),   MergeCommand(),      InfoCommand(),
          PathsCommand(),  CompareCommand(), StrategiesCommand(), ConvergeCommand(),
          BenchCommand(),  ProbeCommand(),   OptionsCommand()};
}

}  // namespace skywave
