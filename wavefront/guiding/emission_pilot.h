// Camera paths of the pilot find out where light paths are needed
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

// The pilot has about this many camera paths: few against a usual render, enough for a small one.
inline constexpr double kLeastPilotPaths = 1 << 14, kMostPilotPaths = 1 << 17;

// Returns the frame of the pilot: the whole film, coarse, by path tracing, with random numbers of
// its own.
FrameView PilotView(const FrameView& frame);
// Returns all its samples as one tile.
Tile PilotTile(const FrameView& pilot);

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
