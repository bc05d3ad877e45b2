#include "wavefront/integrator.h"

#include <utility>

#include "wavefront/checks.h"
#include "wavefront/path_stages.h"

namespace skywave {

void RenderPathWave(const FrameView& frame, const WaveRange& range, Worker& w, Film& film) {
  StageClock clock(w.stats);
  soa::Table<RayColumns>*rays = &w.rays[0], *next = &w.rays[1];
  GenerateRays(frame, range, w.uniforms, w.lobe, w.paths, *rays);
  clock.Lap(Stage::kGenerate);

  std::uint32_t n = range.count, bounce = 0;
  for (; n > 0; ++bounce) {
    CheckRays(*rays, n);
    CountRays(w.stats, bounce, n, w.paths.rows());
    if (bounce == frame.options.max_depth) {
      MeetLight(frame, *rays, n, bounce, w, clock);
      break;
    }
    MeetSurfaces(frame, *rays, n, bounce, /*only_delta=*/false, w, clock);
    KeepAovs(frame, bounce, range.count, w, film, clock);
    LightSurfaces(frame, bounce, w, clock);
    const bool last = bounce + 1 == frame.options.max_depth;
    const std::uint32_t first_kind = last ? frame.first_bsdf_that_sees_light() : 0;
    n = Scatter(frame, kCameraEnd, w.paths, w.surfaces, w.ranges, first_kind, bounce, w.uniforms,
                w.lobe, *next);
    CountScattering(w.ranges, first_kind, w.stats.lanes);
    clock.Lap(Stage::kScatter);
    std::swap(rays, next);
  }
  FinishWave(range.count, bounce, w, film, clock);
}

}  // namespace skywave
