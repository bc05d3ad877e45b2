// The first passes of `vcm` put all vertices of light paths into a map.
#pragma once

#include <cstdint>

#include "wavefront/frame.h"
#include "wavefront/passes/photon_pass.h"
#include "wavefront/records/photon_map.h"
#include "wavefront/worker_pool.h"

namespace skywave {

// All passes have this in common: weights need to know beforehand how many light paths there will
// be and within which distance their vertices are merged.
struct MergePlan {
  std::uint64_t light_paths;  // per pass
  float radius;               // in the first pass

  // Returns MisTechniques::eta_vcm of a pass; it counts merges as fewer than they are.
  float MergedArea(const PhotonPass& pass) const;
};

// Plans as many light paths as the shortest pass has paths, but no more than store
// options.photons.indirect vertices on average; a pass that has so many before ends there. The
// radius is options.photons.distance, or, if that is 0, half of the distance within which a vertex
// has options.photons.neighbors others. Both are found by light paths that are not used otherwise.
MergePlan PlanMerging(const FrameView& frame, WorkerPool& pool);

// Traces the vertices of the light paths of `pass`; there are none if nothing is merged. `frame`
// shows the Merging of this pass. Bits depend on neither threads nor wave.
PhotonMap TraceVertices(const FrameView& frame, const MergePlan& plan, const PhotonPass& pass,
                        WorkerPool& pool);

}  // namespace skywave
