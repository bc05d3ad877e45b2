// Implements skywave probe lights: a map as directional lights for this and other renderers.
#include <fmt/format.h>

#include "base/error.h"
#include "base/files.h"
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
  for (const std::string& path : {flags.output, flags.options.residual}) {
    if (!path.empty()) CheckWritable(path);
  }
  const Image latlong = ReadProbeAsLatLong(flags.map);
  const ProbeLights lights = MakeProbeLights(MakeSphereMap(latlong), flags.request);
  flags.options.source = flags.map.path;
  const std::string text = ExportLights(lights.set.lights, flags.options);
  if (flags.output.empty()) {
    fmt::print("{}", text);
  } else {
    WriteFileAtomically(flags.output, text);
  }
  if (!flags.options.residual.empty()) {
    WriteResidual(flags.options.residual, lights.residual, flags.options.format);
  }
  const double sum = lights.lights_energy + lights.residual_energy;
  const double off = lights.map_energy > 0 ? sum / lights.map_energy - 1 : 0;
  fmt::print(stderr, "{} lights: energy {:.8g} + rest {:.8g} = {:.8g}, map {:.8g} ({:+.1e})\n",
             lights.set.lights.size(), lights.lights_energy, lights.residual_energy, sum,
             lights.map_energy, off);
  if (flags.request.strata && flags.options.residual.empty()) {
    fmt::print(stderr, "note: the rest is not written; --residual FILE.exr does\n");
  }
  return 0;
}

}  // namespace

void AddProbeLightsCommand(CLI::App& probe, Run& run) {
  CLI::App* command = probe.add_subcommand("lights", "Directional lights with a map's energy");
  const auto flags = std::make_shared<LightsFlags>();
  AddMapFlags(*command, flags->map);
  AddLightFlags(*command, flags->request);
  command
      ->add_option_function<std::string>(
          "--format",
          [flags](const std::string& text) { flags->options.format = *ParseLightFormat(text); },
          "table, json or scene text for pbrt (v4), povray (3.7), blender (Python), maya (MEL) "
          "(default: table)")
      ->check(CLI::IsMember({"table", "json", "pbrt", "povray", "blender", "maya"}));
  command
      ->add_option_function<std::string>(
          "--up", [flags](const std::string& text) { flags->options.up_axis = text[0]; },
          "up axis of the world that is written (default: z for blender, y for others)")
      ->check(CLI::IsMember({"x", "y", "z"}));
  command->add_option("-o,--output", flags->output, "file (default: standard output)");
  command->add_option("--residual", flags->options.residual,
                      "write the rest of the map; for pbrt as an octahedral square");
  command->footer(
      "Examples:\n"
      "  skywave probe lights sky.exr -n 64\n"
      "  skywave probe lights sky.exr -n 32 --strata variation --residual rest.exr \\\n"
      "    --format blender -o lights.py");
  command->callback([flags, &run] { run = [flags] { return LightsMain(*flags); }; });
}

}  // namespace skywave
