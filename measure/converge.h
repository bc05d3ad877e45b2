// Renders of one scene by several strategies and integrators with growing numbers of samples, again
// and again with independent seeds, and how far each is from a reference.
#pragma once

#include <cstdint>
#include <memory>
#include <string>
#include <vector>

#include "job/job.h"
#include "measure/error_split.h"
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

// A strategy in the hands of an integrator.
struct Contestant {
  std::string name;  // among its rivals: what tells it from them
  std::string specification;
  Integrator integrator = Integrator::kPath;
  std::unique_ptr<EnvStrategy> strategy;
  double table_seconds = 0;  // to build it from the map
  std::vector<Rung> ladder;  // samples ascending
  Image picture;             // first run of the last rung
};

// What is fixed for all runs.
struct ConvergeSettings {
  int repeats = 5;  // at least 2
  ErrorMeasure measure = ErrorMeasure::kMse;
};

// Every strategy in the hands of every integrator, strategy by strategy. The job has to keep its
// map. Throws InputError for a strategy that cannot be made.
std::vector<Contestant> MakeContestants(const RenderJob& job,
                                        const std::vector<std::string>& specifications,
                                        const std::vector<Integrator>& integrators);

// 1, 2, 4, ... `samples`.
std::vector<std::uint32_t> DoublingLadder(std::uint32_t samples);
// The largest number of samples of at most three leading bits that is at most `samples`: a pixel's
// points are best spread in multiples of powers of two.
std::uint32_t RoundSamplesDown(double samples);
// Renders short frames until a rate is known, and gives the ladder whose last rung takes about
// `seconds`. At most `max_samples` samples.
std::vector<std::uint32_t> LadderForTime(const RenderJob& job, const Contestant& contestant,
                                         double seconds, std::uint32_t max_samples);
// One render that is thrown away: threads, caches and pages are there before anything is timed.
void WarmUp(const RenderJob& job, const Contestant& contestant);

// What a reference is computed by: `direct` where all contestants are, for it sees no more; else
// `path`, which is unbiased and finds all light but what only delta BSDFs lead to delta lights.
Integrator ReferenceIntegrator(const std::vector<Contestant>& contestants);
// Both halves by the job's own strategy with multiple importance sampling, `samples` each.
Reference RenderReference(const RenderJob& job, Integrator integrator,
                          std::uint32_t samples_per_half, Progress* progress);

// Runs every rung of every ladder `repeats` times and fills in runs, splits and pictures. Rungs are
// measured in ascending order; within a repeat all contestants take their turn, and the one that
// begins changes, so that a slow minute of the machine slows all of them.
void Measure(const RenderJob& job, const Reference& reference, const ConvergeSettings& settings,
             std::vector<Contestant>& contestants, Progress* progress);
// Samples that Measure renders, in the unit of Progress.
std::uint64_t SamplesToMeasure(const RenderJob& job, const ConvergeSettings& settings,
                               const std::vector<Contestant>& contestants);

// Seeds, from the job's own: all runs of one rung and repeat share one, whatever the contestant; no
// two rungs or repeats do, nor does the reference. Below 2^20 none is used, so that a reference
// rendered with a seed that people type is independent too.
std::uint32_t RunSeed(std::uint32_t job_seed, std::size_t rung, int repeat);
std::uint32_t ReferenceSeed(std::uint32_t job_seed, int half);

}  // namespace skywave
