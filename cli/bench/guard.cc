// Guards a scene: holds a run to a baseline, and prints what a baseline counts.
#include <fmt/format.h>
#include <array>

#include <algorithm>
#include <filesystem>

#include "base/error.h"
#include "base/files.h"
#include "base/version.h"
#include "bench/measure/counters.h"
#include "cli/bench/flags.h"
#include "cli/bench/report.h"
#include "cli/print.h"
#include "job/job.h"
#include "job/options.h"

namespace skywave {
namespace {

std::vector<Counter> CountersOf(const RenderJob& job, const Film& film, const RenderStats& stats) {
  const StrategyTable table = {.name = std::string(job.strategy().name()),
                               .bytes = job.strategy().table_bytes()};
  return Counters({.picture = FingerprintOf(film, job.options().samples_per_pixel).hash,
                   .scene = job.scene_hash(),
                   .triangles = job.geometry().triangle_count(),
                   .geometry_bytes = job.geometry().bytes(),
                   .stats = stats,
                   .tables = std::span(&table, 1)});
}

bool Has(const std::vector<BaselineGate>& gates, BaselineGate gate) {
  return std::find(gates.begin(), gates.end(), gate) != gates.end();
}

// Measures what `gates` need. Options that only say where a picture comes from are left out: the
// hash of the scene shows whether it is the same.
Baseline MeasureBaseline(const RenderJob& job, const BenchFlags& flags,
                         const std::vector<BaselineGate>& gates) {
  Film film = job.MakeFilm();
  SpeedSettings settings = {.repetitions = RepetitionsOf(flags),
                            .deviation = DeviationOf(flags),
                            .thread_counts = {},
                            .replay = false};
  if (!Has(gates, BaselineGate::kTime)) settings.repetitions = 0;
  const Speed speed = MeasureSpeed(job, settings, film);
  PrintDoubts(speed, job.request().scene);
  const Machine machine = DescribeMachine(flags.request.embree_config);
  Baseline now = {.reasons = {},
                  .version = std::string(Version()),
                  .options = {{"wave", std::to_string(job.options().wave)}},
                  .hits = machine.embree_config,
                  .counters = CountersOf(job, film, speed.first.stats),
                  .machine = {{"processor", machine.processor},
                              {"processors", std::to_string(machine.processors)},
                              {"threads", std::to_string(speed.first.threads)},
                              {"backend", std::string(ToString(job.options().backend))}},
                  .seconds = speed.render,
                  .doubts = speed.doubts()};
  for (const RecordedOption& option : RecordedOptions(job.request())) {
    if (!option.is_input && !option.words.empty()) {
      now.options.emplace_back(option.name, option.words.substr(1));
    }
  }
  if (Has(gates, BaselineGate::kInstructions)) {
    InstructionCounts counts = CountInstructions(job.request());
    now.not_counted = counts.skipped;
    now.toolchain = counts.toolchain;
    now.instructions = std::move(counts.stages);
  }
  return now;
}

std::vector<GateResult> Judge(const Baseline& baseline, const Baseline& now,
                              const BenchFlags& flags, const std::vector<BaselineGate>& gates) {
  return JudgeBaseline(baseline, now, gates, flags.threshold_percent / 100, flags.baseline);
}

std::string_view VerdictText(const GateResult& result) {
  switch (result.verdict) {
    case GateResult::kPassed:
      return "passed";
    case GateResult::kFailed:
      return "FAILED";
    case GateResult::kSkipped:
      return "skipped";
    case GateResult::kUnclear:
      return "unclear";
  }
  return "";
}

int WriteBaseline(const BenchFlags& flags, const std::string& reason) {
  if (reason.empty()) throw OptionError("update-baseline", "", "needs a reason");
  CheckWritable(flags.baseline);
  std::vector<std::string> reasons;
  if (std::filesystem::exists(flags.baseline)) reasons = ReadBaseline(flags.baseline).reasons;
  const FilesRead inputs;
  const RenderJob job(flags.request);
  inputs.CheckAreNot(std::array{flags.baseline});
  PrintRemarks(job);
  Baseline baseline = MeasureBaseline(job, flags, flags.gates);
  if (!baseline.not_counted.empty()) {
    Print(stderr, "note: no instructions: {}\n", baseline.not_counted);
  }
  for (const std::string& doubt : baseline.doubts) {
    Print(stderr, "warning: {}: its times will not be compared: {}\n", flags.baseline, doubt);
  }
  baseline.reasons = std::move(reasons);
  baseline.reasons.push_back(reason);
  WriteFileAtomically(flags.baseline, JsonText(baseline) + "\n");
  Print(stdout, "wrote {}: {} counters, instructions of {} stages, {} times\n", flags.baseline,
        baseline.counters.size(), baseline.instructions.size(), baseline.seconds.size());
  return 0;
}

}  // namespace

int GuardScene(const BenchFlags& flags) {
  if (flags.new_baseline_reason) return WriteBaseline(flags, *flags.new_baseline_reason);
  if (!std::filesystem::exists(flags.baseline)) {
    throw InputError(InputPosition::File(flags.baseline),
                     "there is no such baseline yet; make it by --update-baseline WHY", kExitIo);
  }
  const Baseline baseline = ReadBaseline(flags.baseline);
  const RenderJob job(flags.request);
  PrintRemarks(job);
  const Baseline now = MeasureBaseline(job, flags, flags.gates);
  std::vector<GateResult> results = Judge(baseline, now, flags, flags.gates);
  // A slow minute of the machine is not a regression, and is seldom followed by another.
  for (GateResult& result : results) {
    const bool failed = result.verdict == GateResult::kFailed;
    if (result.gate != BaselineGate::kTime || !(failed || result.verdict == GateResult::kUnclear)) {
      continue;
    }
    Print(stderr, "note: {}; measured once more\n",
          failed ? "slower than the baseline" : result.summary);
    const std::vector<BaselineGate> time = {BaselineGate::kTime};
    result = Judge(baseline, MeasureBaseline(job, flags, time), flags, time).front();
  }
  std::string line = "BASELINE";
  for (const GateResult& result : results) {
    const std::string_view verdict = VerdictText(result);
    Print(stdout, "{}: {}: {}\n", ToString(result.gate), verdict, result.summary);
    for (const std::string& what : result.lines) Print(stdout, "  {}\n", what);
    line += fmt::format(" {}={}", ToString(result.gate), verdict);
  }
  const int code = ExitCodeOf(results);
  if (code != 0) {
    Print(stdout, "if this is meant: --update-baseline WHY takes the new values\n");
  }
  Print(stdout, "{} result={}\n", line, code == 0 ? "passed" : "failed");
  return code;
}

int PrintCounters(const BenchFlags& flags) {
  const RenderJob job(flags.request);
  PrintRemarks(job);
  Film film = job.MakeFilm();
  const FrameResult frame = RenderFrame(job.frame(), film);
  for (const auto& [name, value] : CountersOf(job, film, frame.stats)) {
    Print(stdout, "{} {}\n", name, value);
  }
  return 0;
}

int PrintInstructions(const BenchFlags& flags) {
  const RenderJob job(flags.request);
  PrintRemarks(job);
  const InstructionCounts counts = CountInstructions(job.request());
  if (!counts.skipped.empty()) {
    Print(stdout, "skipped: {}\n", counts.skipped);
    return kExitSkipped;
  }
  for (const auto& [stage, count] : counts.stages) Print(stdout, "{} {}\n", stage, count);
  return 0;
}

}  // namespace skywave
