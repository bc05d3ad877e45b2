// The first passes of `vcm`: the vertices of light paths, all of them, in a map.
#pragma once

#include <cstdint>

#include "wavefront/frame.h"
#include "wavefront/photons/photon_map.h"
#include "wavefront/photons/photon_pass.h"
#include "wavefront/worker_pool.h"

namespace skywave {

// What all passes have in common: weights need to know beforehand how many light paths there will
// be and within which distance their vertices are merged.
struct MergePlan {
  std::uint64_t light_paths;  // of a pass
  float radius;               // of the first pass

  // MisTechniques::merged of a pass; weights take merges for fewer than they are.
  float MergedArea(const PhotonPass& pass) const;
};

// As many light paths as the shortest pass has paths, but no more than store
// options.photons.indirect vertices on average; a pass that has so many before ends there. The
// radius is options.photons.distance, or, if that is 0, half of the distance within which a vertex
// has options.photons.neighbors others. Both by light paths that are not used otherwise.
MergePlan PlanMerging(const FrameView& frame, WorkerPool& pool);

// The vertices of the light paths of `pass`; none where nothing is merged. `frame` has the area
// merged of this pass. Bits depend on neither threads nor wave.
PhotonMap TraceVertices(const FrameView& frame, const MergePlan& plan, const PhotonPass& pass,
                        WorkerPool& pool);

}  // namespace skywave
