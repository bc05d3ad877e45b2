// A pilot chooses among strategies: it renders the frame, coarse, with each of them, and takes the
// one for which variance times cost is least.
#pragma once

#include <memory>
#include <vector>

#include "wavefront/film/film.h"
#include "wavefront/frame.h"
#include "wavefront/pilot_reports.h"
#include "wavefront/worker_pool.h"

namespace skywave {

// A strategy of a frame: that of all paths, or that after the split.
using StrategySlot = const EnvStrategy* FrameView::*;

// Puts one of its candidates in the place of strategy `slot` of the frame, whose film holds
// radiance up to `brightest_radiance`.
// If that one has to be taught, the taught strategy is returned. The choice is added to `choices`.
// Costs are counted and not timed, so the choice depends on neither the machine, threads nor wave,
// nor on which part of the film or which samples the frame has. Statistics of the workers stay as
// they are, and no rays are recorded.
std::unique_ptr<EnvStrategy> ChooseStrategy(StrategySlot slot, float brightest_radiance,
                                            WorkerPool& pool, FrameView& frame,
                                            std::vector<StrategyChoice>& choices,
                                            PilotCounts& visibility);

}  // namespace skywave
