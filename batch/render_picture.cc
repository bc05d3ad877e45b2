#include "batch/render_picture.h"

#include <fmt/format.h>
#include <xxhash.h>

#include "base/clock.h"
#include "base/error.h"
#include "base/files.h"
#include "job/job.h"
#include "job/picture.h"
#include "job/session.h"
#include "wavefront/film/aovs.h"

namespace skywave {
namespace {

// Returns the noise of a film that keeps the variance.
std::optional<double> NoiseOf(const RenderJob& job, const RenderLimits& limits,
                              const RenderedFilm& rendered) {
  const RenderOptions& options = job.options();
  const AovSet kept = options.aovs | LayersForLimits(limits, options.integrator);
  if (!Sums(kept, AovSum::kVariance)) return std::nullopt;
  return rendered.film.Noise(rendered.part.samples.count());
}

}  // namespace

PictureResult RenderAlone(const BatchPlan& plan, const BatchPicture& picture,
                          const Teller& tell) try {
  PictureResult result = {.status = PictureStatus::kRendered};
  const PictureRequest request = RequestOf(plan.path, picture.options);
  Clock::time_point start = Clock::now();
  const RenderJob job(request.job);
  const PictureIdentity identity = IdentityOf(job, request.exposure, true);
  result.load_seconds = SecondsSince(start);
  const RenderedFilm rendered = RunSession(job, identity, {.limits = request.limits, .tell = tell});
  result.render_seconds = rendered.seconds;
  result.samples = rendered.frame.stats.samples;
  result.noise = NoiseOf(job, request.limits, rendered);
  start = Clock::now();
  const Picture resolved =
      ResolvePicture(rendered.film, rendered.part.samples.count(), job.options().aovs, identity,
                     rendered.part, Tone(request.exposure));
  WriteExr(picture.output, resolved);
  WritePng(PngBeside(picture.output), resolved);
  const std::string bytes = ReadFile(picture.output);
  result.hash = fmt::format("{:016x}", XXH3_64bits(bytes.data(), bytes.size()));
  result.write_seconds = SecondsSince(start);
  return result;
} catch (const OptionError& error) {
  throw AtOption(plan.path, picture.options, error);
}

}  // namespace skywave
