// Renders of one scene by several strategies with growing numbers of samples, again and again with
// independent seeds, and how far each is from a reference.
#pragma once

#include <cstdint>
#include <memory>
#include <string>
#include <vector>

#include "measure/error_split.h"
#include "wavefront/job.h"
#include "wavefront/render.h"

namespace skywave {

struct MeasuredRun {
  std::uint32_t seed;
  double seconds;  // wall clock of the render alone
  ImageDifference error;
};

// A strategy at one number of samples.
struct Rung {
  std::uint32_t samples_per_pixel = 0;
  std::vector<MeasuredRun> runs;
  ErrorSplit split;

  std::vector<double> seconds() const;
  std::vector<double> errors(ErrorMeasure measure) const;
};

struct Contestant {
  std::string specification;
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

// The job has to keep its map. Throws InputError for a strategy that cannot be made.
Contestant MakeContestant(const RenderJob& job, const std::string& specification);

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

// Both halves by the job's own strategy with multiple importance sampling, `samples` each.
Reference RenderReference(const RenderJob& job, std::uint32_t samples_per_half, Progress* progress);

// Runs every rung of every ladder `repeats` times and fills in runs, splits and pictures. Rungs are
// measured in ascending order; within a repeat all strategies take their turn, and the one that
// begins changes, so that a slow minute of the machine slows all of them.
void Measure(const RenderJob& job, const Reference& reference, const ConvergeSettings& settings,
             std::vector<Contestant>& contestants, Progress* progress);
// Samples that Measure renders, in the unit of Progress.
std::uint64_t SamplesToMeasure(const RenderJob& job, const ConvergeSettings& settings,
                               const std::vector<Contestant>& contestants);

// Seeds, from the job's own: all runs of one rung and repeat share one, whatever the strategy; no
// two rungs or repeats do, nor does the reference. Below 2^20 none is used, so that a reference
// rendered with a seed that people type is independent too.
std::uint32_t RunSeed(std::uint32_t job_seed, std::size_t rung, int repeat);
std::uint32_t ReferenceSeed(std::uint32_t job_seed, int half);

}  // namespace skywave
