// The camera paths that find out where light paths are needed (wavefront/emission_guide.h).
#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include "wavefront/emission_guide.h"
#include "wavefront/frame.h"
#include "wavefront/stages.h"
#include "wavefront/worker.h"

namespace skywave {

// Camera paths of the pilot, about.
inline constexpr std::uint32_t kPilotPaths = 1 << 16;

// The frame of the pilot: the whole film, coarse, by path tracing, with random numbers of its own.
FrameView PilotView(const FrameView& frame);
// All its samples: one tile.
Tile PilotTile(const FrameView& pilot);

// Traces paths `range` of the pilot and appends what they need of the sky. `radiance`: mean of each
// cell of directions, luminance. It stands for what rays over mirrors and glass see, which no light
// sample competes with: the few of them that meet a sun would rule all others.
void TracePilotWave(const FrameView& pilot, const WaveRange& range,
                    std::span<const double> radiance, Worker& w, std::vector<SkyNeed>& needs);

}  // namespace skywave
