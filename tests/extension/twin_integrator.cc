// Direct light under another name, with an option, a table of a worker and data of a pass of its
// own, which scale the picture.
#include <algorithm>
#include <span>
#include <utility>
#include <vector>

#include "wavefront/integrator.h"
#include "wavefront/render_option.h"
#include "wavefront/stages/path_stages.h"
#include "wavefront/worker_pool.h"

namespace skywave {
namespace {

struct TwinOptions {
  float gain = 1;
};

struct TwinTables {
  explicit TwinTables(std::uint32_t wave) : gains(wave) {}
  std::vector<float> gains;
};

struct TwinPass {
  float gain;
};

std::span<const RenderOption> Options() {
  static const RenderOption table[] = {
      MakeRenderOption({.name = "twin-gain",
                        .help = "factor of the picture",
                        .scope = OptionScope::kPixels,
                        .example = "--integrator twin --twin-gain 2"},
                       SKYWAVE_FIELD_OF(TwinOptions, gain), Floats(0, 8))};
  return table;
}

void AddTables(const RenderOptions& options, Worker& worker) {
  worker.tables.Add<TwinTables>(options.wave);
}

void ForEachPass(const FrameView& frame, WorkerPool&, PhotonCounts&, const RenderPass& render) {
  const TwinPass pass = {.gain = frame.options.of<TwinOptions>().gain};
  FrameView view = frame;
  view.Show(&pass);
  render(view);
}

void Amplify(const FrameView& frame, std::uint32_t n, Worker& w) {
  std::vector<float>& gains = w.of<TwinTables>().gains;
  std::fill(gains.begin(), gains.end(), frame.find<TwinPass>()->gain);
  const PathColumns& paths = w.paths;
  for (std::uint32_t i = 0; i < n; ++i) {
    paths.r[i] *= gains[i], paths.g[i] *= gains[i], paths.b[i] *= gains[i];
  }
}

// Mirrors and glass are followed; the first other surface takes light samples and sees lights.
void RenderWave(const FrameView& frame, const WaveRange& range, Worker& w, Film& film) {
  StageClock clock(w.stats);
  soa::Table<RayColumns>*rays = &w.rays[0], *next = &w.rays[1];
  GenerateRays(frame, range, FilmUniforms(w.scratch), LensUniforms(w.scratch), w.paths, *rays);
  StartGroups(frame, range.count, film, w);
  clock.Lap(Stage::kGenerate);
  std::uint32_t bounce = 0;
  bool delta_rays = true;
  for (std::uint32_t n = range.count; n > 0; ++bounce) {
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
  Amplify(frame, range.count, w);
  FinishWave(frame, range.count, bounce, w, film, clock);
}

}  // namespace

IntegratorDescriptor TwinIntegrator() {
  return {.help = "direct light, brighter",
          .direct_light_only = true,
          .light_samples = LightSamples::kRequested,
          .has_light_groups = true,
          .options = Options,
          .add_tables = AddTables,
          .for_each_pass = ForEachPass,
          .render_wave = RenderWave};
}

}  // namespace skywave
