// The first pass of `photon`: light paths in waves until the maps are full.
#pragma once

#include <cstdint>
#include <functional>
#include <vector>

#include "wavefront/frame.h"
#include "wavefront/integrators/integrators.h"
#include "wavefront/photons/photon_map.h"
#include "wavefront/worker_pool.h"

namespace skywave {

// Whether there are mirrors or glass for light to come from.
bool HasCaustics(const Geometry& geometry);

// One pass of a frame: samples [first_sample, first_sample + samples) of every pixel, and photons
// of their own.
struct PhotonPass {
  std::uint32_t first_sample, samples;
  float shrink;  // its radius over that of the first pass
};

// What the passes of light paths of a frame have made.
struct PhotonCounts {
  std::uint64_t caustic = 0, indirect = 0;  // stored
  std::uint64_t light_paths = 0;            // that the fuller map needed
  std::size_t bytes = 0;                    // of the maps of a pass, the most
  float radius = 0, caustic_radius = 0;     // largest distances of lookups in the last pass
  double seconds = 0;                       // wall clock

  void Add(const PhotonMaps& maps, double pass_seconds);
};

// The passes of a frame: options.photons.passes of them; 0: one, or one for each sample
// (IntegratorDescriptor::pass_each_sample), whose radii go by the number of the sample. Radii
// shrink as Knaus and Zwicker 2011 (eq. 15) have it: r_(i+1)^2 = r_i^2 (i + alpha) / (i + 1).
// Variance and bias of the mean of all passes then both vanish.
std::vector<PhotonPass> PhotonPasses(const RenderOptions& options);

// Traces light paths of `pass`, in progressive frames numbered from 2^32 first_sample on, and
// builds the maps: the photons of the first so many light paths that a map has as many as
// options.photons asks for. After kMostPathsAPhoton light paths for each photon asked for, maps
// stay as they are. Bits depend on neither threads nor wave. Radii are those of a first pass.
inline constexpr std::uint64_t kMostPathsAPhoton = 64;
PhotonMaps TracePhotons(const FrameView& frame, const PhotonPass& pass, WorkerPool& pool);

// Calls `render` for each pass of a frame, whose maps are those that `trace` has made before of the
// frame that it may change.
using TracePass = std::function<PhotonMaps(FrameView& frame, const PhotonPass& pass)>;
void ForEachPhotonPass(const FrameView& frame, const TracePass& trace, PhotonCounts& counts,
                       const RenderPass& render);

}  // namespace skywave
