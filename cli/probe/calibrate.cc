// Implements skywave probe calibrate: a map that shows its axes.
#include <fmt/format.h>

#include "base/files.h"
#include "cli/probe/commands.h"
#include "lights/probe/calibration.h"

namespace skywave {
namespace {

struct CalibrateFlags {
  std::string output;
  int height = 512;
};

int CalibrateMain(const CalibrateFlags& flags) {
  CheckWritable(flags.output);
  WriteImage(flags.output, CalibrationMap(flags.height));
  fmt::print("wrote {}\n", flags.output);
  for (const CalibrationAxis& axis : kCalibrationAxes) {
    fmt::print("{}  {:g} {:g} {:g}\n", axis.name, axis.radiance[0], axis.radiance[1],
               axis.radiance[2]);
  }
  return 0;
}

}  // namespace

void AddProbeCalibrateCommand(CLI::App& probe, Run& run) {
  CLI::App* command =
      probe.add_subcommand("calibrate", "A map with its six axes coloured and labelled");
  const auto flags = std::make_shared<CalibrateFlags>();
  command->add_option("-o,--output", flags->output, "EXR, HDR or PFM (lat-long)")->required();
  command->add_option("--height", flags->height, "[pixels]; the map is twice as wide")
      ->check(CLI::Range(1, 8192))
      ->capture_default_str();
  command->footer(
      "R right, F forward (middle of the map), U up.\n\n"
      "Example:\n  skywave probe calibrate -o calibration.exr");
  command->callback([flags, &run] { run = [flags] { return CalibrateMain(*flags); }; });
}

}  // namespace skywave
