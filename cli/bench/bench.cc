// Implements skywave bench: the speed of the suite or of a scene, and Embree's share of it.
#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <memory>
#include <nlohmann/json.hpp>
#include <optional>
#include <set>
#include <vector>

#include "base/error.h"
#include "base/files.h"
#include "base/granted.h"
#include "base/json.h"
#include "base/version.h"
#include "bench/measure/revision.h"
#include "cli/bench/flags.h"
#include "cli/bench/report.h"
#include "cli/commands.h"
#include "cli/print.h"
#include "cli/progress.h"
#include "job/options.h"

namespace skywave {
namespace {

constexpr int kSceneRepetitions = 9, kQuickRepetitions = 3, kFullRepetitions = 9;
// Limit of rays that a replay keeps in memory without asking: 72 bytes each, in three orders.
constexpr double kMaxRecordedRays = 2e7;

constexpr std::string_view kSuite = "Suite", kOther = "Other measurements", kGuard = "Guard";

// A kind of measurement, the option that asks for it, and the options of bench that it takes.
struct BenchKind {
  std::string_view option;  // empty: the plain measurement
  enum { kSceneOrSuite, kScene, kFiles } of;
  std::set<std::string_view> takes;
  int (*scene)(const BenchFlags&);
  int (*suite)(const BenchFlags&);
};

const std::vector<BenchKind>& BenchKinds() {
  using Kind = BenchKind;
  static const std::vector<BenchKind> kinds = {
      {"compare", Kind::kFiles, {"threshold"}, nullptr, CompareBenches},
      {"sustain",
       Kind::kSceneOrSuite,
       {"json", "progress", "full"},
       BenchSustained,
       BenchSustained},
      {"copies",
       Kind::kSceneOrSuite,
       {"json", "repetitions", "full", "rotate"},
       BenchCopies,
       BenchCopies},
      {"baseline",
       Kind::kScene,
       {"repetitions", "deviation", "update-baseline", "gates", "threshold"},
       GuardScene,
       nullptr},
      {"instructions", Kind::kScene, {}, PrintInstructions, nullptr},
      {"counters", Kind::kSceneOrSuite, {"full", "progress"}, PrintCounters, BenchSuite},
      {"",
       Kind::kSceneOrSuite,
       {"json", "export", "repetitions", "deviation", "progress", "full", "renders-only", "report",
        "history"},
       BenchScene,
       BenchSuite}};
  return kinds;
}

const BenchKind& KindOf(const GivenOptions& given) {
  for (const BenchKind& kind : BenchKinds()) {
    if (given.contains(kind.option)) return kind;
  }
  return BenchKinds().back();
}

// The suite takes the options of a job that do not change its pictures, and --seed, which makes the
// comparison fail on purpose; a scene takes none of the suite's options.
void CheckGiven(const Command& command, const BenchKind& kind, const GivenOptions& given,
                bool has_scene) {
  for (const BoundOption& option : command.options) {
    const OptionInfo& info = option.info;
    if (!given.contains(info.name) || info.name == kind.option) continue;
    const auto fail = [&](const std::string& why) {
      throw InputError(InputPosition::File("--" + std::string(info.name)), why, kExitUsage);
    };
    const bool of_job = info.scope == OptionScope::kPixels || info.scope == OptionScope::kInput ||
                        info.scope == OptionScope::kSpeed;
    if (kind.of == BenchKind::kFiles && of_job) {
      fail(fmt::format("--{} renders nothing", kind.option));
    }
    if (has_scene && info.group == kSuite) fail("belongs to the suite: give no scene");
    if (!has_scene && of_job && !info.in_suite) {
      fail("the suite has fixed pictures: give a scene to measure others");
    }
    if (!of_job && !kind.takes.contains(info.name)) {
      fail(kind.option.empty() ? "belongs to another measurement"
                               : fmt::format("does not go together with --{}", kind.option));
    }
    if (kind.option == "copies" && info.name == "threads") fail("each copy has one thread");
  }
  if (kind.of == BenchKind::kScene && !has_scene) {
    throw InputError(InputPosition::File("--" + std::string(kind.option)), "give a scene",
                     kExitUsage);
  }
}

nlohmann::ordered_json SceneJson(const RenderJob& job, const Film& film, const Speed& speed,
                                 const Machine& machine) {
  const RenderStats& stats = speed.first.stats;
  const double seconds = speed.render_seconds();
  nlohmann::ordered_json json;
  json["schema"] = kSceneSchema;
  json["version"] = Version();
  json["revision"] = GitRevision();
  json["command"] = "skywave render" + PictureOptions(job.request());
  json["scene"] = job.request().scene;
  json["threads"] = speed.first.threads;
  json["wave"] = job.options().wave;
  json["samples"] = stats.samples;
  json["picture_hash"] =
      fmt::format("{:016x}", FingerprintOf(film, job.options().samples_per_pixel).hash);
  json["render_seconds"] = speed.render;
  const nlohmann::ordered_json measured = Json(speed);
  json["deviation"] = measured.at("deviation");
  json["repetitions"] = measured.at("repetitions");
  json["conditions"] = measured.at("conditions");
  json["hardware"] = measured.at("hardware");
  json["load_average"] = measured.at("load_average");
  json["replay_seconds"];  // null unless replayed, as the next one
  json["replay"];
  if (measured.contains("replay")) {
    json["replay_seconds"] = measured.at("replay").at("traced").at("seconds");
    json["replay"] = measured.at("replay");
  }
  for (std::uint32_t i = 0; i < kRayKinds; ++i) {
    json["rays"][std::string(kRayKindNames[i])] = {
        {"count", stats.rays[i]},
        {"traced_mrays_per_s", speed.traced_mrays_per_second(RayKind(i))},
        {"raw_mrays_per_s", Measured(speed.raw_mrays_per_second(RayKind(i)))}};
  }
  json["machine"] = Json(machine);
  json["summary"] = {{"msamples_per_s", double(stats.samples) / seconds * 1e-6},
                     {"mrays_per_s", double(stats.total_rays()) / seconds * 1e-6},
                     {"embree_fraction", Measured(speed.embree_fraction())}};
  return json;
}

// Writes a result to the file that was asked for, and to standard output in the form of another
// tool. Returns true if the latter takes the place of the text.
bool WriteResult(const BenchFlags& flags, const nlohmann::ordered_json& json) {
  if (!flags.json.empty()) WriteFileAtomically(flags.json, JsonText(json, 2) + "\n");
  if (!flags.export_as) return false;
  Print(stdout, "{}\n", JsonText(Export(RecordOf(json, "this run"), *flags.export_as), 2));
  return true;
}

}  // namespace

int RepetitionsOf(const BenchFlags& flags) {
  return flags.repetitions.value_or(flags.has_scene() ? kSceneRepetitions
                                    : flags.full      ? kFullRepetitions
                                                      : kQuickRepetitions);
}

double DeviationOf(const BenchFlags& flags) {
  if (flags.deviation_percent) return *flags.deviation_percent / 100;
  return flags.repetitions ? 0 : kDeviationLimit;
}

bool PictureIsRight(const SuiteScene& scene, PictureCheck check, const Fingerprint& found) {
  if (check == PictureCheck::kSameBits) return true;
  if (check == PictureCheck::kWithinBounds) {
    Print(stderr,
          "note: {}: these are not the hits of AVX2, so the picture was compared by the means "
          "of its blocks: they differ by {:.2g} at most\n",
          scene.name, BlockDifference(scene.expected, found));
    return true;
  }
  Print(stderr,
        "skywave: {}: not the picture that the suite expects, so there is no score; blocks "
        "differ by {:.2g} at most\nskywave: this one is {{0x{:016x}, {{",
        scene.name, BlockDifference(scene.expected, found), found.hash);
  for (const float mean : found.means) Print(stderr, "{:.9g}f, ", mean);
  Print(stderr, "}}}}\n");
  return false;
}

int BenchScene(const BenchFlags& flags) {
  if (!flags.json.empty()) CheckWritable(flags.json);
  HardwareWatch hardware;
  const FilesRead inputs;
  const RenderJob job(flags.request);
  inputs.CheckAreNot(std::array{flags.json});
  PrintRemarks(job);
  Film film = job.MakeFilm();
  const Speed speed = MeasureSpeed(job,
                                   {.repetitions = RepetitionsOf(flags),
                                    .deviation = DeviationOf(flags),
                                    .thread_counts = {},
                                    .replay = !flags.renders_only,
                                    .hardware = &hardware},
                                   film);
  const RenderStats& stats = speed.first.stats;
  if (!flags.renders_only && double(stats.total_rays()) > kMaxRecordedRays) {
    Print(stderr, "note: {:.0f} million rays kept for the replay; use fewer --spp\n",
          double(stats.total_rays()) * 1e-6);
  }
  const Machine machine = DescribeMachine(flags.request.embree_config);
  PrintGovernor(machine);
  PrintDoubts(speed, job.request().scene);
  const nlohmann::ordered_json json = SceneJson(job, film, speed, machine);
  if (WriteResult(flags, json)) return 0;
  const nlohmann::ordered_json& summary = json.at("summary");
  Print(stdout, "{}{} threads, medians of {}\n{}{}", flags.renders_only ? "" : "raw Embree, ",
        speed.first.threads, speed.render.size(), ReplayText(speed), RayText(speed));
  Print(stdout, "render    {:>16}, backend {}\n{}", RenderText(speed),
        ToString(job.options().backend), HardwareText(speed));
  Print(stdout, "SUMMARY msamples_per_s={:.3f} mrays_per_s={:.3f}{}\n",
        summary.at("msamples_per_s").get<double>(), summary.at("mrays_per_s").get<double>(),
        flags.renders_only ? "" : fmt::format(" embree_fraction={:.3f}", speed.embree_fraction()));
  return 0;
}

int BenchSuite(const BenchFlags& flags) {
  CheckOutputs(std::array{flags.json, flags.report}, flags.history);
  std::vector<HistoryEntry> history;
  for (const std::string& path : flags.history) history.push_back(ReadHistory(path));

  HardwareWatch hardware;
  SpeedSettings settings;
  settings.hardware = &hardware;
  settings.repetitions = flags.counters ? 0 : RepetitionsOf(flags);
  settings.deviation = DeviationOf(flags);
  settings.replay = !flags.counters && !flags.renders_only;
  if (settings.replay) {
    settings.thread_counts = ScalingThreads(ThreadsFor(flags.request.options.threads));
  }
  SuiteReport report = {.full = flags.full,
                        .machine = DescribeMachine(flags.request.embree_config),
                        .repetitions = settings.repetitions,
                        .replayed = settings.replay};
  if (settings.repetitions > 0) PrintGovernor(report.machine);
  bool right = true;
  const bool tables = flags.counters || !flags.renders_only;
  const auto scenes = SuiteScenes(flags.full);
  // It is drawn between scenes only: a thread that watched would be measured as well.
  std::optional<ProgressDisplay> display(std::in_place, flags.progress, scenes.size());
  for (const SuiteScene& scene : scenes) {
    display->Begin(std::string(scene.name), 0);
    report.results.push_back(MeasureScene(scene, flags.request, settings, tables));
    display->Clear();
    const SuiteResult& result = report.results.back();
    right &= PictureIsRight(scene, result.check, result.found);
    PrintDoubts(result.speed, scene.name);
    display->End();
  }
  display.reset();
  report.options = report.results.front().options;
  // The counters of a wrong picture are shown because they help to find the change.
  if (flags.counters) {
    Print(stdout, "{}", CountersText(report.results));
    return right ? 0 : kExitWrongPicture;
  }
  if (!right) return kExitWrongPicture;
  if (!flags.report.empty()) WriteFileAtomically(flags.report, Html(report, history));
  if (WriteResult(flags, Json(report))) return 0;
  Print(stdout, "{}{}{}{}", Headline(report), SummaryLine(Summarize(report.results)),
        NotMeasured(report), SuiteText(report));
  return 0;
}

namespace {

#define FIELD SKYWAVE_FIELD
std::vector<OptionOf<BenchFlags>> Options() {
  constexpr OptionMaker<BenchFlags> option = {};
  // clang-format off
  return {
    option({.name = "repetitions", .help = "renders and replays, in turn", .default_text = "9; suite: 3, --full 9"}, FIELD(repetitions), Numbers(1, 1000)),
    option({.name = "deviation", .help = "go on until the fastest three quarters of the renders have this relative standard deviation, for at most four times the repetitions; 0: do not", .default_text = "2.5, or 0 with --repetitions", .metavar = "PERCENT"}, FIELD(deviation_percent), Numbers(0.0, 1000.0)),
    option({.name = "renders-only", .help = "no replays, other thread counts or tables: for comparisons of two programs"}, FIELD(renders_only), Switches()),
    option({.name = "json", .help = "write every repetition to this file"}, FIELD(json), Texts("JSON")),
    option({.name = "export", .help = "print, instead of the text, JSON for Bencher (bmf) or as Google Benchmark prints it"}, FIELD(export_as), NamesOfEnum<ExportFormat>()),
    ProgressOption<BenchFlags>(),
    option({.name = "full", .group = kSuite, .help = "larger pictures, more repetitions"}, FIELD(full), Switches()),
    option({.name = "rotate", .group = kSuite, .help = "each copy begins with another scene, so that different ones run at once", .needs = "copies"}, FIELD(rotate), Switches()),
    option({.name = "report", .group = kSuite, .help = "write a page with charts to this file"}, FIELD(report), Texts("HTML")),
    option({.name = "history", .group = kSuite, .help = "JSON files of earlier runs, for the page", .most_values = 1000, .needs = "report"}, FIELD(history), Texts("JSON ...")),
    option({.name = "sustain", .group = kOther, .help = "render for this long without a pause, to see whether the speed lasts as the machine grows warm", .metavar = "SECONDS"}, FIELD(sustain_seconds), Numbers(0.1, 1e6)),
    option({.name = "copies", .group = kOther, .help = "this many processes at once, one thread each, pinned one a core: the sum of what they do", .metavar = "N"}, FIELD(copies), Numbers(1, 4096)),
    option({.name = "compare", .group = kOther, .help = "compare two results of --json, or pairs of runs in turn (A B A B); exit codes: 1 if B is slower, 2 if the times cannot tell", .most_values = 1000}, FIELD(compare), Texts("JSON ...")),
    option({.name = "counters", .group = kGuard, .help = "only counters: rays, rows, bytes, hashes; the same text every time"}, FIELD(counters), Switches()),
    option({.name = "instructions", .group = kGuard, .help = "only instructions of each stage, counted by valgrind in a picture 64 pixels wide"}, FIELD(instructions), Switches()),
    option({.name = "baseline", .group = kGuard, .help = "compare the scene with this file; exit codes: 1 counters, 2 instructions, 3 time"}, FIELD(baseline), Texts("JSON")),
    option({.name = "update-baseline", .group = kGuard, .help = "replace the baseline, with the reason", .metavar = "WHY", .needs = "baseline"}, FIELD(new_baseline_reason), Texts("WHY")),
    option({.name = "gates", .group = kGuard, .help = "parts of a baseline to compare or to write; counters are always written", .most_values = 3, .delimiter = ',', .needs = "baseline"}, FIELD(gates), NamesOfEnum<BaselineGate>()),
    option({.name = "threshold", .group = kGuard, .help = "how much slower a run may be than the baseline, or than the other run", .metavar = "PERCENT"}, FIELD(threshold_percent), Numbers(0.0, 1000.0)),
  };
  // clang-format on
}
#undef FIELD

}  // namespace

Command BenchCommand() {
  const auto flags = std::make_shared<BenchFlags>();
  flags->request.samples_per_pixel = 8;
  Command command = {
      .name = "bench",
      .summary = "Speed of the suite or of a scene, and the share of it that is Embree's own",
      .footer =
          "Without a scene: the suite, built-in scenes at fixed sizes, half a minute on two quiet "
          "cores.\n"
          "Their pictures are compared with the known ones; no score where one differs (exit code "
          "1).\n"
          "Keys of its JSON: docs/bench_json.md. How a project guards a scene: "
          "docs/regression.md.\n\n"
          "The rays of one frame (8 samples a pixel unless --spp says otherwise) are recorded and\n"
          "replayed raw through every way to call Embree; embree_fraction is the best replay's "
          "time\n"
          "over the render's.\n\n"
          "Examples:\n  skywave bench --json b.json --report b.html\n"
          "  skywave bench gallery --repetitions 9\n"
          "  skywave bench --export bmf\n"
          "  skywave bench --compare monday.json tuesday.json\n"
          "  skywave bench gallery --baseline gallery.json --update-baseline \"first\""};
  AddOptions(command, JobOptions(), std::shared_ptr<JobRequest>(flags, &flags->request),
             {"aovs", "denoise"});
  OptionInfo& scene = OptionCalled(command, "scene");
  scene.required = false;
  scene.printed_default = "the suite";
  OptionCalled(command, "spp").printed_default = "8";
  const auto options = Options();
  AddOptions(command, options, flags);
  command.run = [flags, described = command](const GivenOptions& given) {
    const BenchKind& kind = KindOf(given);
    CheckGiven(described, kind, given, flags->has_scene());
    return TellFailures(flags->progress, [&] {
      return flags->has_scene() ? kind.scene(*flags) : kind.suite(*flags);
    });
  };
  return command;
}

}  // namespace skywave
