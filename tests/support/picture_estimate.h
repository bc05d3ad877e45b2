// Whether two noisy pictures are estimates of the same one: Welch's test of every pixel, of blocks
// of pixels and of the whole, at a level corrected for their number.
#pragma once

#include <gtest/gtest.h>

#include <functional>
#include <vector>

#include "image/image.h"
#include "job/job.h"
#include "tests/support/oracle.h"

namespace skywave {

// Every channel of every pixel as a random variable that was estimated.
struct PictureEstimate {
  int width = 0, height = 0;
  std::vector<double> mean, variance;  // variance of the mean
  std::vector<double> freedom;         // degrees of freedom of the variance
};

PictureEstimate EstimateFrom(const OraclePicture& picture, std::uint32_t samples_per_pixel);

// The engine's picture of a job from `runs` renders whose seeds are seed, seed + 1, ...: samples of
// one render are stratified, so only independent renders tell the noise.
PictureEstimate EstimateFromEngine(const RenderJob& job, int runs, std::uint32_t seed);
// The same of a frame that is the job's but for what a test has changed.
PictureEstimate EstimateFromEngine(const RenderJob& job, FrameView frame, int runs,
                                   std::uint32_t seed);

// Whether the picture of what `request` asks for has the expectation of paths from the camera with
// four times its samples. Blocks of 3 x 3 pixels: caustics are too rare and bright in those for a
// test of single pixels.
testing::AssertionResult SameAsPaths(const Scene& scene, JobRequest request, int runs,
                                     double level);

// The oracle's picture of what `job` renders of `scene`, with the samples of `runs` of its renders.
PictureEstimate EstimateFromOracle(const Scene& scene, const RenderJob& job, int runs);

// Means over blocks of side x side pixels (smaller at the right and lower borders).
PictureEstimate MeanOfBlocks(const PictureEstimate& picture, int side);

// Root mean square of the difference of two pictures, over that of `expected`; a share of noise of
// either is in it.
double RelativeDifference(const PictureEstimate& picture, const PictureEstimate& expected);

// Probability that a variable of Student's distribution is |t| or more away from 0.
double StudentPValue(double t, double freedom);

// No pixel, no block of 4 x 4 and 12 x 12 pixels and no channel of the whole differs more than
// chance allows with probability `level`. `rounding`: relative, what float arithmetic may add.
testing::AssertionResult SamePicture(const PictureEstimate& a, const PictureEstimate& b,
                                     double level, double rounding = 1e-4);

}  // namespace skywave
