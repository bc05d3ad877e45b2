#include "bench/measure/converge.h"

#include <algorithm>
#include <bit>

#include "base/clock.h"
#include "wavefront/option_names.h"
#include "wavefront/stages/clamps.h"

namespace skywave {
namespace {

Image Render(FrameView frame, const RenderJob& job, std::uint32_t samples, std::uint32_t seed,
             Progress* progress, double* seconds) {
  frame.options.samples_per_pixel = samples;
  frame.options.seed = seed;
  Film film = job.MakeFilm(frame.options.integrator);
  const FrameResult result = RenderFrame(frame, film, {.progress = progress});
  if (seconds != nullptr) *seconds = result.seconds;
  return film.Resolve(samples);
}

FrameView FrameOf(const RenderJob& job, const Contestant& contestant) {
  return job.frame(contestant.method);
}

std::size_t LongestLadder(const std::vector<Contestant>& contestants) {
  std::size_t longest = 0;
  for (const Contestant& c : contestants) longest = std::max(longest, c.ladder.size());
  return longest;
}

// Measures one rung of every ladder that has it.
void MeasureRung(const RenderJob& job, const Reference& reference, const ConvergeSettings& settings,
                 std::size_t rung, std::vector<Contestant>& contestants, Progress* progress) {
  const RenderOptions& options = job.options();
  std::vector<PictureMoments> moments(contestants.size(),
                                      PictureMoments(options.width, options.height));
  for (int repeat = 0; repeat < settings.repeats; ++repeat) {
    for (std::size_t turn = 0; turn < contestants.size(); ++turn) {
      const std::size_t which = (turn + std::size_t(repeat)) % contestants.size();
      Contestant& contestant = contestants[which];
      if (rung >= contestant.ladder.size()) continue;
      Rung& measured = contestant.ladder[rung];
      MeasuredRun run = {.seed = RunSeed(options.seed, rung, repeat), .seconds = 0, .error = {}};
      Image picture = Render(FrameOf(job, contestant), job, measured.samples_per_pixel, run.seed,
                             progress, &run.seconds);
      run.error = Compare(picture, reference.image);
      measured.runs.push_back(run);
      moments[which].Add(picture);
      if (repeat == 0) contestant.picture = std::move(picture);
    }
  }
  for (std::size_t i = 0; i < contestants.size(); ++i) {
    if (rung >= contestants[i].ladder.size()) continue;
    contestants[i].ladder[rung].split = SplitError(moments[i], reference, settings.measure);
  }
}

}  // namespace

std::vector<double> Rung::seconds() const {
  std::vector<double> values;
  for (const MeasuredRun& run : runs) values.push_back(run.seconds);
  return values;
}

std::vector<double> Rung::errors(ErrorMeasure measure) const {
  std::vector<double> values;
  for (const MeasuredRun& run : runs) values.push_back(Value(run.error, measure));
  return values;
}

std::vector<Contestant> MakeContestants(const RenderJob& job,
                                        const std::vector<std::string>& specifications,
                                        const std::vector<Integrator>& integrators) {
  std::vector<Contestant> contestants;
  for (const std::string& specification : specifications) {
    for (const Integrator integrator : integrators) {
      Contestant contestant = {.name = specification, .specification = specification};
      if (integrators.size() > 1) {
        contestant.name = ToString(integrator);
        if (specifications.size() > 1) contestant.name += " " + specification;
      }
      const auto start = Clock::now();
      contestant.method = job.MakeMethod(specification, integrator);
      contestant.table_seconds = SecondsSince(start);
      contestant.clamped = job.options().of<ClampOptions>().any();
      contestants.push_back(std::move(contestant));
    }
  }
  return contestants;
}

std::vector<std::uint32_t> DoublingLadder(std::uint32_t samples) {
  std::vector<std::uint32_t> ladder;
  for (std::uint64_t rung = 1; rung < samples; rung *= 2) ladder.push_back(std::uint32_t(rung));
  ladder.push_back(samples);
  return ladder;
}

std::uint32_t RoundSamplesDown(double samples) {
  const auto whole = std::uint32_t(std::clamp(samples, 1.0, 4e9));
  const int low_bits = std::max(0, int(std::bit_width(whole)) - 3);
  return whole >> low_bits << low_bits;
}

std::vector<std::uint32_t> LadderForTime(const RenderJob& job, const Contestant& contestant,
                                         double seconds, std::uint32_t max_samples) {
  // The very first frame includes waiting for threads and memory, so it is not timed.
  const FrameView frame = FrameOf(job, contestant);
  Render(frame, job, 1, job.options().seed, nullptr, nullptr);
  // A frame that takes a tenth of the time determines the rate well enough.
  for (std::uint32_t samples = 1;; samples *= 2) {
    double taken = 0;
    Render(frame, job, samples, job.options().seed, nullptr, &taken);
    if (taken < 0.1 * seconds && samples < max_samples / 2) continue;
    const double fitting = samples * seconds / std::max(taken, 1e-9);
    return DoublingLadder(RoundSamplesDown(std::min<double>(fitting, max_samples)));
  }
}

void WarmUp(const RenderJob& job, const Contestant& contestant) {
  Render(FrameOf(job, contestant), job, contestant.ladder.front().samples_per_pixel,
         job.options().seed, nullptr, nullptr);
}

Integrator ReferenceIntegrator(const std::vector<Contestant>& contestants) {
  const bool direct = std::all_of(contestants.begin(), contestants.end(), [](const Contestant& c) {
    return Describe(c.method.integrator).direct_light_only;
  });
  return direct && !contestants.empty() ? contestants.front().method.integrator : Integrator::kPath;
}

Reference RenderReference(const RenderJob& job, Integrator integrator,
                          std::uint32_t samples_per_half, Progress* progress) {
  const RenderMethod method = job.MakeMethod(job.request().strategy, integrator);
  FrameView frame = job.frame(method);
  frame.options.mis = true;
  frame.options.of<ClampOptions>() = {};
  Image halves[2];
  for (int half = 0; half < 2; ++half) {
    halves[half] = Render(frame, job, samples_per_half, ReferenceSeed(job.options().seed, half),
                          progress, nullptr);
  }
  return MakeReference(halves[0], halves[1]);
}

void Measure(const RenderJob& job, const Reference& reference, const ConvergeSettings& settings,
             std::vector<Contestant>& contestants, Progress* progress) {
  for (std::size_t rung = 0; rung < LongestLadder(contestants); ++rung) {
    MeasureRung(job, reference, settings, rung, contestants, progress);
  }
}

std::uint64_t SamplesToMeasure(const RenderJob& job, const ConvergeSettings& settings,
                               const std::vector<Contestant>& contestants) {
  std::uint64_t per_pixel = 0;
  for (const Contestant& contestant : contestants) {
    for (const Rung& rung : contestant.ladder) per_pixel += rung.samples_per_pixel;
  }
  const RenderOptions& options = job.options();
  return per_pixel * std::uint64_t(settings.repeats) * std::uint64_t(options.width) *
         std::uint64_t(options.height);
}

std::uint32_t RunSeed(std::uint32_t job_seed, std::size_t rung, int repeat) {
  constexpr std::uint32_t kMaxRungs = 64;
  return job_seed + (1u << 20) + std::uint32_t(repeat) * kMaxRungs + std::uint32_t(rung);
}

std::uint32_t ReferenceSeed(std::uint32_t job_seed, int half) {
  return job_seed + (1u << 31) + std::uint32_t(half);
}

}  // namespace skywave
