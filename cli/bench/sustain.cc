// Measures whether the speed lasts.
#include <fmt/format.h>
#include <array>

#include <cmath>
#include <memory>
#include <nlohmann/json.hpp>

#include "base/files.h"
#include "base/granted.h"
#include "base/json.h"
#include "base/version.h"
#include "bench/measure/sustain.h"
#include "cli/bench/flags.h"
#include "cli/bench/report.h"
#include "cli/print.h"
#include "job/options.h"

namespace skywave {
namespace {

struct SustainedJobs {
  std::string subject;
  std::vector<std::unique_ptr<RenderJob>> jobs;
  bool right = true;
};

// Renders each job once, which warms up what is not the processor, and checks the pictures of the
// suite.
SustainedJobs PrepareSustained(const BenchFlags& flags) {
  SustainedJobs prepared;
  const auto render = [&](const JobRequest& request) -> Film {
    prepared.jobs.push_back(std::make_unique<RenderJob>(request));
    Film film = prepared.jobs.back()->MakeFilm();
    RenderFrame(prepared.jobs.back()->frame(), film);
    return film;
  };
  if (flags.has_scene()) {
    render(flags.request);
    PrintRemarks(*prepared.jobs.back());
    prepared.subject = "skywave render" + PictureOptions(prepared.jobs.back()->request());
    return prepared;
  }
  prepared.subject = flags.full ? "full suite" : "quick suite";
  for (const SuiteScene& scene : SuiteScenes(flags.full)) {
    const JobRequest request = SuiteRequest(scene, flags.request);
    const Fingerprint found = FingerprintOf(render(request), scene.samples_per_pixel);
    const PictureCheck check = CheckPicture(scene.expected, found, KnownHash(scene, request));
    prepared.right &= PictureIsRight(scene, check, found);
  }
  return prepared;
}

nlohmann::ordered_json IntervalJson(const Interval& interval) {
  if (std::isnan(interval.low)) return nullptr;
  return {interval.low, interval.high};
}

nlohmann::ordered_json Json(const SustainedSpeed& speed) {
  nlohmann::ordered_json json;
  json["seconds"] = speed.seconds;
  json["first_msamples_per_s"] = speed.first * 1e-6;
  json["last_msamples_per_s"] = speed.last * 1e-6;
  json["last_to_first"] = {{"ratio", speed.last_to_first.value},
                           {"interval", IntervalJson(speed.last_to_first.interval)}};
  json["drift_per_minute"] = {{"slope", speed.drift_per_minute.value},
                              {"interval", IntervalJson(speed.drift_per_minute.interval)}};
  for (const SustainedRound& round : speed.rounds) {
    json["rounds"].push_back({{"start", round.start}, {"msamples_per_s", round.rate * 1e-6}});
  }
  return json;
}

std::string Ends(const Interval& interval, double scale) {
  if (std::isnan(interval.low)) return "[too few rounds for an interval]";
  return fmt::format("[{:.4f}, {:.4f}]", interval.low * scale, interval.high * scale);
}

}  // namespace

int BenchSustained(const BenchFlags& flags) {
  if (!flags.json.empty()) CheckWritable(flags.json);
  const FilesRead inputs;
  const SustainedJobs prepared = PrepareSustained(flags);
  inputs.CheckAreNot(std::array{flags.json});
  if (!prepared.right) return kExitWrongPicture;
  std::vector<const RenderJob*> jobs;
  for (const auto& job : prepared.jobs) jobs.push_back(job.get());
  ProgressDisplay display(flags.progress);
  display.Begin("sustain", 0);
  const SustainedSpeed speed =
      MeasureSustained(jobs, *flags.sustain_seconds, [&](double done) { display.Show(done); });
  display.End();
  display.Clear();
  const int threads = ThreadsFor(flags.request.options.threads);
  Print(stdout, "{} for {:.1f} s on {} threads: {} rounds\n", prepared.subject, speed.seconds,
        threads, speed.rounds.size());
  for (const CurvePoint& block : speed.blocks) {
    Print(stdout, "  {:>8.1f} s {:>10.3f} Msamples/s\n", block.x, block.y * 1e-6);
  }
  Print(stdout, "last quarter over first: {:.4f} {}\ndrift: {:+.2f} % a minute {}\n",
        speed.last_to_first.value, Ends(speed.last_to_first.interval, 1),
        100 * speed.drift_per_minute.value, Ends(speed.drift_per_minute.interval, 100));
  Print(
      stdout,
      "SUSTAIN seconds={:.1f} first_msamples_per_s={:.3f} last_msamples_per_s={:.3f} ratio={:.4f} "
      "drift_percent_per_minute={:.3f}\n",
      speed.seconds, speed.first * 1e-6, speed.last * 1e-6, speed.last_to_first.value,
      100 * speed.drift_per_minute.value);
  if (flags.json.empty()) return 0;
  nlohmann::ordered_json json = {{"schema", "skywave-bench-sustain-1"},
                                 {"version", Version()},
                                 {"subject", prepared.subject},
                                 {"threads", threads}};
  json["machine"] = Json(DescribeMachine(flags.request.embree_config));
  json.update(Json(speed));
  WriteFileAtomically(flags.json, JsonText(json, 2) + "\n");
  return 0;
}

}  // namespace skywave
