// Camera paths of a pilot (wavefront/paths/pilot.h) find out where light paths are needed, and make
// the guide of those (wavefront/records/emission_guide.h).
#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include "wavefront/frame.h"
#include "wavefront/pilot_reports.h"
#include "wavefront/records/emission_guide.h"
#include "wavefront/records/guide_sample.h"
#include "wavefront/stages/stages.h"
#include "wavefront/worker.h"
#include "wavefront/worker_pool.h"

namespace skywave {

// Light paths from the environment start where camera paths of a pilot needed them.
struct GuideOptions {
  bool guide = false;
};

// These rules decide what light counts as needed.
struct PilotQuestion {
  // Mean luminance of each cell of directions. It stands for what rays through mirrors and glass
  // see, which no light sample competes with: the few of them that hit a sun would outweigh all
  // others.
  std::span<const double> radiance;
  // The least number of surfaces with a density between the environment and the eye. Light through
  // mirrors and glass to one of them, a caustic, is always needed; without any, light paths
  // contribute nothing.
  std::uint32_t least_surfaces = 1;
};

// Traces paths `range` of the pilot and appends the guide samples that they find.
void TracePilotWave(const FrameView& pilot, const WaveRange& range, const PilotQuestion& question,
                    Worker& w, std::vector<GuideSample>& samples);

// Traces the pilot of a frame whose light paths start with frame.emitter, and makes its guide; it
// is empty if no camera path finds the environment. The guide depends on neither threads nor wave,
// nor on which part of the film or which samples the frame has. Statistics of the workers stay as
// they are, and no rays are recorded.
EmissionGuide LearnEmission(const FrameView& frame, WorkerPool& pool, PilotCounts& counts);

}  // namespace skywave
