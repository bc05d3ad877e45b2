// skywave paths: what every way to join sub-paths of bdpt brings to a picture, as layers of an EXR
// and on one sheet.
#include <fmt/format.h>

#include <algorithm>
#include <filesystem>
#include <memory>
#include <vector>

#include "base/error.h"
#include "base/files.h"
#include "cli/commands.h"
#include "cli/flags.h"
#include "cli/job_flags.h"
#include "wavefront/render.h"

namespace skywave {
namespace {

// Two pictures a way: 2 (1 + 3 + 4 + ... ) of them.
constexpr std::uint32_t kDeepest = 8;
constexpr int kGap = 2;  // between the pictures of the sheet [pixels]

struct PathsFlags {
  JobRequest request;
  std::string output;
  ToneMapping tone;
  bool quiet = false;
};

struct WayPicture {
  std::uint32_t surfaces;
  PathWay way;
  Image weighted, unweighted;
};

Image RenderWay(const RenderJob& job, const std::optional<PathWay>& way, bool weighted) {
  FrameView frame = job.frame();
  frame.options.way = way;
  frame.options.mis = weighted;
  Film film = job.MakeFilm();
  RenderFrame(frame, film);
  return film.Resolve(frame.options.samples_per_pixel);
}

std::vector<WayPicture> RenderWays(const RenderJob& job) {
  std::vector<WayPicture> pictures;
  for (std::uint32_t surfaces = 0; surfaces <= job.options().max_depth; ++surfaces) {
    for (std::uint32_t light = 0; light <= surfaces + 1; ++light) {
      const PathWay way = {.light = light, .eye = surfaces + 2 - light};
      if (light == 1 && way.eye == 1) continue;  // what shines is seen by chance alone
      pictures.push_back({surfaces, way, RenderWay(job, way, true), RenderWay(job, way, false)});
    }
  }
  return pictures;
}

// A row for each number of surfaces, a column for each number of vertices from the light; weighted
// pictures above, unweighted ones below.
Image Sheet(const std::vector<WayPicture>& pictures, std::uint32_t depth) {
  const int width = pictures[0].weighted.width, height = pictures[0].weighted.height;
  const int rows = int(depth) + 1, columns = int(depth) + 2;
  Image sheet(columns * (width + kGap) - kGap, 2 * rows * (height + kGap) - kGap);
  const auto paste = [&](const Image& picture, int row, int column) {
    for (int y = 0; y < height; ++y) {
      std::copy_n(picture.Pixel(0, y), 3 * width,
                  sheet.Pixel(column * (width + kGap), row * (height + kGap) + y));
    }
  };
  for (const WayPicture& picture : pictures) {
    paste(picture.weighted, int(picture.surfaces), int(picture.way.light));
    paste(picture.unweighted, rows + int(picture.surfaces), int(picture.way.light));
  }
  return sheet;
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
  for (const std::string& path : {flags.output, png}) {
    CheckNotInput(path, flags.request.scene);
    CheckNotInput(path, flags.request.environment.path);
    CheckWritable(path);
  }
  flags.request.integrator = Integrator::kBdpt;
  const RenderJob job(flags.request);
  const RenderOptions& options = job.options();
  if (options.max_depth > kDeepest) {
    throw InputError(InputPosition::File(fmt::format("--max-depth {}", options.max_depth)),
                     fmt::format("there would be too many layers; at most {}", kDeepest),
                     kExitUsage);
  }
  const std::vector<WayPicture> pictures = RenderWays(job);
  std::vector<NamedChannel> layers;
  for (const WayPicture& picture : pictures) {
    const std::string way = fmt::format("s{}t{}", picture.way.light, picture.way.eye);
    AddLayer(picture.weighted, "weighted_" + way, layers);
    AddLayer(picture.unweighted, "unweighted_" + way, layers);
  }
  const Image sheet = Sheet(pictures, options.max_depth);
  const Metadata metadata = {
      {"command",
       fmt::format("skywave paths {} --strategy {} --spp {}", SceneFlags(flags.request, options),
                   flags.request.strategy, options.samples_per_pixel)},
      {"software", "skywave " SKYWAVE_VERSION}};
  WriteExr(flags.output, RenderWay(job, std::nullopt, true), metadata, layers);
  WritePng(png, sheet.width, sheet.height, ToneMap(sheet, flags.tone));
  if (!flags.quiet) {
    fmt::print("wrote {} ({} ways, weighted and unweighted) and their sheet {}\n", flags.output,
               pictures.size(), png);
  }
  return 0;
}

}  // namespace

void AddPathsCommand(CLI::App& program, Run& run) {
  CLI::App* command = program.add_subcommand(
      "paths", "Show what every way to join sub-paths brings to a picture of bdpt");
  const auto flags = std::make_shared<PathsFlags>();
  AddJobFlags(*command, flags->request);
  command->add_option(
      "-o,--output", flags->output,
      "EXR file with two layers a way, weighted_sStT and unweighted_sStT, S "
      "vertices from the light and T from the eye; the sheet goes beside it as PNG");
  command->add_option("--exposure", flags->tone.exposure_stops, "of the sheet [stops]")
      ->check(FiniteNumber(-100, 100));
  command->add_flag("-q,--quiet", flags->quiet, "print errors only");
  command->footer(
      "The sheet: a row for each number of surfaces, from 0; a column for each number of vertices\n"
      "from the light, from 0. Weighted pictures add up to the picture, unweighted ones of a row\n"
      "each show all that they can find.\n\n"
      "Example:\n"
      "  skywave paths lamps --size 160x120 --spp 64 --max-depth 4 --exposure 1");
  command->callback([flags, &run] { run = [flags] { return PathsMain(*flags); }; });
}

}  // namespace skywave
