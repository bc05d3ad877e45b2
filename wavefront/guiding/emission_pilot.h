// The camera paths that find out where light paths are needed (wavefront/guiding/emission_guide.h).
#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include "wavefront/frame.h"
#include "wavefront/guiding/guide_sample.h"
#include "wavefront/stages/stages.h"
#include "wavefront/worker.h"

namespace skywave {

// Camera paths of the pilot, about: few of a usual render, enough of a small one.
inline constexpr double kLeastPilotPaths = 1 << 14, kMostPilotPaths = 1 << 17;

// The frame of the pilot: the whole film, coarse, by path tracing, with random numbers of its own.
FrameView PilotView(const FrameView& frame);
// All its samples: one tile.
Tile PilotTile(const FrameView& pilot);

// What counts as needed.
struct PilotQuestion {
  // Mean luminance of each cell of directions. It stands for what rays over mirrors and glass see,
  // which no light sample competes with: the few of them that meet a sun would rule all others.
  std::span<const double> radiance;
  // Surfaces with a density between the sky and the eye, at least. Light over mirrors and glass to
  // one of them, a caustic, is always needed; over none of them, light paths bring nothing.
  std::uint32_t least_surfaces = 1;
};

// Traces paths `range` of the pilot and appends what they need of the sky.
void TracePilotWave(const FrameView& pilot, const WaveRange& range, const PilotQuestion& question,
                    Worker& w, std::vector<GuideSample>& samples);

}  // namespace skywave
