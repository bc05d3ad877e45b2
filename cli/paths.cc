// Implements skywave paths: the contribution of every technique of bdpt to a picture, as layers of
// an EXR and on one sheet.
#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <filesystem>
#include <memory>
#include <optional>
#include <vector>

#include "base/error.h"
#include "base/files.h"
#include "base/version.h"
#include "cli/commands.h"
#include "cli/contact_sheet.h"
#include "cli/print.h"
#include "cli/progress.h"
#include "job/job.h"
#include "job/map_sequence.h"
#include "job/options.h"
#include "wavefront/render.h"
#include "wavefront/stages/bidirectional.h"

namespace skywave {
namespace {

// There are two pictures per technique: 2 (1 + 3 + 4 + ... ) of them.
constexpr std::uint32_t kDeepest = 8;

// The layers are reserved for the techniques, whose splats have no noise that a denoiser knows, and
// the sheet shows them as they are.
constexpr std::string_view kNotOfPaths[] = {"aovs", "denoise", "working-space"};

struct PathsFlags {
  JobRequest request;
  std::string output;
  ToneMapping tone;
  ProgressFlags progress;
};

struct TechniquePicture {
  SubpathLengths lengths;
  bool weighted;
  Image picture;

  std::uint32_t surfaces() const { return lengths.light + lengths.eye - 2; }
  // Returns the name of its layer.
  std::string name() const {
    return fmt::format("{}_s{}t{}", weighted ? "weighted" : "unweighted", lengths.light,
                       lengths.eye);
  }
};

Image RenderTechnique(const RenderJob& job, const std::optional<SubpathLengths>& lengths,
                      bool weighted, Progress& done) {
  FrameView frame = job.frame();
  frame.options.of<ConnectionOptions>().shown = lengths;
  frame.options.mis = weighted;
  Film film = job.MakeFilm();
  RenderFrame(frame, film, {.progress = &done});
  return film.Resolve(frame.options.samples_per_pixel);
}

std::vector<TechniquePicture> TechniquesTo(std::uint32_t max_depth) {
  std::vector<TechniquePicture> techniques;
  for (std::uint32_t surfaces = 0; surfaces <= max_depth; ++surfaces) {
    for (std::uint32_t light = 0; light <= surfaces + 1; ++light) {
      const SubpathLengths lengths = {.light = light, .eye = surfaces + 2 - light};
      if (light == 1 && lengths.eye == 1) continue;  // camera rays see lights anyway
      for (const bool weighted : {true, false}) techniques.push_back({lengths, weighted, {}});
    }
  }
  return techniques;
}

// There is one row for each number of surfaces and one column for each number of vertices on the
// light sub-path; weighted pictures are above, unweighted ones below.
ContactSheet Sheet(const std::vector<TechniquePicture>& pictures, std::uint32_t depth,
                   const ToneMapping& tone) {
  std::vector<SheetPicture> places;
  for (const TechniquePicture& p : pictures) {
    places.push_back({.row = int(p.surfaces() + (p.weighted ? 0 : depth + 1)),
                      .column = int(p.lengths.light),
                      .caption = p.name(),
                      .picture = &p.picture});
  }
  return MakeContactSheet(places, tone);
}

void AddLayer(const Image& picture, const std::string& name, std::vector<NamedChannel>& layers) {
  for (std::size_t c = 0; c < 3; ++c) {
    NamedChannel channel = {fmt::format("{}.{}", name, "RGB"[c]), {}};
    for (std::size_t i = c; i < picture.rgb.size(); i += 3) {
      channel.values.push_back(picture.rgb[i]);
    }
    layers.push_back(std::move(channel));
  }
}

int PathsMain(PathsFlags& flags) {
  if (flags.output.empty()) {
    flags.output = std::filesystem::path(flags.request.scene).stem().string() + "_paths.exr";
  }
  if (std::filesystem::path(flags.output).extension() != ".exr") {
    throw InputError(InputPosition::File("--output " + flags.output),
                     "the layers need an EXR file, whose name ends in .exr", kExitUsage);
  }
  const std::string png = std::filesystem::path(flags.output).replace_extension(".png").string();
  const std::array outputs = {flags.output, png};
  CheckAllWritable(outputs);
  const JobRequest& request = flags.request;
  if (request.integrator.value_or(Integrator::kBdpt) != Integrator::kBdpt ||
      request.options.of<ConnectionOptions>().shown || !request.options.mis) {
    throw InputError(InputPosition::File("--integrator, --paths, --no-mis"),
                     "skywave paths shows every way of bdpt, weighted and unweighted; skywave "
                     "render takes these flags",
                     kExitUsage);
  }
  flags.request.integrator = Integrator::kBdpt;
  const FilesRead inputs;
  const RenderJob job(flags.request);
  inputs.CheckAreNot(outputs);
  const RenderOptions& options = job.options();
  if (options.max_depth > kDeepest) {
    throw InputError(InputPosition::File(fmt::format("--max-depth {}", options.max_depth)),
                     fmt::format("there would be too many layers; at most {}", kDeepest),
                     kExitUsage);
  }
  if (!flags.progress.quiet) PrintRemarks(job);
  std::vector<TechniquePicture> pictures = TechniquesTo(options.max_depth);
  Image whole;
  const std::uint64_t samples =
      std::uint64_t(options.width) * options.height * options.samples_per_pixel;
  {
    ProgressDisplay display(flags.progress, pictures.size() + 1);
    for (TechniquePicture& p : pictures) {
      ShowProgress(display, p.name(), samples, [&](Progress& done) {
        p.picture = RenderTechnique(job, p.lengths, p.weighted, done);
      });
    }
    ShowProgress(display, "whole", samples,
                 [&](Progress& done) { whole = RenderTechnique(job, std::nullopt, true, done); });
  }
  std::vector<NamedChannel> layers;
  for (const TechniquePicture& p : pictures) AddLayer(p.picture, p.name(), layers);
  const ContactSheet sheet = Sheet(pictures, options.max_depth, flags.tone);
  const Metadata metadata = {
      {"command", "skywave paths" + PictureOptions(job.request(), kNotOfPaths)},
      {"software", fmt::format("skywave {}", Version())}};
  WriteExr(flags.output, whole, metadata, layers, {},
           [&] { WritePng(png, sheet.width, sheet.height, sheet.rgb); });
  if (!flags.progress.quiet) {
    Print(stdout, "wrote {} ({} techniques, weighted and unweighted) and their sheet {}\n",
          flags.output, pictures.size() / 2, png);
  }
  return 0;
}

#define FIELD SKYWAVE_FIELD
std::vector<OptionOf<PathsFlags>> PathsOptions() {
  // clang-format off
  return {
    MakeOption<PathsFlags>({.name = "output", .help = "EXR file with two layers for each pair S, T, weighted_sStT and unweighted_sStT, of S vertices from the light and T from the eye; the sheet goes to a PNG of the same name", .default_text = "name of the scene", .letter = 'o'}, FIELD(output), Texts("EXR")),
    MakeOption<PathsFlags>({.name = "exposure", .help = "exposure of the sheet [stops]"}, FIELD(tone.exposure_stops), Floats(-100, 100)),
    MakeOption<PathsFlags>({.name = "quiet", .help = "print errors only", .letter = 'q'}, FIELD(progress.quiet), Switches()),
    ProgressOption<PathsFlags>(),
  };
  // clang-format on
}
#undef FIELD

}  // namespace

Command PathsCommand() {
  const auto flags = std::make_shared<PathsFlags>();
  Command command = {
      .name = "paths",
      .summary = "Show the contribution of every way to connect sub-paths to a picture of bdpt",
      .footer =
          "The sheet: a row for each number of surfaces, from 0; a column for each number of "
          "vertices\n"
          "from the light, from 0; each picture under the name of its layer, weighted ones above.\n"
          "Weighted pictures add up to the picture, unweighted ones of a row each show all that "
          "they "
          "can\n"
          "find. The layer without a name is the picture.\n\n"
          "Example:\n"
          "  skywave paths lamps --size 160x120 --spp 64 --max-depth 4 --exposure 1",
      .run = [flags](const GivenOptions&) {
        return TellFailures(flags->progress, [&] { return PathsMain(*flags); });
      }};
  AddOptions(command, JobOptions(), std::shared_ptr<JobRequest>(flags, &flags->request),
             {std::begin(kNotOfPaths), std::end(kNotOfPaths)});
  const auto options = PathsOptions();
  AddOptions(command, options, flags);
  return command;
}

}  // namespace skywave
