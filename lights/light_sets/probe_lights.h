// Turns a map into a set of lights by any method: the interface of this folder for `skywave probe`.
#pragma once

#include <cstdint>
#include <optional>
#include <string>
#include <string_view>

#include "lights/light_sets/light_builder.h"
#include "lights/light_sets/strata.h"

namespace skywave {

// Parses "0.54", "variation" or "64:10" (64 lights, 10 degrees apart).
std::optional<StrataRequest> ParseStrata(std::string_view text);

struct LightRequest {
  LightOptions lights = {.source = LightSource::kVarianceCut};
  std::optional<StrataRequest> strata;  // set: lights for the bright part A only
  std::string follow;                   // the file of the lights before, from which k-means starts
};

struct ProbeLights {
  LightSet set;                  // with strata, only texels of A have cells
  std::optional<Strata> strata;  // if requested
  Image residual;                // stratum B; empty if there are no strata
  double map_energy = 0, lights_energy = 0, residual_energy = 0;
};

// The energies of the lights and of the residual add up to that of the map. Throws InputError for
// requests out of range, and where there is nothing to follow.
ProbeLights MakeProbeLights(const SphereMap& map, const LightRequest& request);

}  // namespace skywave
