// Camera paths of a pilot (wavefront/guiding/pilot.h) find out where light paths are needed
// (wavefront/guiding/emission_guide.h).
#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include "wavefront/frame.h"
#include "wavefront/guiding/guide_sample.h"
#include "wavefront/stages/stages.h"
#include "wavefront/worker.h"

namespace skywave {

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

}  // namespace skywave
