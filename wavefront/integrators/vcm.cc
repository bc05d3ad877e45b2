#include <utility>

#include "wavefront/integrators/integrator.h"
#include "wavefront/stages/bidirectional.h"
#include "wavefront/stages/light_stages.h"
#include "wavefront/stages/merging.h"
#include "wavefront/stages/path_stages.h"

namespace skywave {

void TraceVertexWave(const FrameView& frame, std::uint64_t first, std::uint32_t count, Worker& w,
                     PhotonList& list) {
  StageClock clock(w.stats);
  BidirectionalTables& b = *w.bidirectional;
  soa::Table<RayColumns>*rays = &w.rays[0], *next = &w.rays[1];
  StartLightPaths(frame.options, first, count, w.paths);
  EmitRays(frame, count, *rays, w, clock);
  LeaveLights(w.light->emission, count, b.light);
  std::uint32_t n = count;
  for (std::uint32_t bounce = 1; n > 0; ++bounce) {
    IntersectLightPathSurfaces(frame, *rays, n, bounce, w, clock);
    ArriveAtSurfaces(w.surfaces, w.ranges.total(), b.light, b.at);
    StoreVertices(bounce, w, list, clock);
    if (bounce == frame.options.max_depth) break;
    n = ScatterSubpaths(frame, kLightEnd, b.at, 0, bounce, *next, b.light, w, clock);
    std::swap(rays, next);
  }
  list.SortByPath(count);
  clock.Lap(Stage::kPhotons);
}

}  // namespace skywave
