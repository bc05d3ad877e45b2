#include <utility>

#include "kernels/partition.h"
#include "wavefront/integrators/integrator.h"
#include "wavefront/stages/bidirectional.h"
#include "wavefront/stages/light_stages.h"
#include "wavefront/stages/merging.h"
#include "wavefront/stages/path_stages.h"

namespace skywave {
namespace {

// Traces the light sub-paths of paths [0, n), splats their vertices and keeps them.
void TraceLightSubpaths(const FrameView& frame, std::uint32_t n, Worker& w, Film& film,
                        StageClock& clock) {
  BidirectionalTables& b = *w.bidirectional;
  soa::Table<RayColumns>*rays = &w.rays[0], *next = &w.rays[1];
  if (!b.vertices.empty()) {
    EmitRays(frame, n, *rays, w, clock);
    LeaveLights(w.light->emission, n, b.light);
  }
  std::uint32_t bounce = 0;
  for (LightVertices& vertices : b.vertices) {
    ++bounce;
    vertices.ranges = {};
    if (n == 0) continue;
    IntersectLightPathSurfaces(frame, *rays, n, bounce, w, clock);
    ArriveAtSurfaces(w.surfaces, w.ranges.total(), b.light, vertices.at);
    if (frame.shows(bounce + 1, 1)) {
      ConnectSurfaces(frame, bounce, w, clock);
      WeighCameraConnections(frame, vertices.at, w, clock);
      SplatConnections(frame, bounce, w, film, clock);
    }
    const bool last = bounce == b.vertices.size();
    n = last ? 0
             : ScatterSubpaths(frame, kLightEnd, vertices.at, 0, bounce, *next, b.light, w, clock);
    KeepVertices(w, vertices);
    std::swap(rays, next);
  }
}

}  // namespace

void RenderBdptWave(const FrameView& frame, const WaveRange& range, Worker& w, Film& film) {
  StageClock clock(w.stats);
  BidirectionalTables& b = *w.bidirectional;
  {
    const LensUniforms lens(w.scratch);
    GenerateRays(frame, range, FilmUniforms(w.scratch), lens, w.paths, b.eye_rays);
    LeaveCamera(frame, lens, range.count, w);
  }
  clock.Lap(Stage::kGenerate);
  TraceLightSubpaths(frame, range.count, w, film, clock);

  const std::uint32_t max_depth = frame.options.max_depth;
  soa::Table<RayColumns>*rays = &b.eye_rays, *next = &w.rays[0];
  std::uint32_t n = range.count, bounce = 0;
  for (; n > 0; ++bounce) {
    SortedHits sorted =
        TraceAndSort(frame, kCameraEnd, *rays, n, bounce, /*only_delta=*/false, w, clock);
    MoveEscaped(*rays, sorted.queues->queue, n, w.escaped);
    const std::uint32_t eye = bounce + 2;  // vertices, with the surfaces to come
    if (frame.shows(0, eye)) AddHitLight(frame, *rays, n, sorted.escaped, bounce, w, clock);
    if (bounce == max_depth) break;
    PrepareHits(frame, kCameraEnd, *rays, n, std::move(sorted), w, clock);
    KeepAovs(frame, bounce, range.count, w, film, clock);
    ArriveAtSurfaces(w.surfaces, w.ranges.total(), b.eye, b.at);
    if (frame.eta_vcm > 0) MergeSurfaces(frame, bounce, w, clock);
    if (frame.shows(1, eye)) ConnectLights(frame, bounce, w, clock);
    for (std::uint32_t light = 0; bounce + light + 2 <= max_depth; ++light) {
      if (frame.shows(light + 2, eye)) ConnectVertices(frame, bounce, light, w, clock);
    }
    const bool last = bounce + 1 == max_depth;
    const std::uint32_t first_kind = last ? frame.first_bsdf_that_sees_light() : 0;
    n = ScatterSubpaths(frame, kCameraEnd, b.at, first_kind, bounce, *next, b.eye, w, clock);
    std::swap(rays, next);
  }
  FinishWave(range.count, bounce, w, film, clock);
}

}  // namespace skywave
