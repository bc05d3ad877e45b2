// Implements skywave converge: light strategies and integrators by their error at equal time.
#include <array>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "base/files.h"
#include "bench/measure/converge/run.h"
#include "cli/commands.h"
#include "cli/converge/report.h"
#include "cli/print.h"
#include "cli/progress.h"
#include "job/map_sequence.h"
#include "job/options.h"

namespace skywave {
namespace {

struct ConvergeFlags {
  ConvergeRequest request;
  std::string json, plot, html;
  ToneMapping tone;
  ProgressFlags progress;
};

void CheckFiles(const ConvergeFlags& flags) {
  CheckSavedReference(flags.request);
  CheckOutputs(std::array{flags.json, flags.plot, flags.html}, std::array{flags.request.reference});
}

#define FIELD SKYWAVE_FIELD
std::vector<OptionOf<ConvergeFlags>> OutputOptions() {
  const auto option = [](OptionInfo info, auto field, auto codec) {
    info.group = "Output";
    return MakeOption<ConvergeFlags>(info, field, codec);
  };
  // clang-format off
  return {
    option({.name = "json", .help = "every run and figure (keys: docs/converge.md)"}, FIELD(json), Texts("JSON")),
    option({.name = "plot", .help = "curves as SVG"}, FIELD(plot), Texts("SVG")),
    option({.name = "report", .help = "one HTML page: figures, curves, pictures, errors"}, FIELD(html), Texts("HTML")),
    option({.name = "exposure", .help = "exposure of the page's pictures [stops]"}, FIELD(tone.exposure_stops), Floats(-100, 100)),
    option({.name = "quiet", .help = "no notes and no progress", .letter = 'q'}, FIELD(progress.quiet), Switches()),
    ProgressOption<ConvergeFlags>(),
  };
  // clang-format on
}
#undef FIELD

void WriteOutputs(const ConvergeFlags& flags, const ConvergeReport& report) {
  if (!flags.json.empty()) WriteFileAtomically(flags.json, JsonText(report) + "\n");
  if (!flags.plot.empty()) WriteFileAtomically(flags.plot, Svg(Plots(report)));
  if (!flags.html.empty()) WriteFileAtomically(flags.html, Html(report, flags.tone));
}

int ConvergeMain(const ConvergeFlags& flags) {
  CheckFiles(flags);
  const FilesRead inputs;
  const RenderJob job(flags.request.job);
  inputs.CheckAreNot(std::array{flags.json, flags.plot, flags.html, flags.request.save_reference});
  if (!flags.progress.quiet) PrintRemarks(job);
  // The steps are the reference, unless it is given, and the measurement.
  std::optional<ProgressDisplay> display(std::in_place, flags.progress,
                                         flags.request.reference == "auto" ? 2 : 1);
  const ConvergeReport report =
      RunConverge(job, flags.request,
                  [&](const std::string& what, std::uint64_t total, const WatchedWork& work) {
                    ShowProgress(*display, what, total, work);
                  });
  display.reset();
  WriteOutputs(flags, report);
  for (const std::string& warning : report.warnings) {
    Print(stderr, "warning: {}\n", warning);
  }
  Print(stdout, "{}\n{}\n{}\n{}", Introduction(report), Text(BudgetTable(report)),
        TargetText(report), Text(TargetTable(report)));
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
        return TellFailures(flags->progress, [&] { return ConvergeMain(*flags); });
      }};
  std::set<std::string_view> without;
  for (const JobOption& option : JobOptions()) {
    if (HasOwnFormInConverge(option)) without.insert(option.name);
  }
  AddOptions(command, JobOptions(), std::shared_ptr<JobRequest>(flags, &flags->request.job),
             without);
  AddOptions(command, ConvergeOptions(), std::shared_ptr<ConvergeRequest>(flags, &flags->request));
  AddOptions(command, OutputOptions(), flags);
  return command;
}

}  // namespace skywave
