// Unidirectional path tracing (T 4.2.3, P 3). Every bounce takes one light sample and one BSDF
// sample, which multiple importance sampling combines. Russian roulette begins at the fourth
// bounce, and paths scatter at no more than max_depth surfaces. With the option `split` paths
// branch (split.cc).
#include "wavefront/integrators/path.h"

#include <algorithm>
#include <memory>
#include <utility>

#include "wavefront/integrators/integrators.h"
#include "wavefront/stages/path_stages.h"

namespace skywave {

std::uint32_t FollowPaths(const FrameView& frame, const Departure& first, std::uint32_t n,
                          std::uint32_t bounce, Worker& w, Film* film, StageClock& clock) {
  soa::Table<RayColumns>*rays = &w.rays[0], *next = &w.rays[1];
  Departure own = FromOwnSurfaces(frame, w);
  const Departure* from = &first;
  if (frame.geometry->has_deltas()) {
    // Paths that do not begin at the camera begin at surfaces with a density.
    std::fill_n(w.history->met, w.history.rows(), bounce == 0 ? 0 : kMetDense);
    own.met = w.history->met;
  }
  const std::uint32_t paths = n;
  for (; n > 0; ++bounce, from = &own) {
    if (bounce == frame.options.max_depth) {
      IntersectLights(frame, *rays, n, bounce, *from, w, clock);
      break;
    }
    IntersectSurfaces(frame, *rays, n, bounce, /*only_delta=*/false, *from, w, clock);
    if (own.met != nullptr) RememberSurfaces(w);
    if (film != nullptr) KeepAovs(frame, bounce, paths, w, *film, clock);
    LightSurfaces(frame, bounce, w, clock);
    const bool last = bounce + 1 == frame.options.max_depth;
    const std::uint32_t first_kind = last ? frame.first_bsdf_that_sees_light() : 0;
    n = ScatterSurfaces(frame, kCameraEnd, first_kind, bounce, *next, w, clock);
    std::swap(rays, next);
  }
  return bounce;
}

void RenderPathWave(const FrameView& frame, const WaveRange& range, Worker& w, Film& film) {
  StageClock clock(w.stats);
  GenerateRays(frame, range, FilmUniforms(w.scratch), LensUniforms(w.scratch), w.paths, w.rays[0]);
  StartGroups(frame, range.count, film, w);
  clock.Lap(Stage::kGenerate);
  const std::uint32_t end =
      FollowPaths(frame, FromOwnSurfaces(frame, w), range.count, 0, w, &film, clock);
  FinishWave(frame, range.count, end, w, film, clock);
}

namespace {

void AddTables(const RenderOptions& options, Worker& worker) {
  if (options.split > 0) worker.continuations = std::make_unique<Continuations>(options.wave);
}

void RenderWholeOrSplitPaths(const FrameView& frame, const WaveRange& range, Worker& worker,
                             Film& film) {
  if (frame.splits()) return RenderSplitWave(frame, range, worker, film);
  RenderPathWave(frame, range, worker, film);
}

}  // namespace

IntegratorDescriptor PathIntegrator() {
  return {.help = "paths from the camera; caustics of small lights stay noisy or are missed",
          .splits = true,
          .controls = true,
          .has_light_groups = true,
          .add_tables = AddTables,
          .render_wave = RenderWholeOrSplitPaths};
}

}  // namespace skywave
