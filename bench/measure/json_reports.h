// Reports differences of pictures, and what is in a map, for programs.
#pragma once

#include <nlohmann/json.hpp>

#include "bench/measure/picture_noise.h"
#include "image/compare.h"
#include "image/flip.h"
#include "lights/probe/probe_info.h"
#include "lights/probe/probe_map.h"

namespace skywave {

// Returns the keys of `skywave compare --json`, without those of noise, which the second one
// returns.
nlohmann::ordered_json Json(const ImageDifference& difference, const Flip& flip);
nlohmann::ordered_json Json(const NoiseComparison& comparison);

// `info` describes `map`. docs/probe.md describes the keys.
nlohmann::ordered_json Json(const ProbeMap& map, const ProbeInfo& info);

}  // namespace skywave
