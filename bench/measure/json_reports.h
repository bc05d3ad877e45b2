// Reports differences of pictures, and what is in a map, for programs.
#pragma once

#include <nlohmann/json_fwd.hpp>
#include <string>

#include "bench/measure/picture_noise.h"
#include "image/compare.h"
#include "image/flip.h"
#include "lights/probe/probe_info.h"
#include "lights/probe/probe_map.h"

namespace skywave {

// Returns the keys of `skywave compare --json`, without those of noise, which the last one
// returns.
nlohmann::ordered_json Json(const ImageDifference& difference, const Flip& flip);
std::string JsonText(const ImageDifference& difference, const Flip& flip);
nlohmann::ordered_json Json(const NoiseComparison& comparison);

// `info` describes `map`. docs/probe.md describes the keys.
std::string JsonText(const ProbeMap& map, const ProbeInfo& info);

}  // namespace skywave
