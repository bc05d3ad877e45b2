// This stage measures how much of the disks of photon lookups is surface.
#pragma once

#include <cstdint>

#include "kernels/light_paths/photon_cover.h"
#include "wavefront/frame.h"
#include "wavefront/stats.h"
#include "wavefront/worker.h"

namespace skywave {

// Queries per batch.
inline constexpr std::uint32_t kLookupBlock = 16;

// Disks [0, count), count <= kLookupBlock, and what is seen of each.
struct CoveredDisks {
  PhotonKernel kernel;
  PhotonDisk* disks;
  DiskSurface* seen;
  std::uint32_t count;
};

// Writes what is seen of disks, whose heights are chosen here. The time
// that is on the clock before counts as looking photons up.
void CoverDisks(const FrameView& frame, const CoveredDisks& of, RenderStats& stats,
                StageClock& clock);

}  // namespace skywave
