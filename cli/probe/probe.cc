// Implements skywave probe: analyses illumination maps, converts them and turns them into lights.
#include <numbers>

#include "base/files.h"
#include "cli/commands.h"
#include "cli/print.h"
#include "cli/probe/commands.h"
#include "lights/maps/projections.h"
#include "lights/maps/resample.h"

namespace skywave {

#define FIELD SKYWAVE_FIELD

void AddMapOptions(Command& command, const std::shared_ptr<MapFlags>& flags) {
  const auto option = [](OptionInfo info, auto field, auto codec) {
    info.scope = OptionScope::kInput;
    return MakeOption<MapFlags>(info, field, codec);
  };
  // clang-format off
  const OptionOf<MapFlags> options[] = {
    option({.name = "map", .help = "illumination map (EXR, Radiance HDR, PFM)", .positional = true, .required = true}, FIELD(path), Texts("MAP")),
    option({.name = "projection", .help = "projection of the map", .default_text = "by its shape", .metavar = "NAME"}, FIELD(projection), NamesOfEnum<Projection>()),
    option({.name = "trust-input", .help = "decode rare kinds of EXR in this process, not in a confined one"}, FIELD(limits.trust_input), Switches()),
  };
  // clang-format on
  AddOptions(command, options, flags);
}

ProbeMap ReadProbe(const MapFlags& flags) {
  ProbeMap map = MakeProbeMap(ReadImage(flags.path, flags.limits), flags.path, flags.projection);
  if (map.bad.total() > 0) {
    Print(stderr, "note: {}: {}\n", flags.path, Describe(map.bad));
  }
  return map;
}

Image ReadProbeAsLatLong(const MapFlags& flags) {
  ProbeMap map = ReadProbe(flags);
  return ToLatLong(std::move(map.image), map.projection);
}

void AddLightOptions(Command& command, const std::shared_ptr<LightRequest>& request) {
  const auto option = [](OptionInfo info, auto field, auto codec) {
    info.scope = OptionScope::kPixels;
    return MakeOption<LightRequest>(info, field, codec);
  };
  // These values are never printed because words describe their defaults.
  const auto unprinted = [](const auto&) { return ""; };
  // A limit for clustering implies clustering.
  const auto cluster_too = [](OptionOf<LightRequest> limit) {
    limit.set = [set = limit.set](LightRequest& r, const std::vector<std::string>& texts) {
      if (!r.lights.cluster) r.lights.cluster = ClusterFrequency::kEnergy;
      return set(r, texts);
    };
    return limit;
  };
  // Nothing but k-means begins with samples that are there.
  const auto by_k_means = [](OptionOf<LightRequest> follow) {
    follow.set = [set = follow.set](LightRequest& r, const std::vector<std::string>& texts) {
      r.lights.source = LightSource::kKMeans;
      return set(r, texts);
    };
    return follow;
  };
  Codec<double> degrees = Doubles(0, 180);
  degrees.parse = [parse = degrees.parse](const std::string& text) {
    std::optional<double> value = parse(text);
    if (value) *value *= std::numbers::pi / 180;
    return value;
  };
  degrees.print = unprinted;
  Codec<int> counts = Numbers(1, 1 << 20);
  counts.print = unprinted;
  constexpr std::string_view kMerge = "Merging lights";
  const LightOptions& defaults = request->lights;
  // clang-format off
  const OptionOf<LightRequest> options[] = {
    option({.name = "method", .help = "algorithm that places the lights", .default_text = ToString(defaults.source)}, FIELD(lights.source), NamesOfEnum<LightSource>()),
    option({.name = "lights", .help = "number of lights, before clustering", .letter = 'n', .excludes = "follow"}, FIELD(lights.lights), Numbers(1, 1 << 20)),
    option({.name = "position", .help = "place of a light in its cell: the sampler's point, the middle of its area or of its energy", .default_text = ToString(defaults.position)}, FIELD(lights.position), NamesOfEnum<LightPosition>()),
    option({.name = "longest", .help = "sides that median cut compares: their angles on the sphere, or their lengths in (u, v)", .default_text = ToString(defaults.longest)}, FIELD(lights.longest), NamesOfEnum<LongestSide>()),
    option({.name = "lloyd", .help = "steps that move lights to their centroids"}, FIELD(lights.lloyd_steps), Numbers(0, 1000)),
    option({.name = "seed", .help = "seed of the tiling by penrose or polyomino, and of k-means"}, FIELD(lights.seed), Numbers(0u, 0xFFFFFFFFu)),
    by_k_means(option({.name = "follow", .help = "set of the map before, as presample writes it: as many samples, by k-means that begins with them, so lights of an animation do not jump", .metavar = "JSON", .of_file = true, .excludes = "method"}, FIELD(follow), Texts("JSON"))),
    option({.name = "strata", .help = "only the bright part A: p of the energy (0.54), where the luminance varies most (variation), or room for LIGHTS:DEGREES (64:10)", .metavar = "P|variation|LIGHTS:DEGREES"}, FIELD(strata), Codec<StrataRequest>{.values = "P|variation|LIGHTS:DEGREES", .parse = ParseStrata, .print = unprinted}),
    option({.name = "cluster", .group = kMerge, .help = "merge lights pairwise, weighted by one, energy or mean luminance, until --clusters or --separation is reached"}, FIELD(lights.cluster), NamesOfEnum<ClusterFrequency>()),
    cluster_too(option({.name = "clusters", .group = kMerge, .help = "merge until this many are left (by F2 without --cluster)"}, FIELD(lights.stop.clusters), counts)),
    cluster_too(option({.name = "separation", .group = kMerge, .help = "merge until all are at least this far apart (by F2 without --cluster)", .metavar = "DEGREES"}, FIELD(lights.stop.separation), degrees)),
  };
  // clang-format on
  AddOptions(command, options, request);
}

#undef FIELD

Command ProbeCommand() {
  return {.name = "probe",
          .summary = "Look at illumination maps, convert them, make lights",
          .children = {ProbeInfoCommand(), ProbeConvertCommand(), ProbeLightsCommand(),
                       ProbePresampleCommand(), ProbePlotCommand(), ProbeCalibrateCommand(),
                       ProbeAssembleCommand(), ProbeJoinCommand()}};
}

}  // namespace skywave
