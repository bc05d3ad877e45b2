// Light tracing (Arvo 1986; Dutre, Lafortune and Willems 1993). Each sample has one light path,
// every surface of which is connected to the camera and splatted. Camera rays see the environment
// and emitters, and go no further: nothing is seen through mirrors and glass. Paths have no more
// than max_depth surfaces, and roulette begins at the third one.
#include <utility>

#include "wavefront/integrator.h"

#include "wavefront/stages/light_stages.h"
#include "wavefront/stages/path_stages.h"

namespace skywave {
namespace {

// Returns the number of the first light path of a wave. Each sample of a pixel has as many as the
// film has pixels, in the order of tiles, so that they are the same for waves of any size.
std::uint64_t FirstLightPath(const FrameView& frame, const WaveRange& range) {
  const Tile& tile = range.tile;
  const std::uint64_t spp = frame.options.samples_per_pixel;
  // Tiles come row by row; within a row of tiles from left to right.
  const std::uint64_t pixels_before =
      std::uint64_t(tile.y) * frame.camera.width + std::uint64_t(tile.x) * tile.height;
  return frame.options.first_sample * frame.light_paths() + pixels_before * spp + range.first;
}

void RenderLightWave(const FrameView& frame, const WaveRange& range, Worker& w, Film& film) {
  StageClock clock(w.stats);
  soa::Table<RayColumns>*rays = &w.rays[0], *next = &w.rays[1];

  // Camera rays see the lights themselves.
  GenerateRays(frame, range, FilmUniforms(w.scratch), LensUniforms(w.scratch), w.paths, *rays);
  clock.Lap(Stage::kGenerate);
  if (film.has_aovs()) {
    IntersectSurfaces(frame, *rays, range.count, 0, /*only_delta=*/false, w, clock);
    KeepAovs(frame, 0, range.count, w, film, clock);
  } else {
    IntersectLights(frame, *rays, range.count, 0, w, clock);
  }
  FinishWave(frame, range.count, 0, w, film, clock);
  if (frame.options.max_depth == 0) return;

  StartLightPaths(frame.options, FirstLightPath(frame, range), range.count, w.paths);
  EmitRays(frame, range.count, *rays, w, clock);
  std::uint32_t n = range.count;
  for (std::uint32_t bounce = 1; n > 0; ++bounce) {
    IntersectLightPathSurfaces(frame, *rays, n, bounce, w, clock);
    ConnectSurfaces(frame, bounce, w, clock);
    SplatConnections(frame, bounce, w, film, clock);
    if (bounce == frame.options.max_depth) break;
    n = ScatterSurfaces(frame, kLightEnd, 0, bounce, *next, w, clock);
    std::swap(rays, next);
  }
}

}  // namespace

IntegratorDescriptor LightIntegrator() {
  return {.help = "paths from the lights; sees nothing in mirrors and through glass",
          .light_samples = LightSamples::kNone,
          .light_paths = LightPaths::kStrategy,
          .has_splats = true,
          .add_tables = AddLightPathTables,
          .render_wave = RenderLightWave};
}

}  // namespace skywave
