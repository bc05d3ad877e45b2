// Implements skywave render: a scene becomes an EXR and a PNG.
#include <fmt/format.h>

#include <charconv>
#include <chrono>
#include <cmath>
#include <filesystem>
#include <memory>
#include <optional>

#include "base/error.h"
#include "base/files.h"
#include "cli/commands.h"
#include "cli/parse.h"
#include "cli/progress.h"
#include "cli/report.h"
#include "job/job.h"
#include "job/options.h"
#include "wavefront/film/aovs.h"
#include "wavefront/option_names.h"
#include "wavefront/render.h"

namespace skywave {
namespace {

struct RenderFlags {
  JobRequest request;
  PhotographicExposure photo;
  std::string output;
  std::string stats;
  ToneMapping tone;
  bool quiet = false;
};

std::string PngPath(const std::string& exr) {
  return std::filesystem::path(exr).replace_extension(".png").string();
}

// Parses 1/125 or 0.008.
std::optional<float> ParseShutter(const std::string& text) {
  const std::size_t slash = text.find('/');
  float value = 0, divisor = 1;
  const auto number = [](std::string_view part, float& to) {
    const auto [stop, error] = std::from_chars(part.data(), part.data() + part.size(), to);
    return error == std::errc() && stop == part.data() + part.size() && to > 0;
  };
  const std::string_view whole = text;
  if (!number(whole.substr(0, slash), value)) return std::nullopt;
  if (slash != std::string::npos && !number(whole.substr(slash + 1), divisor)) return std::nullopt;
  const float seconds = value / divisor;
  return seconds >= 1e-9f && seconds <= 1e9f ? std::optional(seconds) : std::nullopt;
}

#define FIELD SKYWAVE_FIELD
std::vector<OptionOf<RenderFlags>> Options() {
  const auto option = [](OptionInfo info, auto field, auto codec) {
    return MakeOption<RenderFlags>(info, field, codec);
  };
  constexpr OptionScope kPixels = OptionScope::kPixels;
  constexpr std::string_view kExposure = "Exposure of the PNG", kOutput = "Output";
  const Codec<float> seconds = {
      .values = "seconds or 1/SECONDS, for example 1/125",
      .metavar = "SECONDS|1/N",
      .parse = ParseShutter,
      .print = [](const float& s) { return s > 0 ? fmt::format("{}", s) : std::string(); }};
  // clang-format off
  return {
    option({.name = "output", .help = "EXR file; the PNG has the same name", .default_text = "name of the scene", .letter = 'o'}, FIELD(output), Texts("EXR")),
    option({.name = "quiet", .help = "print errors only", .letter = 'q'}, FIELD(quiet), Switches()),
    option({.name = "exposure", .group = kExposure, .help = "[stops], added to the camera's", .scope = kPixels, .example = "--exposure 1.5"}, FIELD(tone.exposure_stops), Floats(-100, 100)),
    option({.name = "shutter", .group = kExposure, .help = "exposure time of a camera for which radiance is luminance in cd/m^2", .scope = kPixels, .example = "--shutter 1/60 --f-number 8", .needs = "f-number"}, FIELD(photo.shutter_seconds), seconds),
    option({.name = "f-number", .group = kExposure, .help = "f-number of its lens", .scope = kPixels, .example = "--shutter 1/60 --f-number 8", .needs = "shutter"}, FIELD(photo.f_number), Unless(0.0f, Floats(0.1, 1000))),
    option({.name = "iso", .group = kExposure, .help = "speed of its sensor", .scope = kPixels, .example = "--shutter 1/60 --f-number 8 --iso 200", .needs = "shutter"}, FIELD(photo.iso), Floats(0.1, 1e8)),
    option({.name = "tone", .group = kExposure, .help = "tone curve of the PNG", .scope = kPixels, .example = "--tone filmic"}, FIELD(tone.curve), NamesOfEnum<ToneCurve>()),
    option({.name = "stats", .group = kOutput, .help = "write the statistics as JSON to this file"}, FIELD(stats), Texts("JSON")),
  };
  // clang-format on
}
#undef FIELD

// Returns the command that repeats both files, without anything that changes from run to run.
std::string RepeatCommand(const RenderFlags& flags, const JobRequest& resolved) {
  static const RenderFlags defaults;
  std::string text = "skywave render" + PictureOptions(resolved);
  for (const OptionOf<RenderFlags>& option : Options()) {
    if (option.scope == OptionScope::kPixels && option.get(flags) != option.get(defaults)) {
      text += CommandWords(option, flags);
    }
  }
  return text;
}

Metadata Provenance(const RenderFlags& flags, const RenderJob& job) {
  const RenderOptions& options = job.options();
  return {{"command", RepeatCommand(flags, job.request())},
          {"software", "skywave " SKYWAVE_VERSION},
          {"samples", fmt::format("{}", options.samples_per_pixel)},
          {"seed", fmt::format("{}", options.seed)},
          {"sceneHash", fmt::format("{:016x}", job.scene_hash())}};
}

// Returns the curve of the PNG, including the exposure of the camera.
ToneMapping Tone(const RenderFlags& flags) {
  ToneMapping tone = flags.tone;
  if (flags.photo.shutter_seconds > 0) tone.exposure_stops += ExposureStops(flags.photo);
  return tone;
}

int RenderMain(RenderFlags& flags) {
  if (flags.output.empty()) {
    flags.output = std::filesystem::path(flags.request.scene).stem().string() + ".exr";
  }
  if (std::filesystem::path(flags.output).extension() != ".exr") {
    throw InputError(InputPosition::File("--output " + flags.output),
                     flags.request.options.aovs == 0
                         ? "the picture is an EXR file, so its name has to end in .exr"
                         : "the layers of --aovs need an EXR file, whose name ends in .exr",
                     kExitUsage);
  }
  const std::string png = PngPath(flags.output);
  for (const std::string& path : {flags.output, png, flags.stats}) {
    if (path.empty()) continue;
    CheckNotInput(path, flags.request.scene);
    CheckNotInput(path, flags.request.environment.path);
    CheckWritable(path);
  }
  const RenderJob job(flags.request);
  if (!flags.quiet) {
    for (const std::string& note : job.notes()) fmt::print(stderr, "note: {}\n", note);
    if (job.options().guide && !Describe(job.options().integrator).has_light_paths()) {
      fmt::print(stderr, "note: --guide changes nothing: --integrator {} has no light paths\n",
                 ToString(job.options().integrator));
    }
    if (flags.photo.shutter_seconds > 0) {
      fmt::print(stderr, "note: the PNG is exposed for EV100 {:.2f}: white is {:.4g} cd/m^2\n",
                 ExposureValue100(flags.photo), std::exp2(-Tone(flags).exposure_stops));
    }
  }
  Film film = job.MakeFilm();
  RenderReport report = {.job = &job, .frame = {}};
  {
    const RenderOptions& options = job.options();
    Progress done = 0;
    std::optional<ProgressDisplay> display;
    if (!flags.quiet) {
      display.emplace(done,
                      std::uint64_t(options.width) * options.height * options.samples_per_pixel);
    }
    report.frame = RenderFrame(job.frame(), film, &done);
  }

  const auto start = std::chrono::steady_clock::now();
  const std::uint32_t samples = job.options().samples_per_pixel;
  const Image image = film.Resolve(samples);
  WriteExr(flags.output, image, Provenance(flags, job), film.ResolveAovs(samples));
  WritePng(png, image.width, image.height, ToneMap(image, Tone(flags)));
  report.write_seconds =
      std::chrono::duration<double>(std::chrono::steady_clock::now() - start).count();
  if (!flags.stats.empty()) WriteFileAtomically(flags.stats, Json(report).dump(2) + "\n");
  if (!flags.quiet) fmt::print("{}wrote {} and {}\n", Table(report), flags.output, png);
  return 0;
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
      .run = [flags](const GivenOptions&) { return RenderMain(*flags); }};
  AddOptions(command, JobOptions(), std::shared_ptr<JobRequest>(flags, &flags->request));
  const auto options = Options();
  AddOptions(command, options, flags);
  return command;
}

}  // namespace skywave
