// The first passes of `photon` and `vcm`: light paths in waves until the maps are full, or all of
// them.
#pragma once

#include <cstddef>
#include <cstdint>
#include <functional>
#include <memory>
#include <vector>

#include "wavefront/frame.h"
#include "wavefront/photon_map.h"
#include "wavefront/ray_recorder.h"
#include "wavefront/worker.h"

namespace skywave {

// What the first passes of `photon` or `vcm` have made.
struct PhotonCounts {
  std::uint64_t caustic = 0, indirect = 0;  // stored
  std::uint64_t light_paths = 0;            // that the fuller wish needed
  std::size_t bytes = 0;                    // of the maps of a pass, the most
  float radius = 0, caustic_radius = 0;     // largest distances of lookups in the last pass
  double seconds = 0;                       // wall clock

  void Add(const PhotonMaps& maps, double pass_seconds);
};

// One pass of a frame: samples [first_sample, first_sample + samples) of every pixel, and photons
// of their own.
struct PhotonPass {
  std::uint32_t first_sample, samples;
  float shrink;  // its radius over that of the first pass
};

// The passes of a frame: options.photons.passes of them, with radii that shrink as Knaus and
// Zwicker 2011 (eq. 15) have it: r_(i+1)^2 = r_i^2 (i + alpha) / (i + 1). Variance and bias of the
// mean of all passes then both vanish.
std::vector<PhotonPass> PhotonPasses(const RenderOptions& options);

// Traces light paths of `pass`, in progressive frames numbered from 2^32 first_sample on, and
// builds the maps: the
// photons of the first so many light paths that a map has as many as options.photons asks for.
// After kMostPathsAPhoton light paths for each photon asked for, maps stay as they are. The caller
// is in the arena whose threads the workers belong to; `recorders` as in RenderFrame. Bits depend
// on neither threads nor wave. Radii are those of a first pass.
inline constexpr std::uint64_t kMostPathsAPhoton = 64;
PhotonMaps TracePhotons(const FrameView& frame, const PhotonPass& pass,
                        std::vector<std::unique_ptr<Worker>>& workers,
                        std::vector<RayRecorder>* recorders);

// For each pass of a frame whose integrator has them (HasPhotons): traces its light paths and calls
// `render` with the frame as its samples see it. Other parameters as above. Of vcm, the first pass
// has the radius options.photons.distance; if that is 0, where a vertex has
// options.photons.neighbors others. Every pass has one light path for each of its paths, but no
// more than store options.photons.indirect vertices.
void ForEachPass(const FrameView& frame, std::vector<std::unique_ptr<Worker>>& workers,
                 std::vector<RayRecorder>* recorders, PhotonCounts& counts,
                 const std::function<void(const FrameView&)>& render);

}  // namespace skywave
