// skywave render: a scene to an EXR and a PNG.
#include <fmt/format.h>

#include <chrono>
#include <filesystem>
#include <memory>
#include <optional>

#include "base/error.h"
#include "base/files.h"
#include "cli/commands.h"
#include "cli/flags.h"
#include "cli/job_flags.h"
#include "cli/progress.h"
#include "cli/report.h"

namespace skywave {
namespace {

struct RenderFlags {
  JobRequest request;
  std::string output;
  std::string stats;
  ToneMapping tone;
  bool quiet = false;
};

std::string PngPath(const std::string& exr) {
  return std::filesystem::path(exr).replace_extension(".png").string();
}

// What repeats the picture, and nothing that changes from run to run.
Metadata Provenance(const RenderFlags& flags, const RenderJob& job) {
  const RenderOptions& options = job.options();
  return {{"command", RepeatCommand(flags.request, options)},
          {"software", "skywave " SKYWAVE_VERSION},
          {"samples", fmt::format("{}", options.samples_per_pixel)},
          {"seed", fmt::format("{}", options.seed)},
          {"sceneHash", fmt::format("{:016x}", job.scene_hash())}};
}

int RenderMain(RenderFlags& flags) {
  if (flags.output.empty()) {
    flags.output = std::filesystem::path(flags.request.scene).stem().string() + ".exr";
  }
  if (std::filesystem::path(flags.output).extension() != ".exr") {
    throw InputError(InputPosition::File("--output " + flags.output),
                     "the picture is an EXR file, so its name has to end in .exr", kExitUsage);
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
  const Image image = film.Resolve(job.options().samples_per_pixel);
  WriteExr(flags.output, image, Provenance(flags, job));
  WritePng(png, image.width, image.height, ToneMap(image, flags.tone));
  report.write_seconds =
      std::chrono::duration<double>(std::chrono::steady_clock::now() - start).count();
  if (!flags.stats.empty()) WriteFileAtomically(flags.stats, Json(report).dump(2) + "\n");
  if (!flags.quiet) fmt::print("{}wrote {} and {}\n", Table(report), flags.output, png);
  return 0;
}

}  // namespace

void AddRenderCommand(CLI::App& program, Run& run) {
  CLI::App* command = program.add_subcommand("render", "Render a scene to EXR and PNG");
  const auto flags = std::make_shared<RenderFlags>();
  AddJobFlags(*command, flags->request);
  command->add_option("-o,--output", flags->output,
                      "EXR file; the PNG goes beside it (default: name of the scene)");
  command->add_option("--exposure", flags->tone.exposure_stops, "of the PNG [stops]")
      ->check(FiniteNumber(-100, 100));
  command
      ->add_option_function<std::string>(
          "--tone",
          [flags](const std::string& text) {
            flags->tone.curve = text == "filmic" ? ToneCurve::kFilmic : ToneCurve::kClip;
          },
          "curve of the PNG (default: clip)")
      ->check(CLI::IsMember({"clip", "filmic"}));
  command->add_option("--stats", flags->stats, "write the statistics as JSON to this file");
  command->add_flag("-q,--quiet", flags->quiet, "print errors only");
  command->footer(
      "Examples:\n"
      "  skywave render gallery -o gallery.exr\n"
      "  skywave render killeroo.pbrt --env grace.exr --env-up z --size 640x480 --spp 64\n"
      "  skywave render model.obj --env sky.hdr --ground\n"
      "  skywave render bunny.ply --env sky.hdr --integrator direct --light-samples 16");
  command->callback([flags, &run] { run = [flags] { return RenderMain(*flags); }; });
}

}  // namespace skywave
