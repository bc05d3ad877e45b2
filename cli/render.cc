// Implements skywave render by the library: a scene becomes an EXR and a PNG.
#include <fmt/format.h>

#include <algorithm>
#include <filesystem>
#include <memory>
#include <optional>
#include <string_view>
#include <vector>

#include "api/display/tev.h"
#include "base/error.h"
#include "base/files.h"
#include "cli/commands.h"
#include "cli/parse.h"
#include "cli/print.h"
#include "cli/progress.h"
#include "cli/signals.h"
#include "job/map_sequence.h"
#include "job/picture.h"
#include "job/picture_request.h"
#include "skywave/skywave.h"
#include "wavefront/film/aovs.h"

namespace skywave {
namespace {

struct RenderFlags {
  PictureRequest picture;
  api::Options read_options, options;  // as given, for the library
  std::string output;                  // empty: a film is all that is wanted
  std::string film;
  std::string stats;
  std::optional<double> checkpoint_seconds;
  bool resume = false;
  std::string viewer;
  ProgressFlags progress;

  bool keeps_checkpoint() const { return checkpoint_seconds || resume; }
};

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
  constexpr OptionMaker<RenderFlags> option = {};
  constexpr std::string_view kStopping = "Stopping and going on";
  // clang-format off
  return {
    option({.name = "output", .help = "EXR file; the PNG has the same name", .default_text = "name of the scene", .letter = 'o'}, FIELD(output), Texts("EXR")),
    option({.name = "film", .help = "keep the sums of the film, for skywave merge; without --output they are all that is written"}, FIELD(film), Texts("FILM")),
    option({.name = "quiet", .help = "print errors only", .letter = 'q'}, FIELD(progress.quiet), Switches()),
    option({.name = "checkpoint", .group = kStopping, .help = "save the render every so many seconds; 0: only on SIGINT, SIGTERM or SIGHUP, after which the exit code is 75; the file is named after the output, with the ending .checkpoint, and is removed when all is written", .default_text = "never", .metavar = "SECONDS"}, FIELD(checkpoint_seconds), Doubles(0, 1e9)),
    option({.name = "resume", .group = kStopping, .help = "go on from the checkpoint, if there is one, to the same bytes"}, FIELD(resume), Switches()),
    option({.name = "stats", .group = "Output", .help = "write the statistics as JSON to this file"}, FIELD(stats), Texts("JSON")),
    option({.name = "display", .group = "Output", .help = "show the picture in the viewer tev while it is rendered"}, FIELD(viewer), Viewers()),
    ProgressOption<RenderFlags>(),
  };
  // clang-format on
}
#undef FIELD

std::string CheckpointPath(const RenderFlags& flags) {
  const std::string& beside = flags.output.empty() ? flags.film : flags.output;
  return CheckpointBeside(beside);
}

std::string SnapshotPath(const RenderFlags& flags) {
  return NameBeside(flags.output, ".snapshot.exr");
}

// Returns the names of all files that are written.
std::vector<std::string> Outputs(const RenderFlags& flags) {
  std::vector<std::string> outputs;
  if (!flags.output.empty()) outputs = {flags.output, PngBeside(flags.output)};
  for (const std::string& path : {flags.film, flags.stats}) {
    if (!path.empty()) outputs.push_back(path);
  }
  if (flags.keeps_checkpoint()) outputs.push_back(CheckpointPath(flags));
  return outputs;
}

void CheckOutputs(const RenderFlags& flags) {
  if (!flags.output.empty() && std::filesystem::path(flags.output).extension() != ".exr") {
    throw InputError(
        InputPosition::File("--output " + flags.output),
        flags.picture.job.options.aovs == 0
            ? "the picture is an EXR file with a PNG beside it, so its name has to end in .exr; to "
              "pass it on, let it be that of a pipe (mkfifo)"
            : "the layers of --aovs need an EXR file, whose name ends in .exr",
        kExitUsage);
  }
  const auto given = [&](std::string_view name) {
    return std::any_of(flags.options.begin(), flags.options.end(),
                       [&](const auto& option) { return option.first == name; });
  };
  for (const OptionOf<ExrFormat>& option : ExrFormatOptions()) {
    if (flags.output.empty() && given(option.name)) {
      throw InputError(InputPosition::File(fmt::format("--{}", option.name)),
                       "is about the picture, and a film alone is written; --output names a "
                       "picture, too",
                       kExitUsage);
    }
  }
  if (!flags.film.empty() && flags.picture.limits.adaptive > 0) {
    throw InputError(InputPosition::File("--film " + flags.film),
                     "films are added where all pixels have the same samples, so none is kept with "
                     "--adaptive",
                     kExitUsage);
  }
  const std::vector<std::string> outputs = Outputs(flags);
  for (std::size_t i = 0; i < outputs.size(); ++i) {
    const std::string& path = outputs[i];
    if (std::find(outputs.begin(), outputs.begin() + std::ptrdiff_t(i), path) !=
        outputs.begin() + std::ptrdiff_t(i)) {
      throw InputError(InputPosition::File(path), "is to be written twice; give another name",
                       kExitUsage);
    }
  }
  CheckAllWritable(outputs);
  // Whether a snapshot is written is known only later.
  const std::string snapshot = SnapshotPath(flags);
  RemoveLeftovers(std::vector<std::string>{snapshot, PngBeside(snapshot)});
}

// Reads the scene and all that it names, which the outputs must leave as they are.
api::Renderer ReadRenderer(const RenderFlags& flags) {
  const FilesRead inputs;
  api::Renderer renderer(api::Scene(flags.picture.job.scene, flags.read_options), flags.options);
  inputs.CheckAreNot(Outputs(flags));
  return renderer;
}

// Renders, and shows progress and what signals ask for.
void RenderWatched(const RenderFlags& flags, api::Renderer& renderer) {
  if (!flags.progress.quiet) {
    PrintWarnings(renderer.warnings());
    PrintNotes(renderer.notes());
  }
  const std::size_t notes = renderer.notes().size();
  ProgressDisplay display(flags.progress);
  api::RenderControl control = {.progress =
                                    [&](double done) {
                                      display.Show(done);
                                      return !StopAsked();
                                    },
                                .viewer = flags.viewer,
                                .name_in_viewer = flags.output.empty() ? flags.film : flags.output,
                                .keep_film = !flags.film.empty()};
  if (flags.keeps_checkpoint()) {
    control.checkpoint = CheckpointPath(flags);
    control.checkpoint_seconds = flags.checkpoint_seconds.value_or(0);
    control.resume = flags.resume;
    CatchStopSignals();
  }
  if (!flags.output.empty()) {
    CatchSnapshotSignal();
    control.snapshot = [&] { return TakeSnapshotAsked() ? SnapshotPath(flags) : ""; };
  }
  // How many samples adaptive rendering takes is not known beforehand.
  display.Begin("", flags.picture.limits.adaptive > 0 ? 0 : renderer.samples());
  renderer.Render(control);
  display.End();
  display.Clear();
  if (!flags.progress.quiet) {
    PrintNotes({renderer.notes().begin() + std::ptrdiff_t(notes), renderer.notes().end()});
  }
}

int RenderMain(RenderFlags& flags) {
  if (flags.output.empty() && flags.film.empty()) {
    flags.output = std::filesystem::path(flags.picture.job.scene).stem().string() + ".exr";
  }
  CheckOutputs(flags);
  api::Renderer renderer = ReadRenderer(flags);
  try {
    RenderWatched(flags, renderer);
  } catch (const api::Canceled&) {
    Print(stderr,
          "stopped; {} keeps what is rendered, and the same command with --resume "
          "goes on\n",
          CheckpointPath(flags));
    return kExitTryAgain;
  }
  if (!flags.film.empty()) renderer.WriteFilm(flags.film);
  if (!flags.output.empty()) renderer.WriteExrAndPng(flags.output);
  if (!flags.stats.empty()) WriteFileAtomically(flags.stats, renderer.Statistics());
  if (flags.keeps_checkpoint()) std::filesystem::remove(CheckpointPath(flags));
  if (!flags.progress.quiet) {
    const std::string pictures =
        flags.output.empty() ? "" : flags.output + " and " + PngBeside(flags.output);
    const std::string comma = flags.film.empty() || flags.output.empty() ? "" : ", ";
    Print(stdout, "{}wrote {}{}{}\n", renderer.Summary(), flags.film, comma, pictures);
  }
  return 0;
}

// Adds the options of the picture. Their texts are also kept in `flags` for the library.
void AddKeptOptions(Command& command, const std::shared_ptr<RenderFlags>& flags) {
  const std::shared_ptr<PictureRequest> picture(flags, &flags->picture);
  for (BoundOption& option : BindAll(PictureOptions(), picture)) {
    if (!option.info.positional) {
      const bool reads = option.info.of_reading;
      option.set = [flags, reads, info = option.info,
                    set = option.set](const std::vector<std::string>& texts) {
        (reads ? flags->read_options : flags->options).emplace_back(info.name, Joined(info, texts));
        return set(texts);
      };
    }
    command.options.push_back(std::move(option));
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
  AddKeptOptions(command, flags);
  AddOptions(command, OutputOptions(), flags);
  return command;
}

}  // namespace skywave
