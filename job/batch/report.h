// Reports a batch to programs: its pictures, and what became of them.
#pragma once

#include <map>
#include <nlohmann/json_fwd.hpp>
#include <string>

#include "job/batch/plan.h"
#include "job/batch/run.h"

namespace skywave {

// Returns the pictures of a plan: index, output, values of the axes, options.
nlohmann::ordered_json ListJson(const BatchPlan& plan);

// Returns what became of the pictures of a plan, or of a share of them. Names of files are relative
// to the folder of the plan. docs/batch.md describes the keys.
nlohmann::ordered_json SummaryJson(const BatchPlan& plan, const BatchShare& share,
                                   const BatchSummary& summary);

// Returns the results of pictures by their output, from the text of such JSON; none from other
// text.
std::map<std::string, PictureResult> ResultsInJson(const std::string& text);

}  // namespace skywave
