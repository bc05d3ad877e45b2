// Path tracing that splits (T fig. 8.26, the integrator PT2). At the first surface that is neither
// mirror nor glass a path takes all its direct light, light_samples light samples, and goes on as
// `split` continuations, whose mean is its indirect light. Continuations are paths like those of
// RenderPathWave, with light samples of the frame's strategy for continuations. With direct light
// alone they only see lights: the surface takes `split` BSDF samples (T 4.2.1).
#include <algorithm>
#include <span>
#include <utility>
#include <vector>

#include "wavefront/integrator.h"
#include "wavefront/integrators/path.h"
#include "wavefront/paths/camera_paths.h"
#include "wavefront/policy.h"
#include "wavefront/stages/clamps.h"
#include "wavefront/stages/links.h"
#include "wavefront/stages/path_stages.h"
#include "wavefront/stages/place.h"
#include "wavefront/stages/terminator.h"

namespace skywave {
namespace {

// A continuation has the row, seed and pixel of its path, and a sample number of its own.
void StartContinuations(const PathColumns& paths, std::uint32_t n, const Continuations& c) {
  std::copy_n(paths.seed, n, c.wave.paths->seed);
  std::copy_n(paths.pixel, n, c.wave.paths->pixel);
  for (float* column :
       {c.wave.paths->r, c.wave.paths->g, c.wave.paths->b, c.direct->r, c.direct->g, c.direct->b}) {
    std::fill_n(column, n, 0.0f);
  }
}

// Continuation `index` of `split`: points sample * split + index of every pair of dimensions that
// it uses, so that all continuations of a pixel are stratified among themselves.
void NumberContinuations(const PathColumns& paths, std::uint32_t n, std::uint32_t split,
                         std::uint32_t index, const PathColumns& continuations) {
  for (std::uint32_t i = 0; i < n; ++i) {
    continuations.sample[i] = paths.sample[i] * split + index;
  }
}

// Moves the mean over continuations of what `sums` holds to paths [0, n).
void AddMeans(const RadianceColumns& sums, std::uint32_t n, std::uint32_t split,
              const PathColumns& paths) {
  const float share = 1 / float(split);
  for (std::uint32_t i = 0; i < n; ++i) {
    paths.r[i] += share * sums.r[i];
    paths.g[i] += share * sums.g[i];
    paths.b[i] += share * sums.b[i];
  }
  for (float* column : {sums.r, sums.g, sums.b}) std::fill_n(column, n, 0.0f);
}

SurfaceRanges LightSampled(SurfaceRanges ranges) {
  for (std::uint32_t kind = kFirstDeltaBsdf; kind < kBsdfKinds; ++kind) {
    ranges.begin[kind + 1] = ranges.begin[kind];
  }
  return ranges;
}

// Follows the continuations of the current surfaces that take light samples, one wave after the
// other. `paths` is the number of rows in use.
void ContinuePaths(const FrameView& frame, const FrameView& of_continuations, std::uint32_t paths,
                   std::uint32_t bounce, const Worker& w, Continuations& c, StageClock& clock) {
  const std::uint32_t split = frame.options.bsdf_samples;
  const SurfaceRanges ranges = LightSampled(w.ranges);
  const bool direct_light_only = Describe(frame.options.integrator).direct_light_only;
  const bool last = direct_light_only || bounce + 1 == frame.options.max_depth;
  const std::uint32_t first_kind = last ? frame.first_bsdf_that_sees_light() : 0;
  if (ranges.total() == 0 || first_kind == kFirstDeltaBsdf) return;
  Departure from = FromOwnSurfaces(frame, w);
  from.paths.r = c.direct->r, from.paths.g = c.direct->g, from.paths.b = c.direct->b;
  const ShadePoints starts = {.surfaces = w.surfaces,
                              .ranges = ranges,
                              .materials = frame.geometry->materials(),
                              .paths = c.wave.paths};
  for (std::uint32_t index = 0; index < split; ++index) {
    NumberContinuations(w.paths, paths, split, index, c.wave.paths);
    const std::uint32_t n =
        Scatter(frame, starts, {kCameraEnd, bounce, first_kind}, c.wave.scratch, c.wave.rays[0],
                {.out = ControlsOf(frame, c.wave).out, .weight = ControlsOf(frame, w).weight});
    CountScattering(ranges, first_kind, c.wave.stats.lanes);
    clock.Lap(Stage::kScatter);
    if (direct_light_only) {
      IntersectLights(of_continuations, c.wave.rays[0], n, bounce + 1, from, c.wave, clock);
    } else {
      FollowPaths(of_continuations, from, n, bounce + 1, c.wave, /*film=*/nullptr, clock);
    }
  }
  AddMeans(c.direct, paths, split, w.paths);
}

RenderOption SplitOption() {
  // clang-format off
  return Refused("splits paths", MakeRenderOption({.name = "split", .group = "Paths", .help = "BSDF samples of the first hit with a density, each of which goes on as a path; direct: each sees lights", .scope = OptionScope::kPixels, .example = "--split 3", .default_text = "one, by the path itself"},
                       SKYWAVE_FIELD(bsdf_samples), Unless(0u, Numbers(1u, 1u << 16))));
  // clang-format on
}

}  // namespace

std::span<const RenderOption> PathOptions() {
  static const std::vector<RenderOption> table = [] {
    std::vector<RenderOption> rows = {SplitOption()};
    for (const RenderOption& clamp : ClampOptionTable()) rows.push_back(clamp);
    for (const RenderOption& rounding : TerminatorOptionTable()) rows.push_back(rounding);
    return rows;
  }();
  return table;
}

void AddPathTables(const RenderOptions& options, Worker& worker) {
  AddPlaceTables(options, worker);
  AddLinkTables(options, worker);
  AddClampTables(options, worker);
  if (options.bsdf_samples == 0) return;
  AddPolicyTables(options, worker.tables.Add<Continuations>(options.wave).wave);
}

void RenderSplitWave(const FrameView& frame, const WaveRange& range, Worker& w, Film& film) {
  StageClock clock(w.stats);
  Continuations& c = w.of<Continuations>();
  soa::Table<RayColumns>*rays = &w.rays[0], *next = &w.rays[1];
  GenerateRays(frame, range, FilmUniforms(w.scratch), LensUniforms(w.scratch), w.paths, *rays);
  StartContinuations(w.paths, range.count, c);
  clock.Lap(Stage::kGenerate);

  const FrameView of_continuations = frame.of_continuations();
  std::uint32_t n = range.count, bounce = 0;
  for (; n > 0; ++bounce) {
    if (bounce == frame.options.max_depth) {
      IntersectLights(frame, *rays, n, bounce, w, clock);
      break;
    }
    IntersectSurfaces(frame, *rays, n, bounce, /*only_delta=*/false, w, clock);
    ClampDirect(frame, bounce, w);
    KeepAovs(frame, bounce, range.count, w, film, clock);
    RoundTerminator(frame, w);
    LightSurfaces(frame, bounce, w, clock);
    ContinuePaths(frame, of_continuations, range.count, bounce, w, c, clock);
    n = ScatterSurfaces(frame, kCameraEnd, kFirstDeltaBsdf, bounce, *next, w, clock);
    std::swap(rays, next);
  }
  ClampDirectOfEnded(frame, bounce, w);
  KeepDirectOfEnded(range.count, bounce, w, film);
  const PathColumns& indirect = c.wave.paths;
  AddMeans({indirect.r, indirect.g, indirect.b}, range.count, frame.options.bsdf_samples, w.paths);
  ClampIndirectAndWhole(frame, w);
  w.stats += std::exchange(c.wave.stats, {});
  FinishPaths(frame, range.count, w, film, clock);
}

}  // namespace skywave
