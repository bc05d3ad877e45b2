// One wave of a built-in scene, stopped between the stages, so that each can run separately on
// realistic data. Environment variables choose another scene and map:
// SKYWAVE_BENCH_SCENE, SKYWAVE_BENCH_ENV, SKYWAVE_BENCH_STRATEGY, SKYWAVE_BENCH_WAVE.
#pragma once

#include <cstdlib>
#include <string>

#include "job/job.h"
#include "kernels/partition.h"
#include "wavefront/flush_denormals.h"
#include "wavefront/integrators/path.h"
#include "wavefront/stages/path_stages.h"
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

  // Traces, sorts and prepares camera rays: worker.surfaces is then ready to shade.
  void Camera() {
    GenerateRays(frame, range, FilmUniforms(worker.scratch), LensUniforms(worker.scratch),
                 worker.paths, worker.rays[0]);
    n = range.count;
    StageClock clock(worker.stats);
    PrepareHits(frame, kCameraEnd, worker.rays[0], n, Trace(0), worker, clock);
  }

  // Advances by one bounce: rays[0] are then scattered and traced rays. The surfaces are still
  // those that the rays have left; `ranges` describes those that they will hit.
  void Bounce() {
    n = Scatter(frame, PointsIn(ranges, frame, worker), {kCameraEnd, 0}, worker.scratch,
                worker.rays[0]);
    Trace(1);
  }

  // Traces rays[0], which arrive at `bounce`, and moves those that escape.
  SortedHits Trace(std::uint32_t bounce) {
    StageClock clock(worker.stats);
    SortedHits sorted = TraceAndSort(frame, kCameraEnd, worker.rays[0], n, bounce,
                                     /*only_delta=*/false, worker, clock);
    MoveEscaped(worker.rays[0], sorted.queues->queue, n, worker.escaped);
    ranges = sorted.ranges, escaped = sorted.escaped;
    return sorted;
  }

  // Sorts the hits of the last Trace again.
  RayQueues Sort() {
    RayQueues queues(worker.scratch);
    ranges = {};
    escaped = SortHits(*frame.geometry, worker.rays[0], worker.hits, n, false, queues, ranges);
    return queues;
  }

  // Returns the surfaces of the worker in the form that strategies need.
  ShadePoints Points() const { return skywave::Points(frame, worker); }

  static JobRequest Request(const std::string& strategy) {
    JobRequest request;
    request.scene = Variable("SKYWAVE_BENCH_SCENE", "gallery");
    request.environment.path = Variable("SKYWAVE_BENCH_ENV", "");
    request.strategy = strategy;
    if (strategy == "portal") request.portals = {"2,0,-2,2,0,2,2,3,2,2,3,-2"};
    request.options.threads = 1;
    request.options.wave = std::uint32_t(std::stoi(Variable("SKYWAVE_BENCH_WAVE", "2048")));
    request.samples_per_pixel = 4;
    request.width = 640, request.height = 480;
    return request;
  }

  LightShares shares() const { return frame.light_shares(); }

  // Draws and evaluates light sample `index` of the plan; returns the distances of the lights.
  LightReach SampleAndEvaluate(std::uint32_t index) {
    LightReach reach = SampleLights(frame, Points(), shares(), SamplePair(0, SampleUse::kLight),
                                    index, LightUniforms(worker.scratch), worker.scratch,
                                    worker.lights, LightPlaces(worker.hits));
    EvaluateLights(frame, worker.surfaces, ranges, reach, index, worker.lights);
    return reach;
  }

  FlushDenormals flush;
  RenderJob job;
  FrameView frame;
  Film film;
  Worker worker;
  WaveRange range;
  SurfaceRanges ranges;
  std::uint32_t n = 0, escaped = 0;
};

}  // namespace skywave
