// The size of what a pixel sees bounds the radius in which photons are looked up.
#pragma once

#include "wavefront/frame.h"
#include "wavefront/worker_pool.h"

namespace skywave {

// Returns the largest radius of the first pass of lookups whose radius shrinks: two pixels where
// camera paths, through mirrors and glass, see surfaces with a density; the median over the film.
// Photons spread over all of a scene, so their distances alone would blur its small parts. The
// radius is infinite if no path sees such a surface, and the same for all parts of a picture.
float PixelRadius(const FrameView& frame, WorkerPool& pool);

}  // namespace skywave
