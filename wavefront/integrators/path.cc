// Unidirectional path tracing (T 4.2.3, P 3). Every bounce takes one light sample and one BSDF
// sample, which multiple importance sampling combines. Russian roulette begins at the fourth
// bounce, and paths scatter at no more than max_depth surfaces. With the option `split` paths
// branch (split.cc). Where there are catchers, paths that objects may have changed are followed
// again without them (wavefront/stages/place.h).
#include "wavefront/integrators/path.h"

#include "wavefront/integrator.h"
#include "wavefront/paths/camera_paths.h"
#include "wavefront/stages/clamps.h"
#include "wavefront/stages/path_stages.h"
#include "wavefront/stages/place.h"
#include "wavefront/stages/projection.h"

namespace skywave {

void RenderPathWave(const FrameView& frame, const WaveRange& range, Worker& w, Film& film) {
  StageClock clock(w.stats);
  GenerateRays(frame, range, FilmUniforms(w.scratch), LensUniforms(w.scratch), w.paths, w.rays[0]);
  StartGroups(frame, range.count, film, w);
  KeepBackdrop(frame, w.rays[0], range.count, w, film);
  clock.Lap(Stage::kGenerate);
  const std::uint32_t end =
      FollowPaths(frame, FromOwnSurfaces(frame, w), range.count, 0, w, &film, clock);
  FinishWave(frame, range.count, end, w, film, clock);
  RenderPlace(frame, range, w, film, clock, [&](const FrameView& place, std::uint32_t n) {
    FollowPaths(place, FromOwnSurfaces(place, w), n, 0, w, nullptr, clock);
  });
}

namespace {

void RenderWholeOrSplitPaths(const FrameView& frame, const WaveRange& range, Worker& worker,
                             Film& film) {
  if (frame.options.bsdf_samples > 0) return RenderSplitWave(frame, range, worker, film);
  RenderPathWave(frame, range, worker, film);
}

}  // namespace

IntegratorDescriptor PathIntegrator() {
  return {.help = "paths from the camera; caustics of small lights stay noisy or are missed",
          .controls = true,
          .has_light_groups = true,
          .has_catchers = true,
          .options = PathOptions,
          .check = CheckClamps,
          .add_tables = AddPathTables,
          .render_wave = RenderWholeOrSplitPaths};
}

}  // namespace skywave
