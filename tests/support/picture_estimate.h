// Tests whether two noisy pictures estimate the same one: Welch's test of every pixel, of blocks of
// pixels and of the whole, at a level corrected for their number.
#pragma once

#include <gtest/gtest.h>

#include <functional>
#include <vector>

#include "image/image.h"
#include "job/job.h"
#include "tests/support/oracle.h"

namespace skywave {

// Every channel of every pixel as an estimated random variable.
struct PictureEstimate {
  int width = 0, height = 0;
  std::vector<double> mean, variance;  // variance of the mean
  std::vector<double> freedom;         // degrees of freedom of the variance
};

PictureEstimate EstimateFrom(const OraclePicture& picture, std::uint32_t samples_per_pixel);

// Returns the engine's picture of a job from `runs` renders with the seeds seed, seed + 1, ...: the
// samples of one render are stratified, so only independent renders reveal the noise.
PictureEstimate EstimateFromEngine(const RenderJob& job, int runs, std::uint32_t seed);
// Renders a frame that equals the job's except for the changes of a test.
PictureEstimate EstimateFromEngine(const RenderJob& job, FrameView frame, int runs,
                                   std::uint32_t seed);

// Tests whether the picture for `request` has the expectation of paths from the camera with four
// times its samples. Blocks of 3 x 3 pixels are compared because caustics in those are too rare and
// bright for a test of single pixels.
testing::AssertionResult SameAsPaths(const Scene& scene, JobRequest request, int runs,
                                     double level);

// Returns the oracle's picture of `scene` as rendered by `job`, with the samples of `runs` renders.
PictureEstimate EstimateFromOracle(const Scene& scene, const RenderJob& job, int runs);

// Returns the means over blocks of side x side pixels (smaller at the right and lower borders).
PictureEstimate MeanOfBlocks(const PictureEstimate& picture, int side);

// Returns the root mean square of the difference of two pictures over that of `expected`; it
// includes the noise of both.
double RelativeDifference(const PictureEstimate& picture, const PictureEstimate& expected);

// Returns the probability that a variable of Student's distribution deviates from 0 by |t| or more.
double StudentPValue(double t, double freedom);

// Tests that no pixel, no block of 4 x 4 or 12 x 12 pixels and no channel of the whole differs more
// than chance allows with probability `level`. `rounding` is the relative error of float
// arithmetic.
testing::AssertionResult SamePicture(const PictureEstimate& a, const PictureEstimate& b,
                                     double level, double rounding = 1e-4);

}  // namespace skywave
