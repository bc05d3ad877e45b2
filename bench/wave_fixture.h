// One wave of a built-in scene, stopped between the stages, so that each can be run on its own on
// what it really meets. Environment variables choose another scene and map:
// SKYWAVE_BENCH_SCENE, SKYWAVE_BENCH_ENV, SKYWAVE_BENCH_STRATEGY, SKYWAVE_BENCH_WAVE.
#pragma once

#include <cstdlib>
#include <string>

#include "job/job.h"
#include "kernels/partition.h"
#include "kernels/surface/surface.h"
#include "wavefront/flush_denormals.h"
#include "wavefront/integrators/path.h"
#include "wavefront/stages/stages.h"

namespace skywave {

inline std::string Variable(const char* name, const char* otherwise) {
  const char* value = std::getenv(name);
  return value != nullptr ? value : otherwise;
}

struct WaveFixture {
  explicit WaveFixture(const std::string& strategy = Variable("SKYWAVE_BENCH_STRATEGY",
                                                              "importance"))
      : job(Request(strategy)),
        frame(job.frame()),
        film(job.MakeFilm()),
        worker(WholeBeams(job.options().wave)) {
    const auto width = std::uint32_t(job.options().width),
               height = std::uint32_t(job.options().height);
    range = {.tile = {0, height / 2, width, height - height / 2},
             .first = 0,
             .count = WholeBeams(job.options().wave)};
    Camera();
  }

  // Camera rays traced, partitioned and prepared: worker.surfaces is ready to shade.
  void Camera() {
    GenerateRays(frame, range, worker.uniforms, worker.lobe, worker.paths, worker.rays[0]);
    n = range.count;
    TraceClosest(frame.tracer, RayKind::kCamera, worker.rays[0], n, worker.hits);
    ranges = {};
    escaped = SortHits(*frame.geometry, worker.rays[0], worker.hits, n, false, worker.queue->queue,
                       ranges);
    MoveEscaped(worker.rays[0], worker.queue->queue, n, worker.escaped);
    MoveSurfaces(worker.rays[0], worker.hits, worker.queue->queue, n, ranges, worker.surfaces);
    PrepareSurfaces(frame.geometry->triangles(), frame.geometry->materials().records,
                    ranges.total(), worker.surfaces);
    TextureSurfaces(frame, kCameraEnd, ranges, worker.surfaces);
  }

  // One bounce further: rays[0] are scattered rays, traced.
  void Bounce() {
    n = Scatter(frame, kCameraEnd, worker.paths, worker.surfaces, ranges, 0, 0, worker.uniforms,
                worker.lobe, worker.rays[0]);
    TraceClosest(frame.tracer, RayKind::kBounce, worker.rays[0], n, worker.hits);
    ranges = {};
    escaped = SortHits(*frame.geometry, worker.rays[0], worker.hits, n, false, worker.queue->queue,
                       ranges);
    MoveEscaped(worker.rays[0], worker.queue->queue, n, worker.escaped);
  }

  ShadePoints Points() const {
    return {.surfaces = worker.surfaces,
            .ranges = ranges,
            .materials = materials,
            .paths = worker.paths};
  }

  static JobRequest Request(const std::string& strategy) {
    JobRequest request;
    request.scene = Variable("SKYWAVE_BENCH_SCENE", "gallery");
    request.environment.path = Variable("SKYWAVE_BENCH_ENV", "");
    request.strategy = strategy;
    request.options.threads = 1;
    request.options.wave = std::uint32_t(std::stoi(Variable("SKYWAVE_BENCH_WAVE", "2048")));
    request.samples_per_pixel = 4;
    request.width = 640, request.height = 480;
    return request;
  }

  LightShares shares() const { return frame.light_shares(); }

  FlushDenormals flush;
  RenderJob job;
  FrameView frame;
  MaterialView materials = frame.geometry->materials();
  Film film;
  Worker worker;
  WaveRange range;
  SurfaceRanges ranges;
  std::uint32_t n = 0, escaped = 0;
};

}  // namespace skywave
