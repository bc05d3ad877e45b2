// Instant radiosity (Keller 1997). Every sample of the picture has a set of light paths, whose
// vertices shine as virtual point lights (passes/virtual_light_pass.cc) on the first surface of
// each camera path that is neither mirror nor glass. That surface also takes direct light as
// `direct` does, and there are no more than max_depth surfaces on both sides of a connection
// together. Sets are new for each sample, so their noise averages out; the light lost by the bound
// on near lights is not recovered. Light that mirrors and glass cast on visible surfaces is
// missing.
#include <fmt/format.h>

#include <span>
#include <string>
#include <utility>

#include "base/clock.h"
#include "wavefront/integrator.h"
#include "wavefront/passes/photon_pass.h"
#include "wavefront/passes/virtual_light_pass.h"
#include "wavefront/render_option.h"
#include "wavefront/stages/light_stages.h"
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

std::span<const RenderOption> Options() {
  // clang-format off
  static const RenderOption table[] = {
      MakeRenderOption({.name = "vpls", .group = "Virtual point lights (vpl)", .help = "virtual point lights of each sample, on average", .scope = OptionScope::kPixels, .example = "--integrator vpl --vpls 9"},
                       SKYWAVE_FIELD_OF(VirtualLightOptions, count), Numbers(1u, kMostVirtualLights)),
      MakeRenderOption({.name = "vpl-distance", .group = "Virtual point lights (vpl)", .help = "nearer virtual lights shine as from this distance, which darkens corners; 0: unbiased, with bright spots there", .scope = OptionScope::kPixels, .example = "--integrator vpl --vpl-distance 0.1", .default_text = "half of that between virtual lights"},
                       SKYWAVE_FIELD_OF(VirtualLightOptions, distance), Unless(-1.0f, Floats(0, 1e12))),
  };
  // clang-format on
  return table;
}

void AddTables(const RenderOptions& options, Worker& worker) {
  AddLightPathTables(options, worker);
  worker.tables.Add<VirtualLightTables>(options.wave);
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
    view.Show(&set);
    view.options.first_sample = sample, view.options.samples_per_pixel = 1;
    if (!render(view)) return;
    start = Clock::now();
  }
}

std::string DescribePasses(const PhotonCounts& counts) {
  return fmt::format(
      "virtual lights: {} of {} light paths in {:.3f} s, shining as from {:.4g} at least",
      counts.indirect, counts.light_paths, counts.seconds, counts.radius);
}

}  // namespace

IntegratorDescriptor VplIntegrator() {
  return {.help = "virtual point lights on light paths; biased: corners are too dark",
          .light_samples = LightSamples::kRequested,
          .light_paths = LightPaths::kAny,
          .biased = true,
          .mixes_light = true,
          .options = Options,
          .add_tables = AddTables,
          .for_each_pass = ForEachPass,
          .describe_passes = DescribePasses,
          .render_wave = RenderVplWave};
}

}  // namespace skywave
