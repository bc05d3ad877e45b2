// Irradiance caching (Ward, Rubinstein and Clear 1988; Ward and Heckbert 1992). Diffuse surfaces
// take direct light as `direct` does and interpolate all other light between records of a first
// pass (passes/irradiance_pass.cc); there paths end. Other surfaces scatter as those of `path`
// do, and so do diffuse ones where no record counts. Irradiance between records is what these
// suggest, so small things are blurred and the noise of the records is seen as blotches. Paths of
// records begin at their surfaces: with a mirror in between they are a surface longer than
// max_depth.
#include <fmt/format.h>

#include <span>
#include <string>
#include <utility>

#include "base/clock.h"
#include "wavefront/integrator.h"
#include "wavefront/passes/irradiance_pass.h"
#include "wavefront/passes/photon_pass.h"
#include "wavefront/render_option.h"
#include "wavefront/stages/irradiance_stages.h"
#include "wavefront/stages/path_stages.h"

namespace skywave {
namespace {

void RenderCachedWave(const FrameView& frame, const WaveRange& range, Worker& w, Film& film) {
  StageClock clock(w.stats);
  soa::Table<RayColumns>*rays = &w.rays[0], *next = &w.rays[1];
  GenerateRays(frame, range, FilmUniforms(w.scratch), LensUniforms(w.scratch), w.paths, *rays);
  clock.Lap(Stage::kGenerate);

  std::uint32_t n = range.count, bounce = 0;
  for (; n > 0; ++bounce) {
    if (bounce == frame.options.max_depth) {
      IntersectLights(frame, *rays, n, bounce, w, clock);
      break;
    }
    IntersectSurfaces(frame, *rays, n, bounce, /*only_delta=*/false, w, clock);
    KeepAovs(frame, bounce, range.count, w, film, clock);
    LightSurfaces(frame, bounce, w, clock);
    AddCachedIrradiance(frame, w, clock);
    const bool last = bounce + 1 == frame.options.max_depth;
    const std::uint32_t first_kind = last ? frame.first_bsdf_that_sees_light() : 0;
    n = ScatterSurfaces(frame, kCameraEnd, first_kind, bounce, *next, w, clock);
    std::uint32_t ended = 0;
    n = EndCachedPaths(*next, n, w, ended);
    if (ended > 0)
      IntersectLights(frame, w.of<IrradianceTables>().ended, ended, bounce + 1, w, clock);
    std::swap(rays, next);
  }
  FinishWave(frame, range.count, bounce, w, film, clock);
}

std::span<const RenderOption> Options() {
  // clang-format off
  static const RenderOption table[] = {
      MakeRenderOption({.name = "cache-accuracy", .group = "Irradiance cache (irradiance-cache)", .help = "largest error at which a record of the irradiance cache counts; smaller: more records", .scope = OptionScope::kPixels, .example = "--integrator irradiance-cache --cache-accuracy 0.4"},
                       SKYWAVE_FIELD_OF(IrradianceCacheOptions, accuracy), Floats(0.01, 1)),
      MakeRenderOption({.name = "cache-rays", .group = "Irradiance cache (irradiance-cache)", .help = "rays of the hemisphere of a record", .scope = OptionScope::kPixels, .example = "--integrator irradiance-cache --cache-rays 50"},
                       SKYWAVE_FIELD_OF(IrradianceCacheOptions, rays), Numbers(4u, 1u << 16)),
  };
  // clang-format on
  return table;
}

void AddTables(const RenderOptions& options, Worker& worker) {
  worker.tables.Add<IrradianceTables>(options.wave);
}

void ForEachPass(const FrameView& frame, WorkerPool& pool, PhotonCounts& counts,
                 const RenderPass& render) {
  const auto start = Clock::now();
  const IrradianceCache cache = MakeIrradianceCache(frame, pool);
  counts.indirect = cache.records().size(), counts.bytes = cache.bytes();
  counts.seconds = SecondsSince(start);
  FrameView view = frame;
  view.Show(&cache);
  render(view);
}

std::string DescribePasses(const PhotonCounts& counts) {
  return fmt::format("irradiance cache: {} records in {:.3f} s, {:.1f} MiB", counts.indirect,
                     counts.seconds, double(counts.bytes) / (1 << 20));
}

}  // namespace

IntegratorDescriptor IrradianceCacheIntegrator() {
  return {.help = "light between diffuse surfaces from an irradiance cache; biased: blurred",
          .light_samples = LightSamples::kRequested,
          .biased = true,
          .mixes_light = true,
          .options = Options,
          .add_tables = AddTables,
          .for_each_pass = ForEachPass,
          .describe_passes = DescribePasses,
          .render_wave = RenderCachedWave};
}

}  // namespace skywave
