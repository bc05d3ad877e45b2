// The first pass of `photon` traces light paths in waves until the maps are full.
#pragma once

#include <cstdint>
#include <functional>
#include <string>

#include "wavefront/frame.h"
#include "wavefront/integrator.h"
#include "wavefront/passes/photon_options.h"
#include "wavefront/records/photon_map.h"
#include "wavefront/worker_pool.h"

namespace skywave {

// Counts what the passes of light paths of a frame have made.
struct PhotonCounts {
  std::uint64_t caustic = 0, indirect = 0;  // photons that are stored
  std::uint64_t light_paths = 0;            // paths that the fuller map needed
  std::size_t bytes = 0;                    // largest size of the maps of a pass
  float radius = 0, caustic_radius = 0;     // largest distances of lookups in the last pass
  double seconds = 0;                       // wall clock

  void Add(const PhotonMaps& maps, double pass_seconds);
};

// These light paths predict what others will store. No pass uses their first number, because
// samples of a pixel end before it.
inline constexpr std::uint64_t kPlanningPaths = 1 << 14,
                               kFirstPlanningPath = std::uint64_t{0xFFFFFFFF} << 32;

// Traces light paths of `pass`, in progressive frames numbered from 2^32 times its first sample on,
// and builds the maps: the photons of the first light paths that together have as many as
// options.photons requests. After kMostPathsAPhoton light paths for each requested photon, maps
// stay as they are. Bits depend on neither threads nor wave. Radii are those of a first pass.
inline constexpr std::uint64_t kMostPathsAPhoton = 64;
PhotonMaps TracePhotons(const FrameView& frame, const PhotonPass& pass, WorkerPool& pool);

// Says what the passes of `photon` and `vcm` have made (IntegratorDescriptor::describe_passes).
std::string DescribePhotons(const PhotonCounts& counts);

// Calls `render` for the samples of the frame in each pass, with the maps that `trace` has made for
// it. `trace` may change the frame of its pass. Throws OptionError
// where there is no memory for so many photons.
using TracePass = std::function<PhotonMaps(FrameView& frame, const PhotonPass& pass)>;
void ForEachPhotonPass(const FrameView& frame, const TracePass& trace, PhotonCounts& counts,
                       const RenderPass& render);

}  // namespace skywave
