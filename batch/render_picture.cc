#include "batch/render_picture.h"

#include <fmt/format.h>
#include <xxhash.h>

#include "base/clock.h"
#include "base/error.h"
#include "base/files.h"
#include "base/version.h"
#include "image/image.h"
#include "job/job.h"

namespace skywave {
namespace {

Metadata PictureMetadata(const RenderJob& job) {
  return {{"software", fmt::format("skywave {}", Version())},
          {"samples", fmt::format("{}", job.options().samples_per_pixel)},
          {"seed", fmt::format("{}", job.options().seed)},
          {"sceneHash", fmt::format("{:016x}", job.scene_hash())}};
}

}  // namespace

PictureResult RenderAlone(const BatchPlan& plan, const BatchPicture& picture,
                          const ShowWork& show) try {
  PictureResult result = {.status = PictureStatus::kRendered};
  const PictureRequest request = RequestOf(plan.path, picture.options);
  Clock::time_point start = Clock::now();
  const RenderJob job(request.job);
  result.load_seconds = SecondsSince(start);
  Film film = job.MakeFilm();
  const RenderOptions& options = job.options();
  result.samples =
      std::uint64_t(options.width) * std::uint64_t(options.height) * options.samples_per_pixel;
  show(result.samples, [&](Progress& progress) {
    result.render_seconds = RenderFrame(job.frame(), film, &progress).seconds;
  });
  start = Clock::now();
  const Image image = film.Resolve(options.samples_per_pixel);
  WriteExr(picture.output, image, PictureMetadata(job),
           film.ResolveAovs(options.samples_per_pixel));
  WritePng(PngOf(picture.output), image.width, image.height,
           ToneMap(image, Tone(request.exposure)));
  const std::string bytes = ReadFile(picture.output);
  result.hash = fmt::format("{:016x}", XXH3_64bits(bytes.data(), bytes.size()));
  result.write_seconds = SecondsSince(start);
  return result;
} catch (const OptionError& error) {
  throw AtOption(plan.path, picture.options, error);
}

}  // namespace skywave
