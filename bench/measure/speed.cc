#include "bench/measure/speed.h"

#include <fmt/format.h>

#include <algorithm>
#include <cstdlib>
#include <limits>

#include "bench/measure/statistics.h"

namespace skywave {
namespace {

FrameResult RenderAgain(const RenderJob& job, int threads) {
  FrameView frame = job.frame();
  frame.options.threads = threads;
  Film film = job.MakeFilm();
  return RenderFrame(frame, film);
}

// Threads take some 50 us to wake up.
constexpr double kLeastSeconds = 2e-3;

// Returns the median of entry `i` over the repetitions.
template <std::size_t kSize>
double MedianOf(const std::vector<std::array<double, kSize>>& repetitions, std::uint32_t i) {
  std::vector<double> values;
  for (const auto& repetition : repetitions) values.push_back(repetition[i]);
  return Median(values);
}

double Mrays(const RenderStats& stats, RayKind kind, double seconds) {
  return seconds > 0 ? double(stats.rays[std::uint32_t(kind)]) / seconds * 1e-6 : 0;
}

void ReplayAll(const RenderJob& job, const std::vector<RayRecorder> (&ordered)[kRayOrders],
               Speed& speed) {
  for (int order = 0; order < kRayOrders; ++order) {
    for (int call = 0; call < kReplayCalls; ++call) {
      const ReplayTime time =
          Replay(job.geometry().scene(), kBackends[call], ordered[order], job.options().threads);
      for (std::uint32_t kind = 0; kind < kRayKinds; ++kind) {
        speed.replay[order][call][kind].push_back(time.seconds[kind]);
      }
    }
  }
}

}  // namespace

double Speed::render_seconds() const { return Median(render); }

double Speed::deviation() const { return RelativeDeviation(FastestOf(render)); }

std::vector<std::string> Speed::doubts() const {
  std::vector<std::string> found = conditions.disturbances();
  if (!steady()) found.push_back(UnsteadyText(render.size(), deviation(), deviation_limit));
  if (!found.empty() && render_seconds() < kLeastSeconds) {
    found.insert(found.begin(),
                 fmt::format("a render takes {:.2g} ms, of which starting threads is a part: "
                             "`spp` or `size` make it longer",
                             1e3 * render_seconds()));
  }
  return found;
}

BestReplay Speed::best_replay(RayOrder order, RayKind kind) const {
  BestReplay best = {.call = kBackends[0], .seconds = std::numeric_limits<double>::infinity()};
  for (int call = 0; call < kReplayCalls; ++call) {
    const std::vector<double>& seconds = replay[int(order)][call][std::uint32_t(kind)];
    if (seconds.empty() || Median(seconds) >= best.seconds) continue;
    best = {.call = kBackends[call], .seconds = Median(seconds)};
  }
  return best;
}

double Speed::best_replay_seconds(RayOrder order) const {
  if (!replayed(order)) return 0;
  double sum = 0;
  for (std::uint32_t kind = 0; kind < kRayKinds; ++kind) {
    sum += best_replay(order, RayKind(kind)).seconds;
  }
  return sum;
}

double Speed::embree_fraction() const {
  return best_replay_seconds(RayOrder::kTraced) / render_seconds();
}

double Speed::stage_seconds(Stage stage) const { return MedianOf(stages, std::uint32_t(stage)); }

double Speed::busy_seconds() const {
  double sum = 0;
  for (std::uint32_t i = 0; i < kStages; ++i) sum += stage_seconds(Stage(i));
  return sum;
}

double Speed::trace_seconds(RayKind kind) const { return MedianOf(traces, std::uint32_t(kind)); }

double Speed::mrays_per_second(RayKind kind) const {
  return Mrays(first.stats, kind, render_seconds());
}

double Speed::traced_mrays_per_second(RayKind kind) const {
  return Mrays(first.stats, kind, trace_seconds(kind) / first.threads);
}

double Speed::raw_mrays_per_second(RayKind kind) const {
  if (!replayed(RayOrder::kTraced)) return 0;
  return Mrays(first.stats, kind, best_replay(RayOrder::kTraced, kind).seconds);
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
  speed.deviation_limit = settings.deviation;
  speed.load_average_before = LoadAverage();
  std::vector<RayRecorder> ordered[kRayOrders];
  speed.first =
      RenderFrame(job.frame(), film, {.recorders = settings.replay ? &ordered[0] : nullptr});
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

  ConditionsWatch conditions;
  const int most = settings.repetitions * kMostRepetitions;
  for (int done = 0; done < settings.repetitions || (done < most && !speed.steady()); ++done) {
    conditions.Begin();
    if (settings.hardware != nullptr) settings.hardware->Begin();
    const FrameResult frame = RenderAgain(job, job.options().threads);
    if (settings.hardware != nullptr) settings.hardware->End();
    conditions.End();
    speed.render.push_back(frame.seconds);
    speed.processor.push_back(frame.processor_seconds);
    speed.stages.push_back(frame.stats.stage_seconds);
    speed.traces.push_back(frame.stats.trace_seconds);
    for (ThreadSeconds& count : speed.scaling) {
      count.render.push_back(count.threads == own ? frame.seconds
                                                  : RenderAgain(job, count.threads).seconds);
    }
    if (settings.replay) ReplayAll(job, ordered, speed);
  }
  speed.load_average_after = LoadAverage();
  speed.conditions = conditions.conditions();
  if (settings.hardware != nullptr) speed.hardware = settings.hardware->Take();
  return speed;
}

std::string UnsteadyText(std::size_t renders, double deviation, double limit) {
  return fmt::format("the times of {} renders deviate by {:.1f} %, more than {:.1f} %", renders,
                     100 * deviation, 100 * limit);
}

double LoadAverage() {
  double average = 0;
  return getloadavg(&average, 1) == 1 ? average : -1;
}

}  // namespace skywave
