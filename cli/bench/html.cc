#include <fmt/format.h>

#include "bench/measure/bars.h"
#include "bench/measure/html.h"
#include "bench/measure/plot.h"
#include "bench/measure/statistics.h"
#include "cli/bench/report.h"

namespace skywave {
namespace {

constexpr std::string_view kStyle =
    "body{font:15px/1.45 sans-serif;max-width:940px;margin:24px auto;padding:0 16px;color:#202020}"
    "h1{font-size:24px}h2{font-size:19px;margin-top:34px}svg{max-width:100%;height:auto}"
    "pre{font-size:12px;overflow-x:auto;background:#f6f6f6;padding:8px}";

std::string Figure(const std::string& svg, const std::string& words) {
  return svg + "\n<p>" + words + "</p>\n";
}

BarChart StageChart(const SuiteReport& report) {
  BarChart chart = {.title = "Where the time goes", .unit = "ns a sample, all threads together"};
  for (std::uint32_t i = 0; i < kStages; ++i) chart.segments.emplace_back(ToString(Stage(i)));
  for (const SuiteResult& result : report.results) {
    Bar bar = {.name = std::string(result.scene.name), .values = {}};
    for (std::uint32_t i = 0; i < kStages; ++i) {
      bar.values.push_back(result.speed.stage_seconds(Stage(i)) /
                           double(result.speed.first.stats.samples) * 1e9);
    }
    chart.bars.push_back(bar);
  }
  return chart;
}

BarChart CeilingChart(const SuiteResult& result) {
  const Speed& speed = result.speed;
  BarChart chart = {
      .title = fmt::format("{}: the same rays through Embree alone", result.scene.name),
      .unit = "milliseconds",
      .segments = {"camera rays", "bounce rays", "shadow rays", "render"}};
  chart.bars.push_back({"render", {0, 0, 0, speed.render_seconds() * 1e3}});
  for (int order = 0; order < kRayOrders; ++order) {
    for (int call = 0; call < kReplayCalls; ++call) {
      const ReplaySeconds& replay = speed.replay[order][call];
      if (replay[0].empty()) continue;
      const std::string sorted = order == 0 ? "" : order == 1 ? ", sorted in waves" : ", sorted";
      chart.bars.push_back(
          {fmt::format("{}{}", ToString(kBackends[call]), sorted),
           {Median(replay[0]) * 1e3, Median(replay[1]) * 1e3, Median(replay[2]) * 1e3}});
    }
  }
  return chart;
}

// Shows how closely each kind of rays approaches its ceiling.
BarChart RooflineChart(const SuiteResult& result) {
  BarChart chart = {.title = fmt::format("{}: rays while they are traced", result.scene.name),
                    .unit = "Mrays/s, all threads together",
                    .segments = {"in the render", "raw Embree, best call"}};
  for (std::uint32_t i = 0; i < kRayKinds; ++i) {
    const auto kind = RayKind(i);
    const std::string name(kRayKindNames[i]);
    chart.bars.push_back({name + ", render", {result.speed.traced_mrays_per_second(kind)}});
    chart.bars.push_back({name + ", raw", {0, result.speed.raw_mrays_per_second(kind)}});
  }
  return chart;
}

BarChart LaneChart(const SuiteReport& report) {
  const std::uint32_t width = ShownLanes(report.machine);
  BarChart chart = {.title = fmt::format("Lanes in use, of vectors of {}", width),
                    .unit = "percent, over all scenes",
                    .segments = {"lanes in use"}};
  for (std::uint32_t i = 0; i < kKernels; ++i) {
    LaneCount lanes;
    for (const SuiteResult& result : report.results) lanes += result.speed.first.stats.lanes[i];
    if (lanes.active == 0) continue;
    chart.bars.push_back({ToString(Kernel(i)), {100 * lanes.utilisation(width)}});
  }
  return chart;
}

Plot ScalingPlot(const SuiteReport& report) {
  Plot plot = {.title = "Scaling", .x_label = "threads", .y_label = "times as fast as one"};
  PlotSeries ideal = {.name = "ideal", .points = {}};
  for (const SuiteResult& result : report.results) {
    PlotSeries series = {.name = std::string(result.scene.name), .points = {}};
    for (const ThreadSeconds& count : result.speed.scaling) {
      series.points.push_back({double(count.threads), result.speed.speed_up(count.threads)});
      if (&result == &report.results.front()) {
        ideal.points.push_back({double(count.threads), double(count.threads)});
      }
    }
    plot.series.push_back(series);
  }
  plot.series.push_back(ideal);
  return plot;
}

std::string HistoryCharts(const SuiteReport& report, const std::vector<HistoryEntry>& history) {
  BarChart speed = {.title = "Speed", .unit = "Msamples/s", .segments = {"Msamples/s"}};
  BarChart fraction = {
      .title = "Share of Embree", .unit = "embree_fraction", .segments = {"embree_fraction"}};
  const auto add = [&](const std::string& name, const SuiteSummary& summary) {
    speed.bars.push_back({name, {summary.msamples_per_s}});
    fraction.bars.push_back({name, {summary.embree_fraction}});
  };
  for (const HistoryEntry& entry : history) add(entry.name, entry.summary);
  add("this run", Summarize(report.results));
  return Svg(speed) + "\n" + Svg(fraction) + "\n";
}

}  // namespace

std::string Html(const SuiteReport& report, const std::vector<HistoryEntry>& history) {
  const SuiteSummary summary = Summarize(report.results);
  std::string page = HtmlStart("skywave bench", kStyle);
  page += fmt::format("<h1>{:.2f} Msamples/s</h1>\n<p>{}</p>\n<pre>{}</pre>\n",
                      summary.msamples_per_s, EscapeXml(Headline(report)),
                      EscapeXml(SummaryLine(summary) + NotMeasured(report)));
  if (!history.empty()) page += "<h2>History</h2>\n" + HistoryCharts(report, history);
  page += "<h2>Stages</h2>\n" +
          Figure(Svg(StageChart(report)), "Medians over the repetitions; hover for values.");
  page += "<h2>Vectors</h2>\n" +
          Figure(Svg(LaneChart(report)), "Rows that a kernel is for over the lanes that it walks.");
  if (report.replayed) {
    page += "<h2>Raw Embree against the render</h2>\n";
    for (const SuiteResult& result : report.results) {
      const Speed& speed = result.speed;
      const double traced = speed.best_replay_seconds(RayOrder::kTraced);
      page += Svg(RooflineChart(result)) + "\n";
      page += Figure(
          Svg(CeilingChart(result)),
          fmt::format("The best calls in the traced order take {:.3f} of the render. Sorting would "
                      "make them {:.2f} times as fast within waves and {:.2f} times over the "
                      "frame, sorting itself not counted.",
                      speed.embree_fraction(), traced / speed.best_replay_seconds(RayOrder::kWave),
                      traced / speed.best_replay_seconds(RayOrder::kFrame)));
    }
  }
  if (report.results.front().speed.scaling.size() > 1) {
    const Plot plot = ScalingPlot(report);
    page += "<h2>Threads</h2>\n" + Svg(std::span(&plot, 1)) + "\n";
  }
  page += "<h2>All figures</h2>\n<pre>" + EscapeXml(SuiteText(report)) + "</pre>\n";
  return page + HtmlEnd();
}

}  // namespace skywave
