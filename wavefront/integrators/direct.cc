// Direct light (T 4.2.1). The first surface that is neither mirror nor glass takes light_samples
// light samples and one BSDF sample against them, or `split` of them (split.cc). Mirrors and glass
// are followed over up to max_depth surfaces.
#include <utility>

#include "wavefront/integrator.h"
#include "wavefront/integrators/path.h"
#include "wavefront/stages/clamps.h"
#include "wavefront/stages/path_stages.h"
#include "wavefront/stages/place.h"
#include "wavefront/stages/projection.h"
#include "wavefront/stages/terminator.h"

namespace skywave {
namespace {

// Follows rays [0, n) of w.rays[0], which begin paths; returns the bounce at which the last one
// ended. `film` is that of FollowPaths.
std::uint32_t FollowDirect(const FrameView& frame, std::uint32_t n, Worker& w, Film* film,
                           StageClock& clock) {
  soa::Table<RayColumns>*rays = &w.rays[0], *next = &w.rays[1];
  const std::uint32_t paths = n;
  std::uint32_t bounce = 0;
  bool delta_rays = true;
  for (; n > 0; ++bounce) {
    if (bounce == frame.options.max_depth || !delta_rays) {
      IntersectLights(frame, *rays, n, bounce, w, clock);
      break;
    }
    IntersectSurfaces(frame, *rays, n, bounce, /*only_delta=*/true, w, clock);
    ClampDirect(frame, bounce, w);
    if (film != nullptr) KeepAovs(frame, bounce, paths, w, *film, clock);
    RoundTerminator(frame, w);
    LightSurfaces(frame, bounce, w, clock);
    n = ScatterSurfaces(frame, kCameraEnd, frame.first_bsdf_that_sees_light(), bounce, *next, w,
                        clock);
    delta_rays = w.ranges.total() > w.ranges.light_sampled();
    std::swap(rays, next);
  }
  ClampDirectOfEnded(frame, bounce, w);
  ClampIndirectAndWhole(frame, w);
  return bounce;
}

void RenderDirectWave(const FrameView& frame, const WaveRange& range, Worker& w, Film& film) {
  StageClock clock(w.stats);
  GenerateRays(frame, range, FilmUniforms(w.scratch), LensUniforms(w.scratch), w.paths, w.rays[0]);
  StartGroups(frame, range.count, film, w);
  KeepBackdrop(frame, w.rays[0], range.count, w, film);
  clock.Lap(Stage::kGenerate);
  const std::uint32_t end = FollowDirect(frame, range.count, w, &film, clock);
  FinishWave(frame, range.count, end, w, film, clock);
  RenderPlace(frame, range, w, film, clock, [&](const FrameView& place, std::uint32_t n) {
    FollowDirect(place, n, w, nullptr, clock);
  });
}

void RenderWholeOrSplit(const FrameView& frame, const WaveRange& range, Worker& w, Film& film) {
  if (frame.options.bsdf_samples > 0) return RenderSplitWave(frame, range, w, film);
  RenderDirectWave(frame, range, w, film);
}

}  // namespace

IntegratorDescriptor DirectIntegrator() {
  return {.help = "light over mirrors and glass at most",
          .direct_light_only = true,
          .light_samples = LightSamples::kRequested,
          .controls = true,
          .has_light_groups = true,
          .has_catchers = true,
          .options = PathOptions,
          .check = CheckClamps,
          .add_tables = AddPathTables,
          .render_wave = RenderWholeOrSplit};
}

}  // namespace skywave
