// Implements skywave render by the library: a scene becomes an EXR and a PNG.
#include <fmt/format.h>

#include <filesystem>
#include <memory>

#include "base/error.h"
#include "base/files.h"
#include "cli/commands.h"
#include "cli/parse.h"
#include "cli/progress.h"
#include "display/tev.h"
#include "job/exposure.h"
#include "job/options.h"
#include "skywave/skywave.h"
#include "wavefront/film/aovs.h"

namespace skywave {
namespace {

struct RenderFlags {
  JobRequest request;
  ExposureRequest exposure;
  api::Options read_options, options;  // as given, for the library
  std::string output;
  std::string stats;
  std::string viewer;
  ProgressFlags progress;
};

std::string PngPath(const std::string& exr) {
  return std::filesystem::path(exr).replace_extension(".png").string();
}

Codec<std::string> Viewers() {
  Codec<std::string> codec = Texts("HOST or HOST:PORT (port 14158)");
  codec.metavar = "HOST:PORT";
  codec.parse = [](const std::string& text) {
    return ParseViewerAddress(text) ? std::optional(text) : std::nullopt;
  };
  return codec;
}

#define FIELD SKYWAVE_FIELD
std::vector<OptionOf<RenderFlags>> OutputOptions() {
  const auto option = [](OptionInfo info, auto field, auto codec) {
    return MakeOption<RenderFlags>(info, field, codec);
  };
  // clang-format off
  return {
    option({.name = "output", .help = "EXR file; the PNG has the same name", .default_text = "name of the scene", .letter = 'o'}, FIELD(output), Texts("EXR")),
    option({.name = "quiet", .help = "print errors only", .letter = 'q'}, FIELD(progress.quiet), Switches()),
    option({.name = "stats", .group = "Output", .help = "write the statistics as JSON to this file"}, FIELD(stats), Texts("JSON")),
    option({.name = "display", .group = "Output", .help = "show the picture in the viewer tev while it is rendered"}, FIELD(viewer), Viewers()),
    ProgressOption<RenderFlags>(),
  };
  // clang-format on
}
#undef FIELD

void CheckOutputs(const RenderFlags& flags) {
  if (std::filesystem::path(flags.output).extension() != ".exr") {
    throw InputError(InputPosition::File("--output " + flags.output),
                     flags.request.options.aovs == 0
                         ? "the picture is an EXR file, so its name has to end in .exr"
                         : "the layers of --aovs need an EXR file, whose name ends in .exr",
                     kExitUsage);
  }
  for (const std::string& path : {flags.output, PngPath(flags.output), flags.stats}) {
    if (path.empty()) continue;
    CheckNotInput(path, flags.request.scene);
    CheckNotInput(path, flags.request.environment.path);
    CheckWritable(path);
  }
}

int RenderMain(RenderFlags& flags) {
  if (flags.output.empty()) {
    flags.output = std::filesystem::path(flags.request.scene).stem().string() + ".exr";
  }
  CheckOutputs(flags);
  api::Renderer renderer(api::Scene(flags.request.scene, flags.read_options), flags.options);
  if (!flags.progress.quiet) PrintNotes(renderer.notes());
  const std::size_t notes_before = renderer.notes().size();
  api::RenderControl control = {.viewer = flags.viewer, .name_in_viewer = flags.output};
  {
    ProgressDisplay display(flags.progress);
    display.Begin("", renderer.samples());
    control.progress = [&](double done) {
      display.Show(done);
      return true;
    };
    renderer.Render(control);
    display.End();
  }
  if (!flags.progress.quiet) {
    const std::vector<std::string>& notes = renderer.notes();
    PrintNotes({notes.begin() + std::ptrdiff_t(notes_before), notes.end()});
  }
  const std::string png = PngPath(flags.output);
  renderer.WriteExr(flags.output);
  renderer.WritePng(png);
  if (!flags.stats.empty()) WriteFileAtomically(flags.stats, renderer.Statistics());
  if (!flags.progress.quiet) {
    fmt::print("{}wrote {} and {}\n", renderer.Summary(), flags.output, png);
  }
  return 0;
}

// Adds `options`, which set `*request`. Their texts are also kept in `flags` for the library.
template <class Options, class Request>
void AddKeptOptions(Command& command, const Options& options,
                    const std::shared_ptr<Request>& request,
                    const std::shared_ptr<RenderFlags>& flags) {
  const std::size_t first = command.options.size();
  AddOptions(command, options, request);
  for (std::size_t i = first; i < command.options.size(); ++i) {
    BoundOption& option = command.options[i];
    if (option.info.positional) continue;
    const bool reads = IsReadOption(option.info);
    option.set = [flags, reads, name = std::string(option.info.name),
                  set = option.set](const std::vector<std::string>& texts) {
      (reads ? flags->read_options : flags->options).emplace_back(name, texts.back());
      return set(texts);
    };
  }
}

std::string IntegratorHelp() {
  std::string text = "Integrators (--integrator):\n";
  for (const Integrator integrator : ValuesOf<Integrator>()) {
    const std::string help = SpellFlags(Describe(integrator).help);
    text += fmt::format("  {:<7} {}\n", ToString(integrator), help);
  }
  return text + "\n";
}

std::string AovHelp() {
  std::string text = "Layers (--aovs):\n";
  for (const Aov& aov : Aovs()) {
    text += fmt::format("  {:<15} {:<4} {}\n", aov.name, aov.channels, aov.help);
  }
  return text + "\n";
}

}  // namespace

Command RenderCommand() {
  const auto flags = std::make_shared<RenderFlags>();
  Command command = {
      .name = "render",
      .summary = "Render a scene to EXR and PNG",
      .footer =
          IntegratorHelp() + AovHelp() +
          "Examples:\n"
          "  skywave render gallery -o gallery.exr\n"
          "  skywave render killeroo.pbrt --env grace.exr --env-up z --size 640x480 --spp 64\n"
          "  skywave render model.obj --env sky.hdr --ground\n"
          "  skywave render bunny.ply --env sky.hdr --integrator direct --light-samples 16\n"
          "  skywave render three-spheres --integrator vcm --spp 256\n"
          "  skywave render room --integrator bdpt --guide\n"
          "  skywave render gallery --aovs albedo,normal,depth -o gallery.exr",
      .run = [flags](const GivenOptions&) {
        return TellFailures(flags->progress, [&] { return RenderMain(*flags); });
      }};
  AddKeptOptions(command, JobOptions(), std::shared_ptr<JobRequest>(flags, &flags->request), flags);
  AddOptions(command, OutputOptions(), flags);
  AddKeptOptions(command, ExposureOptions(),
                 std::shared_ptr<ExposureRequest>(flags, &flags->exposure), flags);
  return command;
}

}  // namespace skywave
