// This stage measures how much of the disks of photon lookups is surface.
#pragma once

#include <cstdint>

#include "kernels/light_paths/photon_cover.h"
#include "wavefront/frame.h"
#include "wavefront/stats.h"
#include "wavefront/worker.h"

namespace skywave {

// Writes what is seen of disks [0, n), n <= kLookupBlock; their heights are chosen here. The time
// that is on the clock before counts as looking photons up.
void CoverDisks(const FrameView& frame, PhotonDisk* disks, std::uint32_t n, RenderStats& stats,
                DiskSurface* surfaces, StageClock& clock);

}  // namespace skywave
