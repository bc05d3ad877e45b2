// Builds directional lights that stand for a map, or for a stratum of it. Also defines the
// parameters that several strategies share.
#pragma once

#include <cstdint>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "base/names.h"
#include "lights/light_sets/clustering.h"
#include "lights/parameters.h"
#include "lights/tables/cells.h"

namespace skywave {

enum class LightSource {
  kPenrose,
  kPolyomino,
  kMedianCut,
  kVarianceCut,
  kStructured,
  kKMeans,
  kKolligKeller
};

// The sides of a region that median cut compares, to cut across the longer one.
enum class LongestSide {
  kAngle,  // on the sphere (Debevec 2005)
  kUv,     // in (u, v) (T 6.2)
};

struct LightOptions {
  LightSource source = LightSource::kPenrose;
  int lights = 64;
  // Set: `lights` is chosen so that the bias of the lights (LightBias) is at most this.
  std::optional<double> bias;
  LightPosition position = LightPosition::kCentroid;
  LongestSide longest = LongestSide::kAngle;
  int lloyd_steps = 0;  // energy-weighted; samples of any source are then relaxed as points
  std::optional<ClusterFrequency> cluster;
  ClusterStop stop;  // used if cluster is set
  // Of a tiling, or of where k-means starts: others give other patterns of the same quality.
  std::uint64_t seed = 1;
  // Where k-means starts in place of that, as many as there will be; empty: by `seed`.
  std::vector<Vector3> start = {};
};

template <>
inline constexpr auto kEnumNames<LightSource> =
    std::to_array<Named<LightSource>>({{LightSource::kPenrose, "penrose"},
                                       {LightSource::kPolyomino, "polyomino"},
                                       {LightSource::kMedianCut, "median-cut"},
                                       {LightSource::kVarianceCut, "variance-cut"},
                                       {LightSource::kStructured, "structured"},
                                       {LightSource::kKMeans, "k-means"},
                                       {LightSource::kKolligKeller, "kollig-keller"}});
template <>
inline constexpr auto kEnumNames<LongestSide> =
    std::to_array<Named<LongestSide>>({{LongestSide::kAngle, "angle"}, {LongestSide::kUv, "uv"}});
template <>
inline constexpr auto kEnumNames<LightPosition> =
    std::to_array<Named<LightPosition>>({{LightPosition::kSample, "sample"},
                                         {LightPosition::kCentre, "center"},
                                         {LightPosition::kCentroid, "centroid"}});
template <>
inline constexpr auto kEnumNames<ClusterFrequency> =
    std::to_array<Named<ClusterFrequency>>({{ClusterFrequency::kOne, "F1"},
                                            {ClusterFrequency::kEnergy, "F2"},
                                            {ClusterFrequency::kMeanLuminance, "F3"}});

// Places lights, clusters and relaxes them as the options say, and gives each the light of its
// cell. The energy of the lights is the energy of the map. There are fewer lights than requested if
// texels with energy or clustering allow no more, and none for a black map.
//
// With `options.bias` numbers are tried in doubling steps up to kMostLights, and then between the
// last two, to a sixteenth of the number. Throws OptionError where none has so small a bias.
LightSet BuildLights(const SphereMap& map, const LightOptions& options);
inline constexpr int kMostLights = 30000;

// The samples of a map and what clustering makes of them (T figure 7.18).
struct MergedSamples {
  std::vector<Vector3> kept;    // those that stay as they are
  std::vector<Vector3> merged;  // those that are merged
  std::vector<Vector3> made;    // into these
};
// Returns those of `options`, which has a cluster.
MergedSamples MergeSamples(const SphereMap& map, const LightOptions& options);

// Describes to the user what BuildLights has chosen; empty if it had no choice.
std::string NoteOfLights(const LightSet& set);

// Returns the parameters behind LightOptions, for the table of strategies. Strategies that take
// lights from any source have `kFromParameter` too.
std::span<const StrategyParameter> LightParameters();
inline constexpr StrategyParameter kFromParameter = {
    "from", "penrose", "who places the lights: penrose or another strategy of directional lights"};

// A file of lights, or of cells, in place of those of `from`.
inline constexpr StrategyParameter kFileParameter = {
    "file", "", "lights of a file, as probe presample writes it, in place of those of from"};

// Throws OptionError if a parameter that chooses lights has a value that is not its default,
// because the lights of a file are chosen already.
void RequireDefaults(std::string_view strategy, std::span<const StrategyParameter> parameters,
                     const StrategyValues& values);

LightOptions ReadLightOptions(const StrategyValues& values);
LightSource ReadLightSource(const StrategyValues& values,
                            std::string_view key = kFromParameter.key);

}  // namespace skywave
