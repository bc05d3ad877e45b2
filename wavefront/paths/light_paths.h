// Follows paths from lights.
#pragma once

#include <cstdint>
#include <utility>

#include "wavefront/frame.h"
#include "wavefront/stages/bidirectional.h"
#include "wavefront/stages/light_stages.h"
#include "wavefront/stages/path_stages.h"
#include "wavefront/worker.h"

namespace skywave {

// Follows light paths [first, first + count) of the frame over at most `depth` surfaces and calls
// store(bounce) for the current surfaces of each bounce from 1 on. Those of BSDFs [first_kind,
// kBsdfKinds) scatter.
template <class Store>
void FollowLightPaths(const FrameView& frame, std::uint64_t first, std::uint32_t count,
                      std::uint32_t first_kind, std::uint32_t depth, Worker& w, StageClock& clock,
                      const Store& store) {
  soa::Table<RayColumns>*rays = &w.rays[0], *next = &w.rays[1];
  StartLightPaths(frame.options, first, count, w.paths);
  EmitRays(frame, count, *rays, w, clock);
  std::uint32_t n = count;
  for (std::uint32_t bounce = 1; n > 0; ++bounce) {
    IntersectLightPathSurfaces(frame, *rays, n, bounce, w, clock);
    store(bounce);
    if (bounce == depth) break;
    n = ScatterSurfaces(frame, kLightEnd, first_kind, bounce, *next, w, clock);
    std::swap(rays, next);
  }
}

// The same with what weights of connections need: calls store(bounce) with the sub-paths of the
// current surfaces in BidirectionalTables::at. All surfaces scatter.
template <class Store>
void FollowLightSubpaths(const FrameView& frame, std::uint64_t first, std::uint32_t count,
                         Worker& w, StageClock& clock, const Store& store) {
  BidirectionalTables& b = w.of<BidirectionalTables>();
  soa::Table<RayColumns>*rays = &w.rays[0], *next = &w.rays[1];
  StartLightPaths(frame.options, first, count, w.paths);
  EmitRays(frame, count, *rays, w, clock);
  LeaveLights(w.of<LightPathTables>().emission, count, b.light);
  std::uint32_t n = count;
  for (std::uint32_t bounce = 1; n > 0; ++bounce) {
    IntersectLightPathSurfaces(frame, *rays, n, bounce, w, clock);
    ArriveAtSurfaces(w.surfaces, w.ranges.total(), b.light, b.at);
    store(bounce);
    if (bounce == frame.options.max_depth) break;
    n = ScatterSubpaths(frame, kLightEnd, b.at, 0, bounce, *next, b.light, w, clock);
    std::swap(rays, next);
  }
}

}  // namespace skywave
