// Implements skywave converge: light strategies and integrators by their error at equal time.
#include <fmt/format.h>

#include <algorithm>
#include <chrono>
#include <filesystem>
#include <limits>
#include <memory>
#include <optional>

#include "base/error.h"
#include "base/files.h"
#include "cli/commands.h"
#include "cli/converge/report.h"
#include "cli/flags.h"
#include "cli/job_flags.h"
#include "cli/progress.h"
#include "measure/reference_file.h"

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
  std::optional<Integrator> reference_integrator;  // unset: chosen by the contestants
  std::uint32_t reference_samples = 0;             // 0: chosen by the budgets
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

// Returns the command that repeats the same measurement.
std::string CommandText(const ConvergeFlags& flags, const RenderOptions& options) {
  std::string text = "skywave converge " + SceneFlags(flags.request, options) + " --strategies";
  for (const std::string& strategy : flags.strategies) text += " " + Quoted(strategy);
  if (!flags.integrators.empty()) text += " --integrators";
  for (const Integrator integrator : flags.integrators) {
    text += fmt::format(" {}", ToString(integrator));
  }
  if (flags.seconds > 0) {
    text += fmt::format(" --time {}", flags.seconds);
  } else {
    text += fmt::format(" --budgets {}", fmt::join(flags.budgets, ","));
  }
  text += fmt::format(" --repeats {} --measure {} --reference {}", flags.settings.repeats,
                      ToString(flags.settings.measure), Quoted(flags.reference));
  if (flags.reference_integrator) {
    text += fmt::format(" --reference-integrator {}", ToString(*flags.reference_integrator));
  }
  if (flags.reference_samples > 0) {
    text += fmt::format(" --reference-spp {}", flags.reference_samples);
  }
  if (flags.request.strategy != JobRequest().strategy) {
    text += " --reference-strategy " + Quoted(flags.request.strategy);
  }
  if (flags.target) text += fmt::format(" --target-error {}", *flags.target);
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
  const auto start = std::chrono::steady_clock::now();
  WithProgress(flags.quiet, std::uint64_t(options.width) * options.height * 2 * half,
               [&](Progress* done) {
                 report.reference = RenderReference(job, *report.reference_integrator, half, done);
               });
  report.reference_seconds =
      std::chrono::duration<double>(std::chrono::steady_clock::now() - start).count();
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
  report.command = CommandText(flags, job.options());
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

Integrator IntegratorCalled(const std::string& name, const std::string& flag) {
  const std::optional<Integrator> integrator = ParseIntegrator(name);
  if (!integrator) throw CLI::ValidationError(flag, "there is none called " + name);
  return *integrator;
}

void AddReferenceFlags(CLI::App& command, ConvergeFlags& flags) {
  const auto group = "Reference";
  command
      .add_option(
          "--reference", flags.reference,
          "picture of the same size, or auto: two independent halves by --reference-strategy")
      ->capture_default_str()
      ->group(group);
  command.add_option("--reference-strategy", flags.request.strategy, "of auto")
      ->capture_default_str()
      ->group(group);
  command
      .add_option_function<std::string>(
          "--reference-integrator",
          [&flags](const std::string& name) {
            flags.reference_integrator = IntegratorCalled(name, "--reference-integrator");
          },
          "of auto (default: path, or direct where nothing else is compared)")
      ->type_name("NAME")
      ->group(group);
  command
      .add_option("--reference-spp", flags.reference_samples,
                  "samples a pixel of auto, both halves (default: 16 times the largest budget)")
      ->check(CLI::Range(2u, 2 * kMaxSamples))
      ->group(group);
  command
      .add_option("--save-reference", flags.save_reference,
                  "keep it as EXR, for --reference another time")
      ->group(group);
}

}  // namespace

void AddConvergeCommand(CLI::App& program, Run& run) {
  CLI::App* command =
      program.add_subcommand("converge", "Strategies and integrators by error at equal time");
  const auto flags = std::make_shared<ConvergeFlags>();
  AddJobFlags(*command, flags->request);
  command->remove_option(command->get_option("--strategy"));
  command->remove_option(command->get_option("--spp"));
  command
      ->add_option("--strategies", flags->strategies,
                   "one or more, separated by spaces; the first is what others are compared with")
      ->capture_default_str()
      ->expected(1, 100)
      ->type_name("NAME[:KEY=VALUE,...] ...");
  command
      ->add_option_function<std::vector<std::string>>(
          "--integrators",
          [flags](const std::vector<std::string>& names) {
            for (const std::string& name : names) {
              flags->integrators.push_back(IntegratorCalled(name, "--integrators"));
            }
          },
          "instead of one: each with every strategy; the first is what others are compared with")
      ->expected(1, 100)
      ->excludes("--integrator")
      ->type_name("NAME ...");
  auto* const budgets =
      command
          ->add_option("--budgets", flags->budgets,
                       "samples a pixel, separated by commas (default: 1,2,4,...,64)")
          ->delimiter(',')
          ->expected(1, 64)
          ->check(CLI::Range(1u, kMaxSamples))
          ->type_name("N,N,...");
  command
      ->add_option("--time", flags->seconds,
                   "instead: 1,2,4,... for each strategy up to renders of about this [s]")
      ->check(FiniteNumber(0.001, 1e6))
      ->excludes(budgets);
  command->add_option("--repeats", flags->settings.repeats, "of each render, with seeds of its own")
      ->check(CLI::Range(2, 1000))
      ->capture_default_str();
  command
      ->add_option_function<std::string>(
          "--measure",
          [flags](const std::string& name) { flags->settings.measure = *ParseErrorMeasure(name); },
          "of error (default: mse)")
      ->check(CLI::IsMember({"mse", "relative_mse"}));
  command
      ->add_option("--target-error", flags->target,
                   "error that times are compared at (default: the first strategy's smallest)")
      ->check(FiniteNumber(1e-30, 1e30));
  AddReferenceFlags(*command, *flags);
  const auto output = "Output";
  command->add_option("--json", flags->json, "every run and figure (keys: docs/converge.md)")
      ->group(output);
  command->add_option("--plot", flags->plot, "curves as SVG")->group(output);
  command->add_option("--report", flags->html, "one HTML page: figures, curves, pictures, errors")
      ->group(output);
  command->add_option("--exposure", flags->tone.exposure_stops, "of the page's pictures [stops]")
      ->check(FiniteNumber(-100, 100))
      ->group(output);
  command->add_flag("-q,--quiet", flags->quiet, "no notes and no progress")->group(output);
  command->footer(
      "Examples:\n"
      "  skywave converge gallery --strategies importance bsdf uniform --report gallery.html\n"
      "  skywave converge scene.pbrt --env probe.exr --integrator direct --time 10 --repeats 9 \\\n"
      "      --strategies importance hybrid:lights=64,inside=1 --plot curves.svg --json runs.json\n"
      "  skywave converge gallery --integrators path direct --time 5\n"
      "  skywave converge gallery --strategies importance penrose:lights=256 --budgets 4,16,64 \\\n"
      "      --reference gallery_reference.exr --target-error 1e-4");
  command->callback([flags, &run, command] {
    if (flags->budgets.empty()) flags->budgets = DoublingLadder(64);
    run = [flags] { return ConvergeMain(*flags); };
  });
}

}  // namespace skywave
