// Tests replays of a frame's rays: every call and every order finds the hits of the frame.
#include "wavefront/rays/replay.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <memory>
#include <random>
#include <utility>
#include <vector>

#include "job/job.h"
#include "scene/builtin/builtin.h"
#include "tests/support/screens_scene.h"
#include "wavefront/render.h"

namespace skywave {
namespace {

constexpr RayOrder kOrders[] = {RayOrder::kTraced, RayOrder::kWave, RayOrder::kFrame};

struct RecordedFrame {
  explicit RecordedFrame(Scene scene = BuiltinScene("spheres")) {
    JobRequest request;
    request.width = 48, request.height = 32, request.samples_per_pixel = 4;
    request.options.threads = 2;
    job = std::make_unique<RenderJob>(std::move(scene), request);
    Film film = job->MakeFilm();
    result = RenderFrame(job->frame(), film, {.recorders = &recorders});
  }
  std::unique_ptr<RenderJob> job;
  std::vector<RayRecorder> recorders;
  FrameResult result;
};

using Ray = std::array<float, 6>;

constexpr RayKind kKinds[] = {RayKind::kCamera, RayKind::kBounce, RayKind::kShadow};

std::vector<Ray> Rays(const std::vector<RayRecorder>& recorders, RayKind kind) {
  std::vector<Ray> rays;
  for (const RayRecorder& recorder : recorders) {
    for (const RayBatch& batch : recorder.batches()) {
      if (batch.kind != kind) continue;
      for (std::size_t i = batch.begin; i < batch.begin + batch.count; ++i) {
        rays.push_back({recorder.org(0)[i], recorder.org(1)[i], recorder.org(2)[i],
                        recorder.dir(0)[i], recorder.dir(1)[i], recorder.dir(2)[i]});
      }
    }
  }
  return rays;
}

int Octant(const Ray& ray) { return (ray[3] < 0) | (ray[4] < 0) << 1 | (ray[5] < 0) << 2; }

TEST(Replay, TracesEveryRayOfTheFrame) {
  const RecordedFrame frame;
  for (const RayKind kind : kKinds) {
    EXPECT_EQ(Rays(frame.recorders, kind).size(), frame.result.stats.rays[std::uint32_t(kind)]);
  }
  for (const RayRecorder& recorder : frame.recorders) {
    for (const RayBatch& batch : recorder.batches()) {
      if (batch.kind == RayKind::kBounce) continue;  // the last ones only test whether they escape
      EXPECT_EQ(batch.occlusion, batch.kind == RayKind::kShadow);
    }
  }
}

// In a room without sun and environment, every shadow ray ends at a lamp, in a replay too.
TEST(Replay, ShadowRaysEndAtTheirLights) {
  const RecordedFrame frame(BuiltinScene("lamps"));
  for (const RayOrder order : kOrders) {
    for (const RayRecorder& recorder : OrderRays(frame.recorders, order)) {
      for (const RayBatch& batch : recorder.batches()) {
        for (std::size_t i = batch.begin; i < batch.begin + batch.count; ++i) {
          ASSERT_EQ(std::isfinite(recorder.t_far()[i]), batch.occlusion);
        }
      }
    }
  }
}

class ReplayOf : public testing::TestWithParam<bool> {};

TEST_P(ReplayOf, HitsAreTheSameForEveryCallAndOrder) {
  const RecordedFrame frame(GetParam() ? ScreensScene() : BuiltinScene("spheres"));
  const RTCScene scene = frame.job->geometry().scene();
  const ReplayTime first = Replay(scene, Backend::kSingle, frame.recorders, 1);
  for (const RayKind kind : kKinds) {
    EXPECT_GT(first.hits[std::uint32_t(kind)], 0u);
    EXPECT_LT(first.hits[std::uint32_t(kind)], Rays(frame.recorders, kind).size());
  }
  for (const RayOrder order : kOrders) {
    const std::vector<RayRecorder> ordered = OrderRays(frame.recorders, order);
    for (const Backend backend : kBackends) {
      SCOPED_TRACE(ToString(backend));
      const ReplayTime time = Replay(scene, backend, ordered, 3);
      EXPECT_EQ(time.hits, first.hits);
      for (const double seconds : time.seconds) EXPECT_GT(seconds, 0);
    }
  }
}

INSTANTIATE_TEST_SUITE_P(Replay, ReplayOf, testing::Bool(), [](const auto& test) {
  return test.param ? "SceneWithAlpha" : "OpaqueScene";
});

TEST(OrderRays, KeepsEveryRay) {
  const RecordedFrame frame;
  for (const RayKind kind : kKinds) {
    std::vector<Ray> before = Rays(frame.recorders, kind);
    std::sort(before.begin(), before.end());
    for (const RayOrder order : kOrders) {
      std::vector<Ray> after = Rays(OrderRays(frame.recorders, order), kind);
      std::sort(after.begin(), after.end());
      EXPECT_EQ(after, before);
    }
  }
}

TEST(OrderRays, SortsTheFrameByOctantThenAlongACurve) {
  const RecordedFrame frame;
  std::vector<Ray> shuffled = Rays(frame.recorders, RayKind::kShadow);
  std::shuffle(shuffled.begin(), shuffled.end(), std::mt19937(1));
  const std::vector<Ray> sorted =
      Rays(OrderRays(frame.recorders, RayOrder::kFrame), RayKind::kShadow);
  const auto path = [](const std::vector<Ray>& rays) {
    double length = 0;
    for (std::size_t i = 1; i < rays.size(); ++i) {
      for (int axis = 0; axis < 3; ++axis) length += std::abs(rays[i][axis] - rays[i - 1][axis]);
    }
    return length;
  };
  EXPECT_TRUE(std::is_sorted(sorted.begin(), sorted.end(),
                             [](const Ray& a, const Ray& b) { return Octant(a) < Octant(b); }));
  EXPECT_LT(path(sorted), 0.3 * path(shuffled));
}

TEST(OrderRays, KeepsTheBatchesOfWaves) {
  const float zero[3] = {0, 0, 0}, up[3] = {1, -1, 1}, down[3] = {-1, 1, -1};
  const float far[3] = {1e30f, 1e30f, 1e30f};
  const float* const org[3] = {zero, zero, zero};
  const float* const dir[3] = {up, up, up};
  const float* const turned[3] = {down, down, down};
  std::vector<RayRecorder> recorders(1);
  recorders[0].Record(RayKind::kBounce, false, org, dir, far, 3);
  recorders[0].Record(RayKind::kBounce, false, org, turned, far, 2);
  const std::vector<RayRecorder> waves = OrderRays(recorders, RayOrder::kWave);
  ASSERT_EQ(waves[0].batches().size(), 2u);
  EXPECT_EQ(waves[0].batches()[0].count, 3u);
  EXPECT_EQ(waves[0].dir(0)[0], 1);
  EXPECT_EQ(waves[0].dir(0)[1], 1);
  EXPECT_EQ(waves[0].dir(0)[2], -1);
  EXPECT_EQ(waves[0].dir(0)[3], 1);
  EXPECT_EQ(OrderRays(recorders, RayOrder::kFrame)[0].batches().size(), 1u);
}

}  // namespace
}  // namespace skywave
