// Renders one scene with several strategies and integrators at growing numbers of samples,
// repeatedly with independent seeds, and measures their distances from a reference.
#pragma once

#include <cstdint>
#include <memory>
#include <string>
#include <vector>

#include "bench/measure/error_split.h"
#include "job/job.h"
#include "wavefront/render.h"

namespace skywave {

struct MeasuredRun {
  std::uint32_t seed;
  double seconds;  // wall clock of the render alone
  ImageDifference error;
};

// A contestant at one number of samples.
struct Rung {
  std::uint32_t samples_per_pixel = 0;
  std::vector<MeasuredRun> runs;
  ErrorSplit split;

  std::vector<double> seconds() const;
  std::vector<double> errors(ErrorMeasure measure) const;
};

// A strategy used by an integrator.
struct Contestant {
  std::string name;  // the part that distinguishes it from its rivals
  std::string specification;
  RenderMethod method;
  double table_seconds = 0;  // time to build it from the map
  std::vector<Rung> ladder;  // samples ascending
  Image picture;             // first run of the last rung
  bool clamped = false;      // its paths are (ClampOptions)

  bool unbiased() const {
    return !clamped && method.strategy->unbiased() && !Describe(method.integrator).biased;
  }
};

// Settings shared by all runs.
struct ConvergeSettings {
  int repeats = 5;  // at least 2
  ErrorMeasure measure = ErrorMeasure::kMse;
};

// Returns every combination of a strategy and an integrator, strategy by strategy. The job must
// keep its map. Throws InputError for a strategy that cannot be built.
std::vector<Contestant> MakeContestants(const RenderJob& job,
                                        const std::vector<std::string>& specifications,
                                        const std::vector<Integrator>& integrators);

// Returns 1, 2, 4, ... `samples`.
std::vector<std::uint32_t> DoublingLadder(std::uint32_t samples);
// Returns the largest number of samples with at most three leading bits that does not exceed
// `samples`: the points of a pixel are best distributed in multiples of powers of two.
std::uint32_t RoundSamplesDown(double samples);
// Renders short frames until the rate is known, and returns the ladder whose last rung takes about
// `seconds`, with at most `max_samples` samples.
std::vector<std::uint32_t> LadderForTime(const RenderJob& job, const Contestant& contestant,
                                         double seconds, std::uint32_t max_samples);
// Renders and discards one frame, so that threads, caches and pages are ready before anything is
// timed.
void WarmUp(const RenderJob& job, const Contestant& contestant);

// Returns the integrator for the reference: `direct` if all contestants use it, because it sees no
// more light; else `path`, which is unbiased and finds all light except light from delta lights via
// delta BSDFs only.
Integrator ReferenceIntegrator(const std::vector<Contestant>& contestants);
// Renders both halves with the job's own strategy and multiple importance sampling, without clamps,
// `samples_per_half` each.
Reference RenderReference(const RenderJob& job, Integrator integrator,
                          std::uint32_t samples_per_half, Progress* progress);

// Runs every rung of every ladder `repeats` times and fills in runs, splits and pictures. Rungs are
// measured in ascending order; within a repeat all contestants take turns, and the starting one
// rotates, so that a slow minute of the machine affects all of them.
void Measure(const RenderJob& job, const Reference& reference, const ConvergeSettings& settings,
             std::vector<Contestant>& contestants, Progress* progress);
// Returns the number of samples that Measure renders, in the unit of Progress.
std::uint64_t SamplesToMeasure(const RenderJob& job, const ConvergeSettings& settings,
                               const std::vector<Contestant>& contestants);

// Derive seeds from the job's own. All runs of one rung and repeat share a seed, whatever the
// contestant; different rungs and repeats never do, nor does the reference. Offsets below 2^20 are
// unused, so that a reference rendered with a typed seed is independent too.
std::uint32_t RunSeed(std::uint32_t job_seed, std::size_t rung, int repeat);
std::uint32_t ReferenceSeed(std::uint32_t job_seed, int half);

}  // namespace skywave
