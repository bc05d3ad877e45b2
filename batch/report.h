// Tells programs of a batch: its pictures, and what became of them.
#pragma once

#include <nlohmann/json.hpp>

#include "batch/plan.h"

namespace skywave {

// Returns the pictures of a plan: index, output, values of the axes, options.
nlohmann::ordered_json ListJson(const BatchPlan& plan);

}  // namespace skywave
