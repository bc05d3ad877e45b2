// Instant radiosity (Keller 1997). Every sample of the picture has a set of light paths, whose
// vertices shine as virtual point lights (passes/virtual_light_pass.cc) on the first surface of
// each camera path that is neither mirror nor glass. That surface also takes direct light as
// `direct` does, and there are no more than max_depth surfaces on both sides of a connection
// together. Sets are new for each sample, so their noise averages out; the light lost by the bound
// on near lights is not recovered. Light that mirrors and glass cast on visible surfaces is
// missing.
#include <utility>

#include "base/clock.h"
#include "wavefront/integrator.h"
#include "wavefront/passes/photon_pass.h"
#include "wavefront/passes/virtual_light_pass.h"
#include "wavefront/stages/path_stages.h"
#include "wavefront/stages/virtual_light_stages.h"

namespace skywave {
namespace {

void RenderVplWave(const FrameView& frame, const WaveRange& range, Worker& w, Film& film) {
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
    AddVirtualLights(frame, bounce, w, clock);
    n = ScatterSurfaces(frame, kCameraEnd, frame.first_bsdf_that_sees_light(), bounce, *next, w,
                        clock);
    delta_rays = w.ranges.total() > w.ranges.light_sampled();
    std::swap(rays, next);
  }
  FinishWave(frame, range.count, bounce, w, film, clock);
}

void AddTables(const RenderOptions& options, Worker& worker) {
  worker.virtual_lights.emplace(options.wave);
}

void ForEachPass(const FrameView& frame, WorkerPool& pool, PhotonCounts& counts,
                 const RenderPass& render) {
  auto start = Clock::now();
  const VirtualLightPlan plan = PlanVirtualLights(frame, pool);
  const SampleRange samples = SamplesOf(frame.options);
  for (std::uint32_t sample = samples.first; sample < samples.end; ++sample) {
    const VirtualLights set = TraceVirtualLights(frame, plan, sample, pool);
    counts.indirect += set.lights.size(), counts.light_paths += set.light_paths;
    counts.radius = set.distance;
    counts.seconds += SecondsSince(start);
    FrameView view = frame;
    view.virtual_lights = &set;
    view.options.first_sample = sample, view.options.samples_per_pixel = 1;
    if (!render(view)) return;
    start = Clock::now();
  }
}

}  // namespace

IntegratorDescriptor VplIntegrator() {
  return {.help = "virtual point lights on light paths; biased: corners are too dark",
          .light_samples = LightSamples::kRequested,
          .light_paths = LightPaths::kAny,
          .stores = StoredLight::kLights,
          .biased = true,
          .mixes_light = true,
          .add_tables = AddTables,
          .for_each_pass = ForEachPass,
          .render_wave = RenderVplWave};
}

}  // namespace skywave
