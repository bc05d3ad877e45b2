#include "lights/light_sets/light_builder.h"

#include <fmt/format.h>

#include <algorithm>
#include <numbers>

#include "base/error.h"
#include "lights/light_sets/light_bias.h"
#include "lights/light_sets/median_cut.h"
#include "lights/light_sets/penrose.h"
#include "lights/light_sets/polyomino.h"
#include "lights/light_sets/relaxed_samples.h"
#include "lights/light_sets/structured.h"
#include "lights/light_sets/variance_cut.h"
#include "lights/light_sets/voronoi.h"
#include "lights/tables/max_pyramid.h"

namespace skywave {
namespace {

constexpr double kLeastBias = 1e-4;

constexpr StrategyParameter kLightParameters[] = {
    {.key = "lights",
     .default_value = "64",
     .meaning = "number of lights before clustering, or auto:BIAS: as many as that bias needs",
     .chooses_lights = true},
    {"position", "centroid", "of a light in its cell: centroid, center or sample"},
    {"longest", "angle", "sides that median cut compares: angle on the sphere, or uv (T 6.2)"},
    {"lloyd", "0", "energy-weighted Lloyd steps"},
    {"cluster", "none", "merge lights pairwise by F1 (number), F2 (energy) or F3 (luminance)"},
    {"clusters", "0", "merge until this many are left; 0: no such limit"},
    {"separation", "0",
     "merge until lights are at least this far apart [degrees]; 0: no such limit"},
};

// Returns whether the lights are placed as points, whose cells are those nearest to them; the
// others cut the map into cells.
bool PlacesPoints(LightSource source) {
  return source == LightSource::kPenrose || source == LightSource::kPolyomino ||
         source == LightSource::kKMeans || source == LightSource::kKolligKeller;
}

LightSet CutLights(const SphereMap& map, const LightOptions& options, LightPosition position) {
  if (options.source == LightSource::kStructured) {
    PlacedCells cut = StructuredCells(map, options.lights);
    return LightsOfCells(map, std::move(cut.cell_of_texel), cut.samples, position);
  }
  const std::vector<Region> regions =
      options.source == LightSource::kMedianCut
          ? MedianCut(map, options.lights, {.scale_width = options.longest == LongestSide::kAngle})
          : VarianceCut(map, options.lights);
  return LightsOfRegions(map, regions, position);
}

std::vector<Vector3> PlaceSamples(const SphereMap& map, const LightOptions& options) {
  if (options.source == LightSource::kPenrose) {
    return Directions(
        PenroseSamples(ImportancePyramid(map), options.lights, {.seed = options.seed}));
  }
  if (options.source == LightSource::kPolyomino) {
    return Directions(PolyominoSamples(map, options.lights, options.seed));
  }
  if (options.source == LightSource::kKMeans) {
    return options.start.empty() ? KMeansSamples(map, options.lights, options.seed)
                                 : FollowingSamples(map, options.start);
  }
  if (options.source == LightSource::kKolligKeller) return KolligKellerSamples(map, options.lights);
  std::vector<Vector3> samples;
  const LightSet cut = CutLights(map, options, LightPosition::kCentroid);
  for (const DirectionalLight& light : cut.lights) samples.push_back(light.direction);
  return samples;
}

Clustering Cluster(const SphereMap& map, const std::vector<Vector3>& samples,
                   const LightOptions& options) {
  const CellMap cells = VoronoiCells(map.width, map.height, samples);
  const std::vector<CellSums> sums = SumCells(map, cells, samples.size());
  return ClusterPairwise(samples, Frequencies(sums, *options.cluster), options.stop);
}

// Returns the lights of the least number tried whose bias is at most options.bias.
LightSet BuildForBias(const SphereMap& map, const LightOptions& options) {
  const LightBias bias(map);
  const auto build = [&](int lights) {
    LightOptions tried = options;
    tried.lights = lights;
    tried.bias.reset();
    LightSet set = BuildLights(map, tried);
    set.bias = bias.Of(set.lights);
    return set;
  };
  int below = 0, count = 1;
  LightSet set = build(count);
  while (set.bias > *options.bias) {
    if (count == kMostLights) {
      throw OptionError("strategy", fmt::format("lights=auto:{}", *options.bias),
                        fmt::format("no number of lights by {} is so good: the most there can be, "
                                    "{}, have a relative bias of {:.2g}",
                                    ToString(options.source), set.lights.size(), set.bias));
    }
    below = count;
    count = std::min(2 * count, kMostLights);
    set = build(count);
  }
  while (count - below > std::max(1, below / 16)) {
    const int middle = below + (count - below) / 2;
    LightSet fewer = build(middle);
    if (fewer.bias > *options.bias) {
      below = middle;
    } else {
      count = middle;
      set = std::move(fewer);
    }
  }
  return set;
}

}  // namespace

std::string NoteOfLights(const LightSet& set) {
  if (set.lights.empty() || !(set.bias > 0)) return {};
  return fmt::format("{} lights, whose relative bias is {:.2g}", set.lights.size(), set.bias);
}

LightSet BuildLights(const SphereMap& map, const LightOptions& options) {
  if (map.energy <= 0) return {{}, CellMap(map.texels(), kNoCell)};
  if (options.bias) return BuildForBias(map, options);
  const bool points = PlacesPoints(options.source) || options.cluster || options.lloyd_steps > 0;
  if (!points) return CutLights(map, options, options.position);
  std::vector<Vector3> samples = PlaceSamples(map, options);
  if (options.cluster) samples = Cluster(map, samples, options).directions;
  return VoronoiLights(map, std::move(samples), options.position, options.lloyd_steps);
}

MergedSamples MergeSamples(const SphereMap& map, const LightOptions& options) {
  const std::vector<Vector3> samples = PlaceSamples(map, options);
  const Clustering clusters = Cluster(map, samples, options);
  std::vector<int> members(clusters.directions.size());
  for (const std::uint32_t cluster : clusters.cluster_of_sample) ++members[cluster];
  MergedSamples all;
  for (std::size_t i = 0; i < samples.size(); ++i) {
    const bool alone = members[clusters.cluster_of_sample[i]] == 1;
    (alone ? all.kept : all.merged).push_back(samples[i]);
  }
  for (std::size_t i = 0; i < members.size(); ++i) {
    if (members[i] > 1) all.made.push_back(clusters.directions[i]);
  }
  return all;
}

std::span<const StrategyParameter> LightParameters() { return kLightParameters; }

LightSource ReadLightSource(const StrategyValues& values, std::string_view key) {
  return kEnumNames<LightSource>[ChoiceValue(values, key, NamesOf<LightSource>())].value;
}

void RequireDefaults(std::string_view strategy, std::span<const StrategyParameter> parameters,
                     const StrategyValues& values) {
  for (const StrategyParameter& parameter : parameters) {
    const std::string& value = TextValue(values, parameter.key);
    if (!parameter.chooses_lights || value == parameter.default_value) continue;
    throw OptionError("strategy", std::string(strategy),
                      fmt::format("{}={} and file= both choose the lights: leave one of them out",
                                  parameter.key, value));
  }
}

LightOptions ReadLightOptions(const StrategyValues& values) {
  LightOptions options;
  options.bias = AutoValue(values, "lights", kLeastBias, 1);
  if (!options.bias) options.lights = IntValue(values, "lights", 1, kMostLights);
  options.position =
      kEnumNames<LightPosition>[ChoiceValue(values, "position", NamesOf<LightPosition>())].value;
  options.longest =
      kEnumNames<LongestSide>[ChoiceValue(values, "longest", NamesOf<LongestSide>())].value;
  options.lloyd_steps = IntValue(values, "lloyd", 0, 1000);
  constexpr std::string_view kClusters[] = {"none", "F1", "F2", "F3"};
  options.cluster = Parse<ClusterFrequency>(kClusters[ChoiceValue(values, "cluster", kClusters)]);
  options.stop.clusters = IntValue(values, "clusters", 0, kMostLights);
  options.stop.separation = NumberValue(values, "separation", 0, 180) * std::numbers::pi / 180;
  return options;
}

}  // namespace skywave
