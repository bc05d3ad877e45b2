// Makes the guide of a frame's light paths for tests that render its waves themselves.
#pragma once

#include <tbb/task_arena.h>

#include <memory>
#include <vector>

#include "wavefront/guiding/emission_guide.h"

namespace skywave {

// Returns the same guide as RenderFrame would make, or an empty one if it would make none.
inline EmissionGuide GuideFor(const FrameView& frame, int threads = 2) {
  EmissionGuide guide;
  const RenderOptions& options = frame.options;
  if (!options.guide || !HasLightPaths(options.integrator) || !frame.has_environment())
    return guide;
  tbb::task_arena arena(threads);
  arena.execute([&] {
    std::vector<std::unique_ptr<Worker>> workers(std::size_t(arena.max_concurrency()));
    GuideCounts counts;
    guide = LearnEmission(frame, workers, counts);
  });
  return guide;
}

}  // namespace skywave
