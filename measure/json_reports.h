// Reports differences of pictures, and what is in a map, for programs.
#pragma once

#include <nlohmann/json.hpp>

#include "image/compare.h"
#include "lights/probe/probe_info.h"
#include "lights/probe/probe_map.h"

namespace skywave {

// Returns the keys of `skywave compare --json`.
nlohmann::ordered_json Json(const ImageDifference& difference);

// `info` describes `map`. docs/probe.md describes the keys.
nlohmann::ordered_json Json(const ProbeMap& map, const ProbeInfo& info);

}  // namespace skywave
