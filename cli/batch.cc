// Implements skywave batch: the pictures of a job file, checked, listed or rendered.
#include <fmt/format.h>

#include <charconv>
#include <cstdio>
#include <filesystem>
#include <memory>
#include <nlohmann/json.hpp>
#include <optional>
#include <set>

#include "base/error.h"
#include "base/files.h"
#include "base/json.h"
#include "cli/commands.h"
#include "cli/print.h"
#include "cli/progress.h"
#include "cli/signals.h"
#include "cli/text_table.h"
#include "job/batch/check.h"
#include "job/batch/plan.h"
#include "job/batch/render_picture.h"
#include "job/batch/report.h"
#include "job/batch/run.h"
#include "job/batch/save.h"
#include "job/batch/slurm.h"
#include "wavefront/worker_pool.h"

namespace skywave {
namespace {

struct BatchFlags {
  std::string job_file, output_folder;
  BatchShare only;
  double checkpoint_seconds = 0;
  bool list = false, dry_run = false, json = false, force = false;
  std::string slurm;
  std::uint32_t shards = 1;
  ProgressFlags progress;
};

// Parses I/N.
Codec<BatchShare> Shares() {
  return {.values = "I/N, for example 1/4 for the first of four shares",
          .metavar = "I/N",
          .parse = [](const std::string& text) -> std::optional<BatchShare> {
            BatchShare share;
            const char *const begin = text.data(), *const end = begin + text.size();
            const auto [slash, bad_number] = std::from_chars(begin, end, share.number);
            if (bad_number != std::errc() || slash == end || *slash != '/') return std::nullopt;
            const auto [stop, bad_count] = std::from_chars(slash + 1, end, share.count);
            const bool good = bad_count == std::errc() && stop == end && share.number >= 1 &&
                              share.number <= share.count;
            return good ? std::optional(share) : std::nullopt;
          },
          .print =
              [](const BatchShare& share) {
                return share.count > 1 ? fmt::format("{}/{}", share.number, share.count)
                                       : std::string();
              }};
}

#define FIELD SKYWAVE_FIELD
std::vector<OptionOf<BatchFlags>> BatchOptions() {
  constexpr OptionMaker<BatchFlags> option = {};
  // clang-format off
  return {
    option({.name = "job", .help = "TOML file of options and axes (docs/batch.md)", .positional = true, .required = true}, FIELD(job_file), Texts("JOB")),
    option({.name = "output", .help = "folder that the path of [output] is relative to", .default_text = "that of the job file", .letter = 'o'}, FIELD(output_folder), Texts("FOLDER")),
    option({.name = "only", .help = "render one of N interleaved shares of the pictures", .default_text = "all of them"}, FIELD(only), Shares()),
    option({.name = "checkpoint", .help = "save an unfinished picture every so many seconds; SIGINT, SIGTERM and SIGHUP save it anyhow, and the same command goes on", .default_text = "never", .metavar = "SECONDS"}, FIELD(checkpoint_seconds), Unless(0.0, Doubles(0.01, 1e9))),
    option({.name = "force", .help = "also render pictures that are there already"}, FIELD(force), Switches()),
    option({.name = "list", .help = "print the pictures and their values, and render none", .excludes = "dry-run"}, FIELD(list), Switches()),
    option({.name = "json", .help = "with --list: print JSON", .needs = "list"}, FIELD(json), Switches()),
    option({.name = "dry-run", .help = "read every scene and map, check every option, and render nothing"}, FIELD(dry_run), Switches()),
    option({.name = "quiet", .help = "print errors only", .letter = 'q'}, FIELD(progress.quiet), Switches()),
    ProgressOption<BatchFlags>(),
    option({.name = "slurm", .group = "Farm", .help = "write scripts for Slurm to this folder, and render nothing (docs/farm.md)", .excludes = "only"}, FIELD(slurm), Texts("FOLDER")),
    option({.name = "shards", .group = "Farm", .help = "with --slurm: parts into which the samples of each picture are cut", .needs = "slurm"}, FIELD(shards), Numbers(1u, 1000u)),
  };
  // clang-format on
}
#undef FIELD

TextTable PictureTable(const BatchPlan& plan) {
  TextTable table = {{"picture", "output"}};
  for (const AxisValue& value : plan.pictures.front().axes) table.front().push_back(value.axis);
  for (const BatchPicture& picture : plan.pictures) {
    table.push_back({fmt::format("{}", picture.index), picture.output});
    for (const AxisValue& value : picture.axes) table.back().push_back(value.label);
  }
  return table;
}

std::string Rate(const PictureResult& result) {
  if (!(result.render_seconds > 0)) return "-";
  return fmt::format("{:.3f}", double(result.samples) / result.render_seconds * 1e-6);
}

TextTable ResultTable(const BatchPlan& plan, const BatchSummary& summary) {
  TextTable table = {{"picture", "status", "time [s]", "Msamples/s", "noise", "error"}};
  for (std::size_t i = 0; i < plan.pictures.size(); ++i) {
    const PictureResult& result = summary.results[i];
    table.push_back(
        {plan.pictures[i].output, std::string(ToString(result.status)),
         fmt::format("{:.3f}", result.load_seconds + result.render_seconds + result.write_seconds),
         Rate(result), result.noise ? fmt::format("{:.4g}", *result.noise) : "-", result.error});
  }
  return table;
}

// Renders the pictures and returns the exit code.
int RenderBatch(const BatchFlags& flags, const BatchPlan& plan) {
  OutliveClosedPipes();
  CheckOutputs(plan);
  PrepareOutputs(plan, flags.only);
  ProgressDisplay display(flags.progress, plan.pictures.size());
  PictureRenderer renderer(plan, {.cache_bytes = plan.memory_bytes,
                                  .force = flags.force,
                                  .checkpoint_seconds = flags.checkpoint_seconds});
  CatchStopSignals();
  const auto render = [&](const BatchPicture& picture, const BatchPicture* next) {
    if (StopAsked()) throw RenderCanceled();
    return renderer.Render(
        picture, next,
        {.begin = [&](std::uint64_t samples) { display.Begin(picture.output, samples); },
         .tell =
             [&](double done) {
               display.Show(done);
               return !StopAsked();
             }});
  };
  BatchReporter reporter;
  std::set<std::string> told;  // remarks are the same for many pictures
  reporter.end = [&](const BatchPicture&, const PictureResult& result) {
    if (result.status == PictureStatus::kRendered) {
      display.End();
    } else {
      display.Skip();
    }
    const auto tell = [&](const std::vector<std::string>& remarks, bool are_warnings) {
      for (const std::string& remark : remarks) {
        if (flags.progress.quiet || !told.insert(remark).second) continue;
        display.Clear();
        are_warnings ? PrintWarnings({remark}) : PrintNotes({remark});
      }
    };
    tell(result.warnings, true);
    tell(result.notes, false);
  };
  BatchFiles files(plan, flags.only);
  reporter.save = [&](const BatchSummary& summary) { files.Save(summary); };
  const BatchSummary summary = files.WithEarlier(RunBatch(plan, render, reporter));
  display.Clear();
  if (!flags.progress.quiet) Put(stdout, Text(ResultTable(plan, summary)));
  for (std::size_t i = 0; i < plan.pictures.size(); ++i) {
    const PictureResult& result = summary.results[i];
    if (result.status != PictureStatus::kFailed) continue;
    Print(stderr, "skywave: {}: {}\n", plan.pictures[i].output, result.error);
  }
  if (!summary.stopped.empty()) Print(stderr, "skywave: {}\n", summary.stopped);
  return summary.exit_code;
}

int WriteSlurmScripts(const BatchFlags& flags, const BatchPlan& plan) {
  CheckOutputs(plan);
  const SlurmPlan slurm = PlanForSlurm(plan, flags.output_folder, flags.slurm, flags.shards);
  std::error_code error;
  std::filesystem::create_directories(slurm.folder, error);
  for (const SlurmScript& script : SlurmScripts(slurm)) {
    const std::string path = slurm.folder + "/" + script.name;
    WriteFileAtomically(path, script.text);
    std::filesystem::permissions(path, std::filesystem::perms::owner_exec,
                                 std::filesystem::perm_options::add, error);
  }
  if (!flags.progress.quiet) {
    Print(stdout, "wrote scripts for {} pictures; submit them with {}/submit.sh\n",
          plan.pictures.size(), slurm.folder);
  }
  return 0;
}

int BatchMain(const BatchFlags& flags) {
  const BatchPlan plan = ShareOf(ReadBatchPlan(flags.job_file, flags.output_folder), flags.only);
  if (plan.pictures.empty()) {
    Print(stdout, "share {} of {} has none of the {} pictures\n", flags.only.number,
          flags.only.count, plan.all_pictures);
    return 0;
  }
  if (flags.list) {
    Print(stdout, "{}", flags.json ? JsonText(ListJson(plan), 2) + "\n" : Text(PictureTable(plan)));
    return 0;
  }
  if (flags.dry_run) {
    const DryRun checked = CheckWithoutRendering(plan);
    Print(stdout, "{}{} pictures, {:.4g} Msamples, of {} scenes and {} maps: all can be rendered\n",
          flags.progress.quiet ? "" : Text(PictureTable(plan)), plan.pictures.size(),
          double(checked.samples) * 1e-6, checked.scenes, checked.maps);
    return 0;
  }
  if (!flags.slurm.empty()) return WriteSlurmScripts(flags, plan);
  try {
    return RenderBatch(flags, plan);
  } catch (const RenderCanceled&) {
    Print(stderr, "stopped; the same command goes on from here\n");
    return kExitTryAgain;
  }
}

}  // namespace

Command BatchCommand() {
  return CommandOf<BatchFlags>(
      {.name = "batch",
       .summary = "Render the pictures of a job file: axes crossed, one process",
       .footer = "Examples:\n"
                 "  skywave batch turntable.toml --list\n"
                 "  skywave batch turntable.toml --dry-run\n"
                 "  skywave batch turntable.toml -o renders\n"
                 "  skywave batch turntable.toml --only 1/4\n"
                 "  skywave batch turntable.toml --slurm farm --shards 8"},
      BatchOptions(), [](const BatchFlags& flags) {
        return TellFailures(flags.progress, [&] { return BatchMain(flags); });
      });
}

}  // namespace skywave
