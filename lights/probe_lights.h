// From a map to a set of lights by any method: what `skywave probe` offers of this folder.
#pragma once

#include <cstdint>
#include <optional>
#include <string>
#include <string_view>

#include "lights/cells.h"
#include "lights/clustering.h"
#include "lights/penrose.h"
#include "lights/strata.h"

namespace skywave {

enum class LightMethod { kMedianCut, kVarianceCut, kPenrose };
std::optional<LightMethod> ParseLightMethod(std::string_view name);
std::string_view ToString(LightMethod method);

// What is divided into A, which becomes lights, and B, the residual map.
struct StrataRequest {
  enum class Kind { kNone, kFraction, kVariation, kLights } kind = Kind::kNone;
  double fraction = 0;    // kFraction: p in [0, 1]
  int lights = 0;         // kLights
  double separation = 0;  // kLights [rad]
};
// "0.54", "variation", "64:10" (64 lights, 10 degrees apart).
std::optional<StrataRequest> ParseStrata(std::string_view text);
Strata DivideMap(const SphereMap& map, const StrataRequest& request);

struct LightRequest {
  LightMethod method = LightMethod::kVarianceCut;
  int count = 64;
  LightPosition position = LightPosition::kCentroid;
  int lloyd_steps = 0;
  // Clustering, if `stop` says so: the lights are then Voronoi cells of the clusters.
  ClusterFrequency frequency = ClusterFrequency::kEnergy;
  ClusterStop stop;
  StrataRequest strata;
  PenroseParameters penrose;
};

struct ProbeLights {
  LightSet set;                  // cells over the whole map
  std::optional<Strata> strata;  // if asked for
  Image residual;                // stratum B; empty if there are no strata
  double map_energy = 0, lights_energy = 0, residual_energy = 0;
};

// Rectangles (median and variance cut) are cells as they are; with Lloyd steps or clustering their
// positions become samples of Voronoi cells. The energy of the lights and of the residual add up to
// that of the map. Throws InputError for requests out of range.
ProbeLights MakeProbeLights(const SphereMap& map, const LightRequest& request);

}  // namespace skywave
