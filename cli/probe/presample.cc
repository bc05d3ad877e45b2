// Implements skywave probe presample: a sample set with cells and energies.
#include <array>

#include "base/files.h"
#include "cli/print.h"
#include "cli/probe/commands.h"
#include "lights/light_sets/light_file.h"
#include "lights/probe/plot.h"

namespace skywave {
namespace {

struct PresampleFlags {
  MapFlags map;
  LightRequest request;
  std::string output, cells;
};

int PresampleMain(PresampleFlags& flags) {
  CheckOutputs(std::array{flags.output, flags.cells},
               std::array{flags.map.path, flags.request.follow});
  const Image latlong = ReadProbeAsLatLong(flags.map);
  const SphereMap map = MakeSphereMap(latlong);
  const ProbeLights lights = MakeProbeLights(map, flags.request);
  WriteFileAtomically(flags.output,
                      LightFileText(lights.set, map.width, map.height,
                                    {.source = flags.map.path,
                                     .method = std::string(ToString(flags.request.lights.source)),
                                     .map_energy = lights.map_energy}));
  if (!flags.cells.empty()) {
    WritePng(flags.cells, map.width, map.height, CellColors(lights.set.cell_of_texel));
  }
  Print(stdout, "wrote {}: {} samples, energy {:.8g} of {:.8g}\n", flags.output,
        lights.set.lights.size(), lights.lights_energy, lights.map_energy);
  return 0;
}

#define FIELD SKYWAVE_FIELD
std::vector<OptionOf<PresampleFlags>> PresampleOptions() {
  constexpr OptionMaker<PresampleFlags> option = {};
  // clang-format off
  return {
    option({.name = "output", .help = "JSON file", .letter = 'o', .required = true}, FIELD(output), Texts("JSON")),
    option({.name = "cells", .help = "write the cells as a PNG, a colour each"}, FIELD(cells), Texts("PNG")),
  };
  // clang-format on
}
#undef FIELD

}  // namespace

Command ProbePresampleCommand() {
  const auto flags = std::make_shared<PresampleFlags>();
  flags->request.lights = {
      .source = LightSource::kPenrose, .lights = 360, .position = LightPosition::kSample};
  Command command = {
      .name = "presample",
      .summary = "A sample set with cells and energies",
      .footer =
          "The method is penrose and the position is sample by default.\n\n"
          "Examples:\n"
          "  skywave probe presample sky.exr -n 360 -o set.json --cells cells.png\n"
          "  skywave render spheres --env sky.exr --strategy presampled:file=set.json\n"
          "  skywave probe presample sky.exr -n 64 --strata variation -o bright.json\n"
          "  skywave render spheres --env sky.exr --strategy hybrid:file=bright.json\n"
          "  skywave probe presample next.exr --follow set.json -o next.json",
      .run = [flags](const GivenOptions&) { return PresampleMain(*flags); }};
  AddMapOptions(command, std::shared_ptr<MapFlags>(flags, &flags->map));
  AddLightOptions(command, std::shared_ptr<LightRequest>(flags, &flags->request));
  const auto options = PresampleOptions();
  AddOptions(command, options, flags);
  return command;
}

}  // namespace skywave
