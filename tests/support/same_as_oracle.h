// Compares pictures of the engine with those of the oracle.
#pragma once

#include <gtest/gtest.h>

#include <cstdint>

#include "tests/support/picture_estimate.h"
#include "tests/support/render_scenes.h"
#include "tests/support/statistics.h"

namespace skywave {

inline constexpr int kRuns = 16;
inline constexpr std::uint32_t kSamples = 32;  // per run
inline constexpr int kWidth = 32, kHeight = 24;
// This many comparisons of pictures share the level of the suite.
inline const double kLevel = SidakLevel(100);

inline JobRequest Request(Integrator integrator, std::uint32_t max_depth) {
  JobRequest request = SmallRequest(kWidth, kHeight, kSamples);
  request.integrator = integrator;
  request.max_depth = max_depth;
  return request;
}

inline void ExpectSame(const Scene& scene, const JobRequest& request) {
  const RenderJob job(scene, request);
  EXPECT_TRUE(SamePicture(EstimateFromEngine(job, kRuns, 100),
                          EstimateFromOracle(scene, job, kRuns), kLevel));
}

}  // namespace skywave
