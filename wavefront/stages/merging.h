// The stages of sub-paths that are merged: their vertices are stored where light paths arrive, and
// found again near where paths from the eye do.
#pragma once

#include <cstdint>

#include "wavefront/frame.h"
#include "wavefront/stages/photon_stages.h"
#include "wavefront/worker.h"

namespace skywave {

// Stores the surfaces of bounce `depth` of light sub-paths that have a density, with what is known
// of their sub-paths, BidirectionalTables::at.
void StoreVertices(std::uint32_t depth, Worker& w, PhotonList& list, StageClock& clock);

// Adds what the eye's current surfaces, whose sub-paths are BidirectionalTables::at, reflect of the
// light vertices within the radius of the pass, weighted against all other techniques that make
// these paths. The surfaces are those of `bounce`.
void MergeSurfaces(const FrameView& frame, std::uint32_t bounce, Worker& w, StageClock& clock);

}  // namespace skywave
