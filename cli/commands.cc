#include "cli/commands.h"

namespace skywave {

std::vector<Command> AllCommands() {
  return {RenderCommand(),     DenoiseCommand(),  MergeCommand(), RelightCommand(),
          BatchCommand(),      InfoCommand(),     PathsCommand(), CompareCommand(),
          StrategiesCommand(), ConvergeCommand(), BenchCommand(), ProbeCommand(),
          OptionsCommand()};
}

}  // namespace skywave
