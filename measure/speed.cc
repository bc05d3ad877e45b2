#include "measure/speed.h"

#include <algorithm>
#include <cstdlib>

#include "measure/statistics.h"

namespace skywave {
namespace {

FrameResult RenderAgain(const RenderJob& job, int threads) {
  FrameView frame = job.frame();
  frame.options.threads = threads;
  Film film = job.MakeFilm();
  return RenderFrame(frame, film);
}

void ReplayAll(const RenderJob& job, const std::vector<RayRecorder> (&ordered)[kRayOrders],
               Speed& speed) {
  for (int order = 0; order < kRayOrders; ++order) {
    for (int call = 0; call < kReplayCalls; ++call) {
      if (!IsReplayed(kReplayOrders[order], kBackends[call])) continue;
      const ReplayTime time =
          Replay(job.geometry().scene(), kBackends[call], ordered[order], job.options().threads);
      speed.replay[order][call].closest.push_back(time.closest);
      speed.replay[order][call].occlusion.push_back(time.occlusion);
    }
  }
}

}  // namespace

double Speed::render_seconds() const { return Median(render); }

double Speed::best_replay_seconds(RayOrder order) const {
  std::vector<double> closest, occlusion;
  for (const ReplaySeconds& call : replay[int(order)]) {
    if (call.closest.empty()) continue;
    closest.push_back(Median(call.closest));
    occlusion.push_back(Median(call.occlusion));
  }
  if (closest.empty()) return 0;
  return *std::min_element(closest.begin(), closest.end()) +
         *std::min_element(occlusion.begin(), occlusion.end());
}

double Speed::embree_fraction() const {
  return best_replay_seconds(RayOrder::kTraced) / render_seconds();
}

double Speed::speed_up(int threads) const {
  double one = 0, many = 0;
  for (const ThreadSeconds& count : scaling) {
    if (count.threads == 1) one = Median(count.render);
    if (count.threads == threads) many = Median(count.render);
  }
  return many > 0 ? one / many : 0;
}

Speed MeasureSpeed(const RenderJob& job, const SpeedSettings& settings, Film& film) {
  Speed speed;
  speed.load_average_before = LoadAverage();
  std::vector<RayRecorder> ordered[kRayOrders];
  speed.first = RenderFrame(job.frame(), film, nullptr, settings.replay ? &ordered[0] : nullptr);
  if (settings.replay) {
    for (int order = 1; order < kRayOrders; ++order) {
      ordered[order] = OrderRays(ordered[0], kReplayOrders[order]);
    }
  }
  const int own = speed.first.threads;
  std::vector<int> counts = settings.thread_counts;
  if (!counts.empty()) counts.push_back(own);
  std::sort(counts.begin(), counts.end());
  counts.erase(std::unique(counts.begin(), counts.end()), counts.end());
  for (const int threads : counts) speed.scaling.push_back({.threads = threads, .render = {}});

  for (int repetition = 0; repetition < settings.repetitions; ++repetition) {
    const FrameResult frame = RenderAgain(job, job.options().threads);
    speed.render.push_back(frame.seconds);
    speed.stages.push_back(frame.stats.stage_seconds);
    for (ThreadSeconds& count : speed.scaling) {
      count.render.push_back(count.threads == own ? frame.seconds
                                                  : RenderAgain(job, count.threads).seconds);
    }
    if (settings.replay) ReplayAll(job, ordered, speed);
  }
  speed.load_average_after = LoadAverage();
  return speed;
}

double LoadAverage() {
  double average = 0;
  return getloadavg(&average, 1) == 1 ? average : -1;
}

}  // namespace skywave
