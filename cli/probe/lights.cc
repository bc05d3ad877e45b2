// Implements skywave probe lights: a map as directional lights for this and other renderers.
#include <array>

#include "base/error.h"
#include "base/files.h"
#include "cli/print.h"
#include "cli/probe/commands.h"
#include "lights/maps/projections.h"
#include "lights/maps/resample.h"
#include "lights/probe/export_lights.h"

namespace skywave {
namespace {

struct LightsFlags {
  MapFlags map;
  LightRequest request;
  ExportOptions options;
  std::string output;
};

// pbrt-v4 reads maps only as octahedral squares.
void WriteResidual(const std::string& path, const Image& residual, LightFormat format) {
  if (format != LightFormat::kPbrt) return WriteImage(path, residual);
  int width, height;
  DefaultSize(Projection::kOctahedral, residual.height, width, height);
  WriteImage(path,
             Resample(residual, Projection::kLatLong, Projection::kOctahedral, width, height));
}

int LightsMain(LightsFlags& flags) {
  if (!flags.options.residual.empty() && !flags.request.strata) {
    throw InputError({}, "--residual needs --strata: without it all light is in the lights",
                     kExitUsage);
  }
  CheckOutputs(std::array{flags.output, flags.options.residual},
               std::array{flags.map.path, flags.request.follow});
  const Image latlong = ReadProbeAsLatLong(flags.map);
  const ProbeLights lights = MakeProbeLights(MakeSphereMap(latlong), flags.request);
  flags.options.source = flags.map.path;
  const std::string text = ExportLights(lights.set.lights, flags.options);
  if (flags.output.empty()) {
    Print(stdout, "{}", text);
  } else {
    WriteFileAtomically(flags.output, text);
  }
  if (!flags.options.residual.empty()) {
    WriteResidual(flags.options.residual, lights.residual, flags.options.format);
  }
  const double sum = lights.lights_energy + lights.residual_energy;
  const double off = lights.map_energy > 0 ? sum / lights.map_energy - 1 : 0;
  Print(stderr, "{} lights: energy {:.8g} + rest {:.8g} = {:.8g}, map {:.8g} ({:+.1e})\n",
        lights.set.lights.size(), lights.lights_energy, lights.residual_energy, sum,
        lights.map_energy, off);
  if (flags.request.strata && flags.options.residual.empty()) {
    Print(stderr, "note: the rest is not written; --residual FILE.exr does\n");
  }
  return 0;
}

#define FIELD SKYWAVE_FIELD
std::vector<OptionOf<LightsFlags>> LightsOptions() {
  constexpr OptionMaker<LightsFlags> option = {};
  const auto up_axis = Codec<char>{.values = "x|y|z",
                                   .metavar = "x|y|z",
                                   .parse = [](const std::string& text) -> std::optional<char> {
                                     if (text == "x" || text == "y" || text == "z") return text[0];
                                     return std::nullopt;
                                   },
                                   .print = [](const char& axis) { return std::string(1, axis); }};
  // clang-format off
  return {
    option({.name = "format", .help = "table, JSON, or scene text for pbrt (v4), POV-Ray (3.7), Blender (Python), Maya (MEL)", .default_text = "table"}, FIELD(options.format), NamesOfEnum<LightFormat>()),
    option({.name = "up", .help = "up axis of the world that is written", .default_text = "z for blender, y for others"}, FIELD(options.up_axis), up_axis),
    option({.name = "output", .help = "file", .default_text = "standard output", .letter = 'o'}, FIELD(output), Texts("FILE")),
    option({.name = "residual", .help = "write the rest of the map; for pbrt as an octahedral square"}, FIELD(options.residual), Texts("FILE")),
  };
  // clang-format on
}
#undef FIELD

}  // namespace

Command ProbeLightsCommand() {
  const auto flags = std::make_shared<LightsFlags>();
  Command command = {
      .name = "lights",
      .summary = "Directional lights with a map's energy",
      .footer =
          "Examples:\n"
          "  skywave probe lights sky.exr -n 64\n"
          "  skywave probe lights sky.exr -n 32 --strata variation --residual rest.exr \\\n"
          "    --format blender -o lights.py",
      .run = [flags](const GivenOptions&) { return LightsMain(*flags); }};
  AddMapOptions(command, std::shared_ptr<MapFlags>(flags, &flags->map));
  AddLightOptions(command, std::shared_ptr<LightRequest>(flags, &flags->request));
  const auto options = LightsOptions();
  AddOptions(command, options, flags);
  return command;
}

}  // namespace skywave
