// Implements skywave converge: light strategies and integrators by their error at equal time.
#include <fmt/format.h>

#include <algorithm>
#include <filesystem>
#include <limits>
#include <memory>
#include <optional>

#include "base/clock.h"
#include "base/error.h"
#include "base/files.h"
#include "cli/commands.h"
#include "cli/converge/report.h"
#include "cli/progress.h"
#include "job/job.h"
#include "job/options.h"
#include "job/resolve.h"
#include "measure/reference_file.h"
#include "wavefront/option_names.h"

namespace skywave {
namespace {

constexpr std::uint32_t kMaxSamples = 1 << 24;

// Returns the largest number of samples per pixel whose light samples and continuations are still
// points of its sequence (see RenderJob).
std::uint32_t MostSamples(const RenderOptions& options) {
  return std::min(kMaxSamples,
                  std::numeric_limits<std::uint32_t>::max() / MostPointsOfASample(options));
}

struct ConvergeFlags {
  JobRequest request;
  std::vector<std::string> strategies = {"importance"};
  std::vector<Integrator> integrators;  // empty: that of the job
  std::vector<std::uint32_t> budgets;
  double seconds = 0;  // 0: budgets determine the samples
  ConvergeSettings settings;
  std::optional<double> target;
  std::string reference = "auto";
  std::optional<Integrator> reference_integrator;  // unset: derived from the contestants
  std::uint32_t reference_samples = 0;             // 0: derived from the budgets
  std::string save_reference, json, plot, html;
  ToneMapping tone;
  bool quiet = false;
};

void CheckOutputs(const ConvergeFlags& flags) {
  if (!flags.save_reference.empty()) {
    const InputPosition where = InputPosition::File("--save-reference " + flags.save_reference);
    if (flags.reference != "auto") {
      throw InputError(where, "keeps the reference of --reference auto, and no other", kExitUsage);
    }
    if (std::filesystem::path(flags.save_reference).extension() != ".exr") {
      throw InputError(where, "the reference is an EXR file, so its name has to end in .exr",
                       kExitUsage);
    }
  }
  for (const std::string& path : {flags.save_reference, flags.json, flags.plot, flags.html}) {
    if (path.empty()) continue;
    CheckNotInput(path, flags.request.scene);
    CheckNotInput(path, flags.request.environment.path);
    CheckNotInput(path, flags.reference);
    CheckWritable(path);
  }
}

// These options of a job have a different form in converge.
constexpr std::string_view kOwnForm[] = {"strategy", "spp", "aovs"};

#define FIELD SKYWAVE_FIELD
std::vector<OptionOf<ConvergeFlags>> Options() {
  const auto option = [](OptionInfo info, auto field, auto codec) {
    return MakeOption<ConvergeFlags>(info, field, codec);
  };
  constexpr OptionScope kPixels = OptionScope::kPixels;
  constexpr std::string_view kReference = "Reference", kOutput = "Output";
  const auto integrators = NamesOfEnum<Integrator>();
  // clang-format off
  return {
    option({.name = "strategies", .help = "the first is the one that others are compared with", .scope = kPixels, .metavar = "NAME[:KEY=VALUE,...] ...", .most_values = 100}, FIELD(strategies), Texts("strategies")),
    option({.name = "integrators", .help = "instead of one: each with every strategy; the first is the one that others are compared with", .scope = kPixels, .metavar = "NAME ...", .most_values = 100, .excludes = "integrator"}, FIELD(integrators), integrators),
    option({.name = "budgets", .help = "samples per pixel, separated by commas", .scope = kPixels, .default_text = "1,2,4,...,64", .metavar = "N,N,...", .most_values = 64, .delimiter = ','}, FIELD(budgets), Numbers(1u, kMaxSamples)),
    option({.name = "time", .help = "instead: 1,2,4,... for each strategy up to renders of about this [s]", .scope = kPixels, .excludes = "budgets"}, FIELD(seconds), Unless(0.0, Doubles(0.001, 1e6))),
    option({.name = "repeats", .help = "renders of each, with seeds of their own", .scope = kPixels}, FIELD(settings.repeats), Numbers(2, 1000)),
    option({.name = "measure", .help = "measure of error", .scope = kPixels}, FIELD(settings.measure), NamesOfEnum<ErrorMeasure>()),
    option({.name = "target-error", .help = "error that times are compared at", .scope = kPixels, .default_text = "the first strategy's smallest"}, FIELD(target), Doubles(1e-30, 1e30)),
    option({.name = "reference", .group = kReference, .help = "picture of the same size, or auto: two independent halves by --reference-strategy", .scope = kPixels, .metavar = "EXR|auto"}, FIELD(reference), Texts("a picture")),
    option({.name = "reference-strategy", .group = kReference, .help = "strategy of an automatic reference", .scope = kPixels}, FIELD(request.strategy), Texts("a strategy")),
    option({.name = "reference-integrator", .group = kReference, .help = "integrator of an automatic reference", .scope = kPixels, .default_text = "path, or direct where nothing else is compared"}, FIELD(reference_integrator), integrators),
    option({.name = "reference-spp", .group = kReference, .help = "samples per pixel of an automatic reference, both halves", .scope = kPixels, .default_text = "16 times the largest budget"}, FIELD(reference_samples), Unless(0u, Numbers(2u, 2 * kMaxSamples))),
    option({.name = "save-reference", .group = kReference, .help = "keep it as EXR, for --reference another time"}, FIELD(save_reference), Texts("EXR")),
    option({.name = "json", .group = kOutput, .help = "every run and figure (keys: docs/converge.md)"}, FIELD(json), Texts("JSON")),
    option({.name = "plot", .group = kOutput, .help = "curves as SVG"}, FIELD(plot), Texts("SVG")),
    option({.name = "report", .group = kOutput, .help = "one HTML page: figures, curves, pictures, errors"}, FIELD(html), Texts("HTML")),
    option({.name = "exposure", .group = kOutput, .help = "exposure of the page's pictures [stops]"}, FIELD(tone.exposure_stops), Floats(-100, 100)),
    option({.name = "quiet", .group = kOutput, .help = "no notes and no progress", .letter = 'q'}, FIELD(quiet), Switches()),
  };
  // clang-format on
}
#undef FIELD

// Returns the command that repeats the same measurement.
std::string CommandText(const ConvergeFlags& flags, const JobRequest& resolved) {
  std::vector<std::string_view> without(std::begin(kOwnForm), std::end(kOwnForm));
  if (!flags.integrators.empty()) without.push_back("integrator");
  std::string text = "skywave converge" + PictureOptions(resolved, without);
  for (const OptionOf<ConvergeFlags>& option : Options()) {
    // If --time is given, it determines the budgets.
    if (option.scope != OptionScope::kPixels) continue;
    if (option.name == "budgets" && flags.seconds > 0) continue;
    text += CommandWords(option, flags);
  }
  return text;
}

std::vector<Contestant> PrepareContestants(const ConvergeFlags& flags, const RenderJob& job) {
  // All tables come first, so that a strategy that cannot be built is reported before rendering.
  std::vector<Contestant> contestants = MakeContestants(
      job, flags.strategies,
      flags.integrators.empty() ? std::vector{job.options().integrator} : flags.integrators);
  for (Contestant& contestant : contestants) {
    for (std::uint32_t samples : flags.seconds > 0 ? LadderForTime(job, contestant, flags.seconds,
                                                                   MostSamples(job.options()))
                                                   : flags.budgets) {
      contestant.ladder.push_back({.samples_per_pixel = samples, .runs = {}, .split = {}});
    }
    if (flags.seconds == 0) WarmUp(job, contestant);
  }
  return contestants;
}

// Shows a bar while `work` adds to its Progress up to `total`.
template <class Work>
void WithProgress(bool quiet, std::uint64_t total, const Work& work) {
  Progress done = 0;
  std::optional<ProgressDisplay> display;
  if (!quiet) display.emplace(done, total);
  work(&done);
}

void RenderOwnReference(const ConvergeFlags& flags, ConvergeReport& report) {
  const RenderJob& job = *report.job;
  std::uint64_t largest = 1;
  for (const Contestant& contestant : report.contestants) {
    largest = std::max<std::uint64_t>(largest, contestant.ladder.back().samples_per_pixel);
  }
  const std::uint64_t wanted = flags.reference_samples > 0 ? flags.reference_samples : 16 * largest;
  const auto half =
      std::uint32_t(std::min<std::uint64_t>((wanted + 1) / 2, MostSamples(job.options())));
  report.reference_samples = 2 * half;
  report.reference_integrator =
      flags.reference_integrator.value_or(ReferenceIntegrator(report.contestants));
  const RenderOptions& options = job.options();
  if (!flags.quiet) fmt::print(stderr, "reference: {} samples a pixel\n", 2 * half);
  const Clock::time_point start = Clock::now();
  WithProgress(flags.quiet, std::uint64_t(options.width) * options.height * 2 * half,
               [&](Progress* done) {
                 report.reference = RenderReference(job, *report.reference_integrator, half, done);
               });
  report.reference_seconds = SecondsSince(start);
  if (flags.save_reference.empty()) return;
  WriteReference(flags.save_reference,
                 {.reference = report.reference,
                  .samples_per_pixel = report.reference_samples,
                  .scene_hash = fmt::format("{:016x}", job.scene_hash())},
                 {{"command", report.command}, {"software", "skywave " SKYWAVE_VERSION}});
}

void ReadGivenReference(const ConvergeFlags& flags, ConvergeReport& report) {
  const RenderOptions& options = report.job->options();
  ReferenceFile file = ReadReference(flags.reference, options.width, options.height,
                                     flags.request.environment.limits);
  if (!file.scene_hash.empty() &&
      file.scene_hash != fmt::format("{:016x}", report.job->scene_hash())) {
    report.warnings.push_back(flags.reference + " shows another scene, or another light");
  }
  report.reference = std::move(file.reference);
  report.reference_samples = file.samples_per_pixel;
}

void WriteOutputs(const ConvergeFlags& flags, const ConvergeReport& report) {
  if (!flags.json.empty()) WriteFileAtomically(flags.json, Json(report).dump(2) + "\n");
  if (!flags.plot.empty()) WriteFileAtomically(flags.plot, Svg(Plots(report)));
  if (!flags.html.empty()) WriteFileAtomically(flags.html, Html(report));
}

int ConvergeMain(ConvergeFlags& flags) {
  CheckOutputs(flags);
  std::sort(flags.budgets.begin(), flags.budgets.end());
  flags.budgets.erase(std::unique(flags.budgets.begin(), flags.budgets.end()), flags.budgets.end());
  const RenderJob job(flags.request);
  if (!flags.quiet) {
    for (const std::string& note : job.notes()) fmt::print(stderr, "note: {}\n", note);
  }
  if (flags.budgets.back() > MostSamples(job.options())) {
    throw InputError(InputPosition::File("--budgets"),
                     fmt::format("{} samples a pixel with {} light samples or continuations each "
                                 "are more than the 2^32 points of a pixel's sequence",
                                 flags.budgets.back(), MostPointsOfASample(job.options())),
                     kExitUsage);
  }
  ConvergeReport report;
  report.job = &job;
  report.scene = flags.request.scene;
  report.command = CommandText(flags, job.request());
  report.settings = flags.settings;
  report.reference_source = flags.reference;
  report.tone = flags.tone;
  // A given reference is checked before the long work.
  if (flags.reference != "auto") ReadGivenReference(flags, report);
  report.contestants = PrepareContestants(flags, job);
  if (flags.reference == "auto") RenderOwnReference(flags, report);
  if (!flags.quiet) {
    fmt::print(stderr, "measuring: {} contestants, {} repeats\n", report.contestants.size(),
               flags.settings.repeats);
  }
  WithProgress(flags.quiet, SamplesToMeasure(job, flags.settings, report.contestants),
               [&](Progress* done) {
                 Measure(job, report.reference, flags.settings, report.contestants, done);
               });
  for (const Contestant& contestant : report.contestants) {
    report.curves.push_back(MakeCurveRuns(contestant, flags.settings.measure));
  }
  report.summary = SummarizeTarget(report.curves, flags.target);
  for (std::string& warning : FindWarnings(report)) report.warnings.push_back(std::move(warning));
  WriteOutputs(flags, report);
  for (const std::string& warning : report.warnings) {
    fmt::print(stderr, "warning: {}\n", warning);
  }
  fmt::print("{}\n{}\n{}\n{}", Introduction(report), Text(BudgetTable(report)), TargetText(report),
             Text(TargetTable(report)));
  return 0;
}

}  // namespace

Command ConvergeCommand() {
  const auto flags = std::make_shared<ConvergeFlags>();
  Command command = {
      .name = "converge",
      .summary = "Strategies and integrators by error at equal time",
      .footer =
          "Examples:\n"
          "  skywave converge gallery --strategies importance bsdf uniform --report gallery.html\n"
          "  skywave converge scene.pbrt --env probe.exr --integrator direct --time 10 --repeats 9 "
          "\\\n"
          "      --strategies importance hybrid:lights=64,inside=1 --plot curves.svg --json "
          "runs.json\n"
          "  skywave converge gallery --integrators path direct --time 5\n"
          "  skywave converge gallery --strategies importance penrose:lights=256 --budgets 4,16,64 "
          "\\\n"
          "      --reference gallery_reference.exr --target-error 1e-4",
      .run = [flags](const GivenOptions&) {
        if (flags->budgets.empty()) flags->budgets = DoublingLadder(64);
        return ConvergeMain(*flags);
      }};
  AddOptions(command, JobOptions(), std::shared_ptr<JobRequest>(flags, &flags->request),
             {std::begin(kOwnForm), std::end(kOwnForm)});
  const auto options = Options();
  AddOptions(command, options, flags);
  return command;
}

}  // namespace skywave
