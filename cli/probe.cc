// skywave probe: looks at illumination maps, converts them and turns them into lights.
#include <fmt/format.h>

#include <numbers>

#include "cli/probe_commands.h"
#include "lights/projections.h"

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

void AddStrataFlag(CLI::App& command, StrataRequest& request) {
  command
      .add_option_function<std::string>(
          "--strata", [&request](const std::string& text) { request = *ParseStrata(text); },
          "only the bright part A: p of the energy (0.54), where the luminance varies most "
          "(variation), or room for LIGHTS:DEGREES (64:10)")
      ->check([](const std::string& text) {
        return ParseStrata(text) ? ""
                                 : "'" + text + "' is not a fraction, variation or LIGHTS:DEGREES";
      })
      ->type_name("P|variation|N:DEG");
}

void AddLightFlags(CLI::App& command, LightRequest& request) {
  command
      .add_option_function<std::string>(
          "--method",
          [&request](const std::string& text) { request.method = *ParseLightMethod(text); },
          "median-cut, variance-cut or penrose (default: variance-cut)")
      ->check(CLI::IsMember({"median-cut", "variance-cut", "penrose"}));
  command.add_option("-n,--lights", request.count, "how many, before clustering")
      ->check(CLI::Range(1, 1 << 20))
      ->capture_default_str();
  command
      .add_option_function<std::string>(
          "--position",
          [&request](const std::string& text) {
            request.position = text == "sample"   ? LightPosition::kSample
                               : text == "centre" ? LightPosition::kCentre
                                                  : LightPosition::kCentroid;
          },
          "of a light in its cell: where the sampler put it, middle of its area or of its energy "
          "(default: centroid)")
      ->check(CLI::IsMember({"sample", "centre", "centroid"}));
  command.add_option("--lloyd", request.lloyd_steps, "steps that move lights to their centroids")
      ->check(CLI::Range(0, 1000));
  command
      .add_option_function<std::string>(
          "--cluster",
          [&request](const std::string& text) {
            request.frequency = text == "F1"   ? ClusterFrequency::kOne
                                : text == "F2" ? ClusterFrequency::kEnergy
                                               : ClusterFrequency::kMeanLuminance;
          },
          "weight of lights that merge: one, energy or mean luminance (default: F2)")
      ->check(CLI::IsMember({"F1", "F2", "F3"}));
  command.add_option("--clusters", request.stop.clusters, "merge until so many are left")
      ->check(CLI::Range(1, 1 << 20));
  command
      .add_option_function<double>(
          "--separation",
          [&request](double degrees) {
            request.stop.separation = degrees * std::numbers::pi / 180;
          },
          "merge until all are so far apart")
      ->check(CLI::Range(0.0, 180.0))
      ->type_name("DEGREES");
  command.add_option("--seed", request.penrose.seed, "of the Penrose tiling")
      ->capture_default_str();
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
