// The first pass of `photon` traces light paths in waves until the maps are full.
#pragma once

#include <cstdint>
#include <functional>
#include <vector>

#include "wavefront/frame.h"
#include "wavefront/integrator.h"
#include "wavefront/records/photon_map.h"
#include "wavefront/worker_pool.h"

namespace skywave {

// A pass of a picture has photons of its own.
struct PhotonPass {
  SampleRange samples;
  float shrink;  // its radius over that of the first pass
};

// Counts what the passes of light paths of a frame have made.
struct PhotonCounts {
  std::uint64_t caustic = 0, indirect = 0;  // photons that are stored
  std::uint64_t light_paths = 0;            // paths that the fuller map needed
  std::size_t bytes = 0;                    // largest size of the maps of a pass
  float radius = 0, caustic_radius = 0;     // largest distances of lookups in the last pass
  double seconds = 0;                       // wall clock

  void Add(const PhotonMaps& maps, double pass_seconds);
};

// Returns the passes of a picture: options.photons.passes of them. 0 means one, or one for each
// sample (IntegratorDescriptor::pass_each_sample), with radii that go by the number of the sample.
// A frame that has some of the picture's samples renders parts of some of the passes. Radii shrink
// as in Knaus and Zwicker 2011 (eq. 15): r_(i+1)^2 = r_i^2 (i + alpha) / (i + 1). Variance and bias
// of the mean of all passes then both vanish.
std::vector<PhotonPass> PhotonPasses(const RenderOptions& options);

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

// Calls `render` for the samples of the frame in each pass, with the maps that `trace` has made for
// it. `trace` may change the frame of its pass.
using TracePass = std::function<PhotonMaps(FrameView& frame, const PhotonPass& pass)>;
void ForEachPhotonPass(const FrameView& frame, const TracePass& trace, PhotonCounts& counts,
                       const RenderPass& render);

}  // namespace skywave
