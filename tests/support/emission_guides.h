// Makes the guide of a frame's light paths for tests that render its waves themselves.
#pragma once

#include "wavefront/policies/emission_pilot.h"

namespace skywave {

// Returns the same guide as RenderFrame would make, or an empty one if it would make none.
inline EmissionGuide GuideFor(const FrameView& frame, int threads = 2) {
  EmissionGuide guide;
  const RenderOptions& options = frame.options;
  if (!options.of<GuideOptions>().guide || !Describe(options.integrator).has_light_paths() ||
      !frame.has_environment())
    return guide;
  RenderOptions on_threads = options;
  on_threads.threads = threads;
  WorkerPool pool(on_threads);
  PilotCounts counts;
  pool.Run([&] { guide = LearnEmission(frame, pool, counts); });
  return guide;
}

}  // namespace skywave
