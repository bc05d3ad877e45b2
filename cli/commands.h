// The subcommands of `skywave`, one file each. Each adds its flags to the program and sets `run` if
// it was the one that was called; main() runs it.
#pragma once

#include <CLI/CLI.hpp>
#include <functional>

namespace skywave {

using Run = std::function<int()>;

void AddRenderCommand(CLI::App& program, Run& run);
void AddInfoCommand(CLI::App& program, Run& run);
void AddPathsCommand(CLI::App& program, Run& run);
void AddCompareCommand(CLI::App& program, Run& run);
void AddStrategiesCommand(CLI::App& program, Run& run);
void AddConvergeCommand(CLI::App& program, Run& run);
void AddBenchCommand(CLI::App& program, Run& run);
void AddProbeCommand(CLI::App& program, Run& run);

}  // namespace skywave
