#include <algorithm>
#include <utility>

#include "wavefront/integrators/integrator.h"
#include "wavefront/stages/light_stages.h"
#include "wavefront/stages/path_stages.h"
#include "wavefront/stages/photon_stages.h"

namespace skywave {

void TracePhotonWave(const FrameView& frame, std::uint64_t first, std::uint32_t count,
                     const WantedPhotons& wanted, Worker& w, PhotonLists& lists) {
  StageClock clock(w.stats);
  soa::Table<RayColumns>*rays = &w.rays[0], *next = &w.rays[1];
  StartLightPaths(frame.options, first, count, w.paths);
  std::fill_n(w.photon->history->met, count, 0u);
  EmitRays(frame, count, *rays, w, clock);

  // Of light that is to be a caustic nothing else matters once it has met a surface with a density.
  const std::uint32_t first_kind = wanted.indirect ? 0 : kFirstDeltaBsdf;
  std::uint32_t n = count;
  for (std::uint32_t bounce = 1; n > 0; ++bounce) {
    IntersectLightPathSurfaces(frame, *rays, n, bounce, w, clock);
    StorePhotons(wanted, bounce, w, lists, clock);
    if (bounce == frame.options.max_depth) break;
    n = ScatterSurfaces(frame, kLightEnd, first_kind, bounce, *next, w, clock);
    std::swap(rays, next);
  }
  lists.caustic.SortByPath(count);
  lists.indirect.SortByPath(count);
  clock.Lap(Stage::kPhotons);
}

void RenderPhotonWave(const FrameView& frame, const WaveRange& range, Worker& w, Film& film) {
  StageClock clock(w.stats);
  soa::Table<RayColumns>*rays = &w.rays[0], *next = &w.rays[1];
  GenerateRays(frame, range, FilmUniforms(w.scratch), LensUniforms(w.scratch), w.paths, *rays);
  clock.Lap(Stage::kGenerate);

  std::uint32_t n = range.count, bounce = 0;
  bool delta_rays = true;
  for (; n > 0; ++bounce) {
    if (bounce == frame.options.max_depth || !delta_rays) {
      IntersectLights(frame, *rays, n, bounce, w, clock);
      break;
    }
    IntersectSurfaces(frame, *rays, n, bounce, /*only_delta=*/true, w, clock);
    KeepAovs(frame, bounce, range.count, w, film, clock);
    LightSurfaces(frame, bounce, w, clock);
    const std::uint32_t left = frame.options.max_depth - bounce;
    AddPhotons(frame, frame.photons->caustic, AreaCorrection::kVisibleCells, left, 1, w, clock);
    if (frame.options.photons.gather > 0) {
      GatherPhotons(frame, bounce, w, clock);
    } else {
      AddPhotons(frame, frame.photons->indirect, AreaCorrection::kVisibleCells, left, 1, w, clock);
    }
    n = ScatterSurfaces(frame, kCameraEnd, frame.first_bsdf_that_sees_light(), bounce, *next, w,
                        clock);
    delta_rays = w.ranges.total() > w.ranges.light_sampled();
    std::swap(rays, next);
  }
  FinishWave(range.count, bounce, w, film, clock);
}

}  // namespace skywave
