#include "bench/measure/converge/run.h"

#include <fmt/format.h>

#include <algorithm>
#include <filesystem>
#include <limits>
#include <utility>

#include "base/clock.h"
#include "base/error.h"
#include "base/files.h"
#include "base/version.h"
#include "bench/measure/reference_file.h"
#include "job/map_sequence.h"
#include "job/options.h"
#include "job/resolve.h"
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

// Sorts the budgets and checks that pixels have points enough for them.
void SettleBudgets(const RenderOptions& options, std::vector<std::uint32_t>& budgets) {
  if (budgets.empty()) budgets = DoublingLadder(64);
  std::sort(budgets.begin(), budgets.end());
  budgets.erase(std::unique(budgets.begin(), budgets.end()), budgets.end());
  if (budgets.back() > MostSamples(options)) {
    throw OptionError("budgets", "",
                      fmt::format("{} samples a pixel with {} light samples or continuations each "
                                  "are more than the 2^32 points of a pixel's sequence",
                                  budgets.back(), MostPointsOfASample(options)));
  }
}

// Returns the command that repeats the same measurement.
std::string CommandText(const ConvergeRequest& request, const JobRequest& resolved) {
  std::vector<std::string_view> without;
  for (const JobOption& option : JobOptions()) {
    const bool replaced = option.name == "integrator" && !request.integrators.empty();
    if (replaced || HasOwnFormInConverge(option)) without.push_back(option.name);
  }
  std::string text = "skywave converge" + PictureOptions(resolved, without);
  for (const OptionOf<ConvergeRequest>& option : ConvergeOptions()) {
    // If the time is given, it determines the budgets.
    if (option.name == "budgets" && request.seconds > 0) continue;
    if (option.scope != OptionScope::kPixels) continue;
    text += CommandWords(option, request);
  }
  return text;
}

std::vector<Contestant> PrepareContestants(const ConvergeRequest& request, const RenderJob& job) {
  // All tables come first, so that a strategy that cannot be built is reported before rendering.
  std::vector<Contestant> contestants = MakeContestants(
      job, request.strategies,
      request.integrators.empty() ? std::vector{job.options().integrator} : request.integrators);
  for (Contestant& contestant : contestants) {
    for (std::uint32_t samples :
         request.seconds > 0
             ? LadderForTime(job, contestant, request.seconds, MostSamples(job.options()))
             : request.budgets) {
      contestant.ladder.push_back({.samples_per_pixel = samples, .runs = {}, .split = {}});
    }
    if (request.seconds == 0) WarmUp(job, contestant);
  }
  return contestants;
}

void RenderOwnReference(const ConvergeRequest& request, const Watcher& watch,
                        ConvergeReport& report) {
  const RenderJob& job = *report.job;
  std::uint64_t largest = 1;
  for (const Contestant& contestant : report.contestants) {
    largest = std::max<std::uint64_t>(largest, contestant.ladder.back().samples_per_pixel);
  }
  const std::uint64_t wanted =
      request.reference_samples > 0 ? request.reference_samples : 16 * largest;
  const auto half =
      std::uint32_t(std::min<std::uint64_t>((wanted + 1) / 2, MostSamples(job.options())));
  report.reference_samples = 2 * half;
  report.reference_integrator =
      request.reference_integrator.value_or(ReferenceIntegrator(report.contestants));
  const RenderOptions& options = job.options();
  const Clock::time_point start = Clock::now();
  watch(fmt::format("reference: {} samples a pixel", 2 * half),
        std::uint64_t(options.width) * options.height * 2 * half, [&](Progress& progress) {
          report.reference = RenderReference(job, *report.reference_integrator, half, &progress);
        });
  report.reference_seconds = SecondsSince(start);
  if (request.save_reference.empty()) return;
  Metadata provenance = {{"software", fmt::format("skywave {}", Version())}};
  if (!report.command.empty()) provenance.emplace_back("command", report.command);
  WriteReference(request.save_reference,
                 {.reference = report.reference,
                  .samples_per_pixel = report.reference_samples,
                  .scene_hash = fmt::format("{:016x}", job.scene_hash())},
                 std::move(provenance));
}

void ReadGivenReference(const ConvergeRequest& request, ConvergeReport& report) {
  const RenderOptions& options = report.job->options();
  ReferenceFile file = ReadReference(request.reference, options.width, options.height,
                                     request.job.environment.limits);
  if (!file.scene_hash.empty() &&
      file.scene_hash != fmt::format("{:016x}", report.job->scene_hash())) {
    report.warnings.push_back(request.reference + " shows another scene, or another light");
  }
  report.reference = std::move(file.reference);
  report.reference_samples = file.samples_per_pixel;
}

}  // namespace

#define FIELD SKYWAVE_FIELD
std::vector<OptionOf<ConvergeRequest>> ConvergeOptions() {
  const auto option = [](OptionInfo info, auto field, auto codec) {
    info.scope = OptionScope::kPixels;
    return MakeOption<ConvergeRequest>(info, field, codec);
  };
  constexpr std::string_view kReference = "Reference";
  const auto integrators = NamesOfEnum<Integrator>();
  // clang-format off
  return {
    option({.name = "strategies", .help = "the first is the one that others are compared with", .metavar = "NAME[:KEY=VALUE,...] ...", .most_values = 100}, FIELD(strategies), Texts("strategies")),
    option({.name = "integrators", .help = "instead of one: each with every strategy; the first is the one that others are compared with", .metavar = "NAME ...", .most_values = 100, .excludes = "integrator"}, FIELD(integrators), integrators),
    option({.name = "budgets", .help = "samples per pixel, separated by commas", .default_text = "1,2,4,...,64", .metavar = "N,N,...", .most_values = 64, .delimiter = ','}, FIELD(budgets), Numbers(1u, kMaxSamples)),
    option({.name = "time", .help = "instead: 1,2,4,... for each strategy up to renders of about this [s]", .excludes = "budgets"}, FIELD(seconds), Unless(0.0, Doubles(0.001, 1e6))),
    option({.name = "repeats", .help = "renders of each, with seeds of their own"}, FIELD(settings.repeats), Numbers(2, 1000)),
    option({.name = "measure", .help = "measure of error"}, FIELD(settings.measure), NamesOfEnum<ErrorMeasure>()),
    option({.name = "target-error", .help = "error at which times are compared", .default_text = "the first strategy's smallest"}, FIELD(target), Doubles(1e-30, 1e30)),
    option({.name = "reference", .group = kReference, .help = "picture of the same size, or auto: two independent halves by --reference-strategy", .metavar = "EXR|auto"}, FIELD(reference), Texts("a picture")),
    option({.name = "reference-strategy", .group = kReference, .help = "strategy of an automatic reference"}, FIELD(job.strategy), Texts("a strategy")),
    option({.name = "reference-integrator", .group = kReference, .help = "integrator of an automatic reference", .default_text = "path, or direct where nothing else is compared"}, FIELD(reference_integrator), integrators),
    option({.name = "reference-spp", .group = kReference, .help = "samples per pixel of an automatic reference, both halves", .default_text = "16 times the largest budget"}, FIELD(reference_samples), Unless(0u, Numbers(2u, 2 * kMaxSamples))),
    MakeOption<ConvergeRequest>({.name = "save-reference", .group = kReference, .help = "keep the reference as EXR, for a later --reference"}, FIELD(save_reference), Texts("EXR")),
  };
  // clang-format on
}
#undef FIELD

bool HasOwnFormInConverge(const OptionInfo& option) {
  return option.name == "strategy" || option.name == "spp" || option.name == "aovs" ||
         option.name == "denoise" || option.name == "working-space";
}

void CheckSavedReference(const ConvergeRequest& request) {
  const std::string& path = request.save_reference;
  if (path.empty()) return;
  if (request.reference != "auto") {
    throw OptionError("save-reference", path,
                      "keeps the reference of `reference auto`, and no other");
  }
  if (std::filesystem::path(path).extension() != ".exr") {
    throw OptionError("save-reference", path,
                      "the reference is an EXR file, so its name has to end in .exr");
  }
  CheckWritable(path);
}

ConvergeReport RunConverge(const RenderJob& job, ConvergeRequest request, const Watcher& watch) {
  SettleBudgets(job.options(), request.budgets);
  ConvergeReport report;
  report.job = &job;
  report.scene = request.job.scene;
  if (request.repeatable) report.command = CommandText(request, job.request());
  report.settings = request.settings;
  report.reference_source = request.reference;
  // A given reference is checked before the long work.
  if (request.reference != "auto") ReadGivenReference(request, report);
  report.contestants = PrepareContestants(request, job);
  if (request.reference == "auto") RenderOwnReference(request, watch, report);
  watch(fmt::format("measuring: {} contestants, {} repeats", report.contestants.size(),
                    request.settings.repeats),
        SamplesToMeasure(job, request.settings, report.contestants), [&](Progress& progress) {
          Measure(job, report.reference, request.settings, report.contestants, &progress);
        });
  for (const Contestant& contestant : report.contestants) {
    report.curves.push_back(MakeCurveRuns(contestant, request.settings.measure));
  }
  report.summary = SummarizeTarget(report.curves, request.target);
  for (std::string& warning : FindWarnings(report)) report.warnings.push_back(std::move(warning));
  return report;
}

}  // namespace skywave
