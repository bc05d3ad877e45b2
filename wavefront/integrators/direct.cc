// Direct light (T 4.2.1). The first surface that is neither mirror nor glass takes light_samples
// light samples and one BSDF sample against them. Mirrors and glass are followed over up to
// max_depth surfaces.
#include <utility>

#include "wavefront/integrator.h"
#include "wavefront/stages/path_stages.h"

namespace skywave {
namespace {

void RenderDirectWave(const FrameView& frame, const WaveRange& range, Worker& w, Film& film) {
  StageClock clock(w.stats);
  soa::Table<RayColumns>*rays = &w.rays[0], *next = &w.rays[1];
  GenerateRays(frame, range, FilmUniforms(w.scratch), LensUniforms(w.scratch), w.paths, *rays);
  StartGroups(frame, range.count, film, w);
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
    n = ScatterSurfaces(frame, kCameraEnd, frame.first_bsdf_that_sees_light(), bounce, *next, w,
                        clock);
    delta_rays = w.ranges.total() > w.ranges.light_sampled();
    std::swap(rays, next);
  }
  FinishWave(frame, range.count, bounce, w, film, clock);
}

}  // namespace

IntegratorDescriptor DirectIntegrator() {
  return {.help = "light over mirrors and glass at most",
          .direct_light_only = true,
          .light_samples = LightSamples::kRequested,
          .controls = true,
          .has_light_groups = true,
          .render_wave = RenderDirectWave};
}

}  // namespace skywave
