// The page of a batch: a contact sheet by the axes, and a table that can be sorted.
#pragma once

#include <span>
#include <string>

#include "base/files.h"
#include "job/batch/plan.h"
#include "job/batch/run.h"
#include "job/batch/thumbnail.h"

namespace skywave {

// Writes a page for the folder of the plan to `out`. It embeds the thumbnails, links the pictures
// by relative names, and needs no network. There is a result and a thumbnail for each picture of
// the plan.
void WriteBatchPage(const BatchPlan& plan, const BatchSummary& summary,
                    std::span<const Thumbnail> thumbnails, const PieceWriter& out);

}  // namespace skywave
