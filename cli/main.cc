// skywave: renders scenes lit by illumination maps on multicore CPUs.
#include <fmt/format.h>

#include <cstdio>
#include <exception>

#include "base/error.h"
#include "cli/commands.h"
#include "cli/flags.h"

int main(int argc, char** argv) {
  CLI::App program{
      "Skywave renders scenes lit by illumination maps (HDR light probes) on multicore CPUs.\n"
      "Start with:  skywave render gallery -o gallery.exr"};
  program.set_version_flag("--version", "skywave " SKYWAVE_VERSION);
  program.require_subcommand(1);
  skywave::Run run;
  skywave::AddRenderCommand(program, run);
  skywave::AddInfoCommand(program, run);
  skywave::AddPathsCommand(program, run);
  skywave::AddCompareCommand(program, run);
  skywave::AddStrategiesCommand(program, run);
  skywave::AddConvergeCommand(program, run);
  skywave::AddBenchCommand(program, run);
  skywave::AddProbeCommand(program, run);
  try {
    program.parse(argc, argv);
  } catch (const CLI::ParseError& error) {
    return program.exit(error) == 0 ? 0 : skywave::kExitUsage;
  }
  try {
    return run();
  } catch (const skywave::OptionError& error) {
    fmt::print(stderr, "skywave: {}\n", skywave::Message(error));
    return error.exit_code();
  } catch (const skywave::InputError& error) {
    fmt::print(stderr, "skywave: {}\n", error.what());
    return error.exit_code();
  } catch (const std::bad_alloc&) {
    fmt::print(stderr, "skywave: out of memory\n");
    return skywave::kExitIo;
  } catch (const std::exception& error) {
    fmt::print(stderr, "skywave: {}\n", error.what());
    return 1;
  }
}
