// Implements skywave probe calibrate: a map that shows its axes.
#include "base/files.h"
#include "cli/print.h"
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
  Print(stdout, "wrote {}\n", flags.output);
  for (const CalibrationAxis& axis : kCalibrationAxes) {
    Print(stdout, "{}  {:g} {:g} {:g}\n", axis.name, axis.radiance[0], axis.radiance[1],
          axis.radiance[2]);
  }
  return 0;
}

#define FIELD SKYWAVE_FIELD
std::vector<OptionOf<CalibrateFlags>> CalibrateOptions() {
  constexpr OptionMaker<CalibrateFlags> option = {};
  // clang-format off
  return {
    option({.name = "output", .help = "EXR, HDR or PFM (lat-long)", .letter = 'o', .required = true}, FIELD(output), Texts("FILE")),
    option({.name = "height", .help = "[pixels]; the map is twice as wide"}, FIELD(height), Numbers(1, 8192)),
  };
  // clang-format on
}
#undef FIELD

}  // namespace

Command ProbeCalibrateCommand() {
  return CommandOf<CalibrateFlags>(
      {.name = "calibrate",
       .summary = "A map with its six axes coloured and labelled",
       .footer = "R right, F forward (middle of the map), U up.\n\n"
                 "Example:\n  skywave probe calibrate -o calibration.exr"},
      CalibrateOptions(), CalibrateMain);
}

}  // namespace skywave
