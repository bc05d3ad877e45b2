// Implements skywave probe: analyses illumination maps, converts them and turns them into lights.
#include <fmt/format.h>

#include <numbers>

#include "cli/flags.h"
#include "cli/probe/commands.h"
#include "lights/maps/projections.h"

namespace skywave {

void AddMapFlags(CLI::App& command, MapFlags& flags) {
  command.add_option("map", flags.path, "illumination map (EXR, Radiance HDR, PFM)")->required();
  command
      .add_option_function<std::string>(
          "--projection",
          [&flags](const std::string& text) { flags.projection = ParseProjection(text); },
          "how its pixels lie (default: by shape)")
      ->check([](const std::string& text) {
        return ParseProjection(text) ? "" : "'" + text + "' is not " + ProjectionNames();
      })
      ->type_name("NAME");
  command.add_flag("--trust-input", flags.limits.trust_input,
                   "also decode EXR features with known holes in Debian's OpenEXR");
}

ProbeFile ReadProbe(const MapFlags& flags) {
  ProbeFile file;
  file.image = ReadImage(flags.path, flags.limits);
  file.assumed = flags.projection.has_value();
  file.projection = flags.projection ? *flags.projection : DetectProjection(file.image, flags.path);
  file.bad = RepairRadiance(file.image);
  if (file.bad.total() > 0) {
    fmt::print(stderr, "note: {}: {} NaN, {} infinite and {} negative pixels set to 0\n",
               flags.path, file.bad.nan, file.bad.infinite, file.bad.negative);
  }
  return file;
}

Image ReadProbeAsLatLong(const MapFlags& flags) {
  ProbeFile file = ReadProbe(flags);
  return ToLatLong(std::move(file.image), file.projection);
}

void AddStrataFlag(CLI::App& command, std::optional<StrataRequest>& request) {
  AddParsed(command, "--strata",
            "only the bright part A: p of the energy (0.54), where the luminance varies most "
            "(variation), or room for LIGHTS:DEGREES (64:10)",
            "P|variation|LIGHTS:DEGREES", request, ParseStrata);
}

void AddLightFlags(CLI::App& command, LightRequest& request) {
  LightOptions& lights = request.lights;
  AddParsed(command, "--method",
            fmt::format("who places them (default: {})", ToString(lights.source)),
            "median-cut|variance-cut|penrose", lights.source, ParseLightSource);
  command.add_option("-n,--lights", lights.lights, "how many, before clustering")
      ->check(CLI::Range(1, 1 << 20))
      ->capture_default_str();
  AddParsed(command, "--position",
            "of a light in its cell: where the sampler put it, middle of its area or of its energy",
            "sample|center|centroid", lights.position, ParseLightPosition);
  command.add_option("--lloyd", lights.lloyd_steps, "steps that move lights to their centroids")
      ->check(CLI::Range(0, 1000));
  AddParsed(command, "--cluster",
            "merge lights pairwise, weighed by one, energy or mean luminance; until --clusters or "
            "--separation say so",
            "F1|F2|F3", lights.cluster, ParseClusterFrequency);
  // A limit for clustering implies clustering.
  const auto by_energy = [&lights] {
    if (!lights.cluster) lights.cluster = ClusterFrequency::kEnergy;
  };
  command
      .add_option_function<int>(
          "--clusters",
          [&lights, by_energy](int clusters) { lights.stop.clusters = clusters, by_energy(); },
          "merge until so many are left (by F2 unless --cluster says otherwise)")
      ->check(CLI::Range(1, 1 << 20));
  command
      .add_option_function<double>(
          "--separation",
          [&lights, by_energy](double degrees) {
            lights.stop.separation = degrees * std::numbers::pi / 180, by_energy();
          },
          "merge until all are so far apart (by F2 unless --cluster says otherwise)")
      ->check(FiniteNumber(0, 180))
      ->type_name("DEGREES");
  command.add_option("--seed", lights.penrose.seed, "of the Penrose tiling")->capture_default_str();
  AddStrataFlag(command, request.strata);
}

void AddProbeCommand(CLI::App& program, Run& run) {
  CLI::App* probe =
      program.add_subcommand("probe", "Look at illumination maps, convert them, make lights");
  probe->require_subcommand(1);
  AddProbeInfoCommand(*probe, run);
  AddProbeConvertCommand(*probe, run);
  AddProbeLightsCommand(*probe, run);
  AddProbePresampleCommand(*probe, run);
  AddProbePlotCommand(*probe, run);
  AddProbeCalibrateCommand(*probe, run);
}

}  // namespace skywave
