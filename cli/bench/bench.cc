// Implements skywave bench: the speed of the suite or of a scene, and Embree's share of it.
#include <fmt/format.h>

#include <algorithm>
#include <memory>
#include <optional>
#include <vector>

#include "base/error.h"
#include "base/files.h"
#include "base/granted.h"
#include "base/version.h"
#include "cli/bench/report.h"
#include "cli/commands.h"
#include "cli/progress.h"
#include "job/options.h"
#include "measure/revision.h"

namespace skywave {
namespace {

struct BenchFlags {
  JobRequest request;
  std::optional<int> repetitions;
  std::string json, report;
  std::vector<std::string> history;
  bool full = false, counters = false, renders_only = false;
  ProgressFlags progress;
};

constexpr int kSceneRepetitions = 5, kQuickRepetitions = 3, kFullRepetitions = 9;
constexpr int kExitWrongPicture = 1;
// Limit of rays that a replay keeps in memory without asking: 72 bytes each, in three orders.
constexpr double kMaxRecordedRays = 2e7;

constexpr std::string_view kSuite = "Suite";

// The suite takes the options of a job that do not change its pictures, and --seed, which makes the
// comparison fail on purpose; a scene takes none of the suite's options.
void CheckGiven(const Command& command, const GivenOptions& given, bool has_scene) {
  for (const BoundOption& option : command.options) {
    const OptionInfo& info = option.info;
    if (!given.contains(info.name)) continue;
    const InputPosition where = InputPosition::File("--" + std::string(info.name));
    if (has_scene && info.group == kSuite) {
      throw InputError(where, "belongs to the suite: give no scene", kExitUsage);
    }
    const bool of_job = info.scope == OptionScope::kPixels || info.scope == OptionScope::kInput ||
                        info.scope == OptionScope::kSpeed;
    if (!has_scene && of_job && !info.in_suite) {
      throw InputError(where, "the suite has fixed pictures: give a scene to measure others",
                       kExitUsage);
    }
  }
}

int BenchScene(const BenchFlags& flags) {
  if (!flags.json.empty()) CheckWritable(flags.json);
  const RenderJob job(flags.request);
  PrintNotes(job.notes());
  const int repetitions = flags.repetitions.value_or(kSceneRepetitions);
  Film film = job.MakeFilm();
  const Speed speed = MeasureSpeed(job, {.repetitions = repetitions, .thread_counts = {}}, film);
  const RenderStats& stats = speed.first.stats;
  if (double(stats.total_rays()) > kMaxRecordedRays) {
    fmt::print(stderr, "note: {:.0f} million rays kept for the replay; use fewer --spp\n",
               double(stats.total_rays()) * 1e-6);
  }
  const double seconds = speed.render_seconds();
  const double msamples = double(stats.samples) / seconds * 1e-6;
  const double mrays = double(stats.total_rays()) / seconds * 1e-6;
  fmt::print("raw Embree, {} threads, medians of {}\n{}{}", speed.first.threads, repetitions,
             ReplayText(speed), RayText(speed));
  fmt::print("render    {:>16.4f} s ({:.4f} to {:.4f}), backend {}\n", seconds,
             *std::min_element(speed.render.begin(), speed.render.end()),
             *std::max_element(speed.render.begin(), speed.render.end()),
             ToString(job.options().backend));
  fmt::print("SUMMARY msamples_per_s={:.3f} mrays_per_s={:.3f} embree_fraction={:.3f}\n", msamples,
             mrays, speed.embree_fraction());
  if (flags.json.empty()) return 0;
  nlohmann::ordered_json json;
  json["schema"] = "skywave-bench-2";
  json["version"] = Version();
  json["revision"] = GitRevision();
  json["command"] = "skywave render" + PictureOptions(job.request());
  json["threads"] = speed.first.threads;
  json["wave"] = job.options().wave;
  json["render_seconds"] = speed.render;
  const nlohmann::ordered_json measured = Json(speed);
  json["replay_seconds"] = measured.at("replay").at("traced").at("seconds");
  json["replay"] = measured.at("replay");
  for (std::uint32_t i = 0; i < kRayKinds; ++i) {
    json["rays"][std::string(kRayKindNames[i])] = {
        {"count", stats.rays[i]},
        {"traced_mrays_per_s", speed.traced_mrays_per_second(RayKind(i))},
        {"raw_mrays_per_s", speed.raw_mrays_per_second(RayKind(i))}};
  }
  json["summary"] = {{"msamples_per_s", msamples},
                     {"mrays_per_s", mrays},
                     {"embree_fraction", speed.embree_fraction()}};
  WriteFileAtomically(flags.json, json.dump(2) + "\n");
  return 0;
}

// Reports a wrong picture, and the expected values under which it would be right.
bool PictureIsRight(const SuiteResult& result) {
  if (result.check == PictureCheck::kSameBits) return true;
  if (result.check == PictureCheck::kWithinBounds) {
    fmt::print(stderr,
               "note: {}: these are not the hits of AVX2, so the picture was compared by the means "
               "of its blocks: they differ by {:.2g} at most\n",
               result.scene.name, BlockDifference(result.scene.expected, result.found));
    return true;
  }
  fmt::print(stderr,
             "skywave: {}: not the picture that the suite expects, so there is no score; blocks "
             "differ by {:.2g} at most\nskywave: this one is {{0x{:016x}, {{",
             result.scene.name, BlockDifference(result.scene.expected, result.found),
             result.found.hash);
  for (const float mean : result.found.means) fmt::print(stderr, "{:.9g}f, ", mean);
  fmt::print(stderr, "}}}}\n");
  return false;
}

int BenchSuite(const BenchFlags& flags) {
  for (const std::string& path : {flags.json, flags.report}) {
    if (!path.empty()) CheckWritable(path);
  }
  std::vector<HistoryEntry> history;
  for (const std::string& path : flags.history) history.push_back(ReadHistory(path));

  SpeedSettings settings;
  settings.repetitions =
      flags.counters
          ? 0
          : flags.repetitions.value_or(flags.full ? kFullRepetitions : kQuickRepetitions);
  settings.replay = !flags.counters && !flags.renders_only;
  if (settings.replay) {
    settings.thread_counts = ScalingThreads(ThreadsFor(flags.request.options.threads));
  }
  SuiteReport report = {.full = flags.full,
                        .machine = DescribeMachine(flags.request.embree_config),
                        .repetitions = settings.repetitions,
                        .replayed = settings.replay};
  bool right = true;
  const bool tables = flags.counters || !flags.renders_only;
  const auto scenes = SuiteScenes(flags.full);
  // It is drawn between scenes only: a thread that watched would be measured as well.
  std::optional<ProgressDisplay> display(std::in_place, flags.progress, scenes.size());
  for (const SuiteScene& scene : scenes) {
    display->Begin(std::string(scene.name), 0);
    report.results.push_back(MeasureScene(scene, flags.request, settings, tables));
    display->Clear();
    right &= PictureIsRight(report.results.back());
    display->End();
  }
  display.reset();
  report.options = report.results.front().options;
  // The counters of a wrong picture are shown because they help to find the change.
  if (flags.counters) {
    fmt::print("{}", CountersText(report.results));
    return right ? 0 : kExitWrongPicture;
  }
  if (!right) return kExitWrongPicture;
  fmt::print("{}{}{}{}", Headline(report), SummaryLine(Summarize(report.results)),
             NotMeasured(report), SuiteText(report));
  if (!flags.json.empty()) WriteFileAtomically(flags.json, Json(report).dump(2) + "\n");
  if (!flags.report.empty()) WriteFileAtomically(flags.report, Html(report, history));
  return 0;
}

#define FIELD SKYWAVE_FIELD
std::vector<OptionOf<BenchFlags>> Options() {
  constexpr OptionMaker<BenchFlags> option = {};
  // clang-format off
  return {
    option({.name = "repetitions", .help = "renders and replays, in turn", .default_text = "5; suite: 3, --full 9"}, FIELD(repetitions), Numbers(1, 1000)),
    option({.name = "json", .help = "write every repetition to this file"}, FIELD(json), Texts("JSON")),
    ProgressOption<BenchFlags>(),
    option({.name = "full", .group = kSuite, .help = "larger pictures, more repetitions"}, FIELD(full), Switches()),
    option({.name = "counters", .group = kSuite, .help = "only counters: rays, rows, bytes, hashes; the same text every time"}, FIELD(counters), Switches()),
    option({.name = "renders-only", .group = kSuite, .help = "no replays, other thread counts or tables: for comparisons of two programs"}, FIELD(renders_only), Switches()),
    option({.name = "report", .group = kSuite, .help = "write a page with charts to this file"}, FIELD(report), Texts("HTML")),
    option({.name = "history", .group = kSuite, .help = "JSON files of earlier runs, for the page", .most_values = 1000, .needs = "report"}, FIELD(history), Texts("JSON ...")),
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
          "Without a scene: the suite, built-in scenes at fixed sizes, under a minute on two "
          "cores.\n"
          "Their pictures are compared with the known ones; no score where one differs (exit code "
          "1).\n"
          "Keys of its JSON: docs/bench_json.md.\n\n"
          "The rays of one frame (8 samples a pixel unless --spp says otherwise) are recorded and\n"
          "replayed raw through every way to call Embree; embree_fraction is the best replay's "
          "time\n"
          "over the render's.\n\n"
          "Examples:\n  skywave bench --json b.json --report b.html\n"
          "  skywave bench gallery --repetitions 9"};
  AddOptions(command, JobOptions(), std::shared_ptr<JobRequest>(flags, &flags->request),
             {"aovs", "denoise"});
  OptionInfo& scene = OptionCalled(command, "scene");
  scene.required = false;
  scene.printed_default = "the suite";
  OptionCalled(command, "spp").printed_default = "8";
  const auto options = Options();
  AddOptions(command, options, flags);
  command.run = [flags, described = command](const GivenOptions& given) {
    const bool has_scene = !flags->request.scene.empty();
    CheckGiven(described, given, has_scene);
    return TellFailures(flags->progress,
                        [&] { return has_scene ? BenchScene(*flags) : BenchSuite(*flags); });
  };
  return command;
}

}  // namespace skywave
