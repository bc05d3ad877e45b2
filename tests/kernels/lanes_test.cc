// Compares counts of SIMD lanes with small cases worked out by hand and with the other counters of
// a render.
#include "wavefront/rays/lanes.h"

#include <gtest/gtest.h>

#include <array>
#include <set>
#include <string>

#include "job/job.h"
#include "kernels/bsdf/bsdf.h"
#include "wavefront/render.h"

namespace skywave {
namespace {

const LaneCount& Of(const LaneCounts& lanes, Kernel kernel, BsdfKind kind = BsdfKind{}) {
  return lanes[std::uint32_t(kernel) + std::uint32_t(kind)];
}

SurfaceRanges Ranges(const std::array<std::uint32_t, kBsdfKinds>& counts) {
  SurfaceRanges ranges;
  for (std::uint32_t i = 0; i < kBsdfKinds; ++i) ranges.begin[i + 1] = ranges.begin[i] + counts[i];
  return ranges;
}

void ExpectLanes(const LaneCount& lanes, std::uint64_t active, std::uint64_t of_8,
                 std::uint64_t of_16) {
  EXPECT_EQ(lanes.active, active);
  EXPECT_EQ(lanes.issued[0], of_8);
  EXPECT_EQ(lanes.issued[1], of_16);
}

TEST(LaneCount, IssuesWholeVectors) {
  LaneCount lanes;
  lanes.Add(3, 17);
  lanes.Add(8, 8);
  lanes.Add(0, 0);
  ExpectLanes(lanes, 11, 32, 48);
  EXPECT_DOUBLE_EQ(lanes.utilisation(8), 11.0 / 32);
  EXPECT_DOUBLE_EQ(lanes.utilisation(16), 11.0 / 48);
  EXPECT_EQ(LaneCount().utilisation(8), 0);
}

TEST(Lanes, AreThoseOfTheQueues) {
  std::array<std::uint32_t, kBsdfKinds> counts = {20, 0, 1};
  const auto last = BsdfKind(kBsdfKinds - 1);  // takes no light samples
  counts[kBsdfKinds - 1] = 9;
  const SurfaceRanges ranges = Ranges(counts);
  LaneCounts lanes = {};
  CountTracing(40, lanes);
  CountEscaping(40, 10, lanes);
  CountHits(40, ranges, lanes);
  ExpectLanes(Of(lanes, Kernel::kIntersect), 40, 40, 48);
  ExpectLanes(Of(lanes, Kernel::kMoveEscaped), 10, 40, 48);
  ExpectLanes(Of(lanes, Kernel::kEscape), 10, 16, 16);
  ExpectLanes(Of(lanes, Kernel::kMoveHits), 30, 3 * 40, 3 * 48);  // one pass per queue
  ExpectLanes(Of(lanes, Kernel::kSurface), 30, 32, 32);
  CountLighting(ranges, 7, 5, lanes);
  ExpectLanes(Of(lanes, Kernel::kLightSample), 21, 24, 32);
  ExpectLanes(Of(lanes, Kernel::kEvaluate, BsdfKind(2)), 1, 8, 16);
  ExpectLanes(Of(lanes, Kernel::kEvaluate, BsdfKind(1)), 0, 0, 0);
  ExpectLanes(Of(lanes, Kernel::kShadow), 7, 24, 32);
  ExpectLanes(Of(lanes, Kernel::kAccumulate), 5, 24, 32);
  CountScattering(ranges, 1, lanes);
  ExpectLanes(Of(lanes, Kernel::kScatter), 0, 0, 0);
  ExpectLanes(Of(lanes, Kernel::kScatter, last), 9, 16, 16);
}

TEST(Lanes, NamesAreUniqueAndNotEmpty) {
  std::set<std::string> names;
  for (std::uint32_t i = 0; i < kKernels; ++i) names.insert(ToString(Kernel(i)));
  EXPECT_EQ(names.size(), kKernels);
  EXPECT_TRUE(names.contains("film"));
  EXPECT_TRUE(names.contains("scatter dielectric"));
}

class LanesOfARender : public testing::TestWithParam<Integrator> {};

TEST_P(LanesOfARender, AgreeWithItsRaysAndNotWithItsThreads) {
  JobRequest request = {.scene = "gallery"};
  request.width = 48, request.height = 32, request.samples_per_pixel = 4;
  request.integrator = GetParam();
  const RenderJob job(request);
  LaneCounts counts[2];
  RenderStats stats;
  for (const int threads : {1, 2}) {
    FrameView frame = job.frame();
    frame.options.threads = threads;
    Film film = job.MakeFilm();
    stats = RenderFrame(frame, film).stats;
    counts[threads - 1] = stats.lanes;
  }
  for (std::uint32_t i = 0; i < kKernels; ++i) {
    SCOPED_TRACE(ToString(Kernel(i)));
    EXPECT_EQ(counts[0][i].active, counts[1][i].active);
    EXPECT_EQ(counts[0][i].issued, counts[1][i].issued);
    for (const std::uint64_t issued : counts[0][i].issued) EXPECT_LE(counts[0][i].active, issued);
  }
  const LaneCounts& lanes = counts[0];
  const auto rays = [&](RayKind kind) { return stats.rays[std::uint32_t(kind)]; };
  EXPECT_EQ(Of(lanes, Kernel::kGenerate).active, stats.samples);
  EXPECT_EQ(Of(lanes, Kernel::kFilm).active, stats.samples);
  EXPECT_EQ(Of(lanes, Kernel::kIntersect).active, rays(RayKind::kCamera) + rays(RayKind::kBounce));
  EXPECT_EQ(Of(lanes, Kernel::kShadow).active, rays(RayKind::kShadow));
  EXPECT_GT(Of(lanes, Kernel::kAccumulate).active, 0u);
  EXPECT_LT(Of(lanes, Kernel::kAccumulate).active, rays(RayKind::kShadow));
  // A ray that hits and is shaded is neither escaped nor lost.
  EXPECT_LE(Of(lanes, Kernel::kMoveHits).active + Of(lanes, Kernel::kEscape).active,
            Of(lanes, Kernel::kIntersect).active);
  EXPECT_EQ(Of(lanes, Kernel::kMoveHits).active, Of(lanes, Kernel::kSurface).active);
  std::uint64_t evaluated = 0;
  for (std::uint32_t kind = 0; kind < kFirstDeltaBsdf; ++kind) {
    evaluated += Of(lanes, Kernel::kEvaluate, BsdfKind(kind)).active;
  }
  EXPECT_EQ(evaluated, Of(lanes, Kernel::kLightSample).active);
}

INSTANTIATE_TEST_SUITE_P(All, LanesOfARender,
                         testing::Values(Integrator::kPath, Integrator::kDirect,
                                         Integrator::kLight),
                         [](const auto& test) { return std::string(ToString(test.param)); });

}  // namespace
}  // namespace skywave
