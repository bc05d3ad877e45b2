// Compares the irradiance cache with closed forms, path tracing and itself.
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <limits>
#include <numbers>
#include <vector>

#include "tests/support/matt_room.h"
#include "tests/support/photon_maps.h"
#include "tests/support/picture_estimate.h"
#include "tests/support/render_scenes.h"
#include "tests/support/rendered_image.h"
#include "tests/support/shining_cave.h"
#include "tests/support/statistics.h"
#include "wavefront/passes/irradiance_pass.h"
#include "wavefront/records/irradiance_cache.h"
#include "wavefront/render.h"

namespace skywave {
namespace {

JobRequest Request(int width, int height, std::uint32_t samples) {
  JobRequest request = SmallRequest(width, height, samples);
  request.integrator = Integrator::kIrradianceCache;
  request.max_depth = 4;
  return request;
}

std::vector<IrradianceRecord> RecordsOf(const RenderJob& job) {
  WorkerPool pool = TwoThreads(job.frame());
  std::vector<IrradianceRecord> records;
  pool.Run([&] {
    const IrradianceCache cache = MakeIrradianceCache(job.frame(), pool);
    records.assign(cache.records().begin(), cache.records().end());
  });
  return records;
}

Triple TripleOf(const glm::dvec3& v) { return {float(v.x), float(v.y), float(v.z)}; }

// Measures what a point sees of a wide ceiling with a bright spot for each channel, by the middles
// of many cells.
MeasuredIrradiance MeasureUnderTheCeiling(const glm::dvec3& point, const glm::dvec3& normal) {
  constexpr double kHeight = 1.5;
  const HemisphereGrid grid = GridOf(20000);
  const Axes axes = AxesAround(TripleOf(normal));
  std::vector<HemisphereSample> samples(grid.count());
  std::vector<Triple> directions(grid.count());
  for (std::uint32_t i = 0; i < grid.count(); ++i) {
    directions[i] = DirectionInCell(grid, i, 0.5f, 0.5f, axes);
    const glm::dvec3 dir(directions[i][0], directions[i][1], directions[i][2]);
    samples[i] = {.radiance = {}, .distance = std::numeric_limits<float>::infinity()};
    if (dir.z < 1e-3) continue;
    const double t = (kHeight - point.z) / dir.z;
    samples[i].distance = float(t);
    for (std::size_t c = 0; c < 3; ++c) {
      const glm::dvec3 spot(0.7 * double(c) - 0.4, 0.5 - 0.6 * double(c), kHeight);
      const glm::dvec3 offset = point + t * dir - spot;
      samples[i].radiance[c] = float(std::exp(-glm::dot(offset, offset)));
    }
  }
  return MeasureIrradiance(grid, axes, samples, directions);
}
IrradianceRecord UnderTheCeiling(const glm::dvec3& point, const glm::dvec3& normal) {
  return MeasureUnderTheCeiling(point, normal).record;
}

// Gradients of a record are the changes of its irradiance, by differences of records.
TEST(IrradianceGradients, MatchDifferencesOfRecords) {
  const glm::dvec3 point(0.1, -0.2, 0.3), normal = glm::normalize(glm::dvec3(0.3, -0.2, 1));
  const IrradianceRecord record = UnderTheCeiling(point, normal);
  const Axes axes = AxesAround(record.normal);
  constexpr double kStep = 0.02;
  for (const Triple& axis : {axes.x, axes.y}) {
    const glm::dvec3 step = kStep * glm::dvec3(axis[0], axis[1], axis[2]);
    const IrradianceRecord moved[] = {UnderTheCeiling(point - step, normal),
                                      UnderTheCeiling(point + step, normal)};
    const glm::dvec3 turn = glm::cross(step, normal);
    const IrradianceRecord turned[] = {UnderTheCeiling(point, glm::normalize(normal - turn)),
                                       UnderTheCeiling(point, glm::normalize(normal + turn))};
    for (std::size_t c = 0; c < 3; ++c) {
      const auto along = [&](const Triple& gradient) {
        return double(gradient[0] * axis[0] + gradient[1] * axis[1] + gradient[2] * axis[2]);
      };
      const auto change = [&](const IrradianceRecord(&records)[2]) {
        return double(records[1].irradiance[c] - records[0].irradiance[c]) / (2 * kStep);
      };
      const double scale = double(record.irradiance[c]);
      EXPECT_NEAR(along(record.move[c]) / scale, change(moved) / scale, 0.01) << c;
      EXPECT_NEAR(along(record.turn[c]) / scale, change(turned) / scale, 0.01) << c;
    }
  }
}

// Under a constant sky irradiance is pi times its radiance, and nothing changes it.
TEST(IrradianceGradients, VanishInConstantLight) {
  const HemisphereGrid grid = GridOf(300);
  const Axes axes = AxesAround({0.6f, 0, -0.8f});
  const std::vector<HemisphereSample> samples(grid.count(), {.radiance = {1, 2, 3}, .distance = 2});
  std::vector<Triple> directions;
  for (std::uint32_t i = 0; i < grid.count(); ++i) {
    directions.push_back(DirectionInCell(grid, i, 0.5f, 0.5f, axes));
  }
  const MeasuredIrradiance measured = MeasureIrradiance(grid, axes, samples, directions);
  EXPECT_NEAR(measured.distance, 2, 1e-4);
  for (std::size_t c = 0; c < 3; ++c) {
    EXPECT_NEAR(measured.record.irradiance[c], std::numbers::pi * double(c + 1), 1e-4);
    for (std::size_t axis = 0; axis < 3; ++axis) {
      EXPECT_NEAR(measured.record.move[c][axis], 0, 1e-4);
      EXPECT_NEAR(measured.record.turn[c][axis], 0, 1e-3);
    }
  }
}

// A record counts as far as its surroundings are away, by their harmonic mean, and no farther than
// its gradient would take the irradiance to nothing (Ward and Heckbert 1992).
TEST(IrradianceGradients, BoundHowFarARecordCounts) {
  const HemisphereGrid grid = GridOf(200);
  const Axes axes = AxesAround({0, 0, 1});
  std::vector<HemisphereSample> samples(grid.count());
  std::vector<Triple> directions;
  double inverse = 0;
  for (std::uint32_t i = 0; i < grid.count(); ++i) {
    samples[i] = {.radiance = {1, 1, 1}, .distance = 0.5f + float(i * 7 % 11)};
    inverse += 1 / double(samples[i].distance) / double(grid.count());
    directions.push_back(DirectionInCell(grid, i, 0.5f, 0.5f, axes));
  }
  EXPECT_NEAR(double(MeasureIrradiance(grid, axes, samples, directions).distance), 1 / inverse,
              1e-4 / inverse);

  // Far from the spots of the ceiling the light falls fast, and the ceiling is farther away.
  const glm::dvec3 point(2.5, -1.5, 0), normal(0, 0, 1);
  constexpr double kStep = 0.02;
  const auto light = [](const IrradianceRecord& record) {
    return 0.2126 * double(record.irradiance[0]) + 0.7152 * double(record.irradiance[1]) +
           0.0722 * double(record.irradiance[2]);
  };
  const auto change = [&](const glm::dvec3& step) {
    return (light(UnderTheCeiling(point + step, normal)) -
            light(UnderTheCeiling(point - step, normal))) /
           (2 * kStep);
  };
  const double slope = std::hypot(change({kStep, 0, 0}), change({0, kStep, 0}));
  const MeasuredIrradiance measured = MeasureUnderTheCeiling(point, normal);
  EXPECT_LT(light(measured.record) / slope, 1.5);
  EXPECT_NEAR(double(measured.distance) * slope / light(measured.record), 1, 0.03);
}

TEST(IrradianceCache, FindsAllRecordsThatCountAndNoOthers) {
  std::vector<IrradianceRecord> records;
  for (int i = 0; i < 40; ++i) {
    IrradianceRecord record = {.position = {0.3f * float(i) - 5, 0.1f * float(i % 7), -0.2f},
                               .normal = {0, 0, 1},
                               .radius = 0.05f * float(1 + i % 11)};
    record.irradiance = {float(i), 1, 0};
    record.move[1] = {2, 0, 0};
    records.push_back(record);
  }
  const IrradianceCache cache(records, 0.3f);
  int found = 0;
  for (int x = -60; x <= 90; ++x) {
    for (int y = -6; y <= 12; ++y) {
      const Triple at = {0.1f * float(x), 0.1f * float(y), -0.2f};
      double sum = 0, moved = 0, weights = 0;
      for (const IrradianceRecord& r : records) {
        const double dx = double(at[0]) - double(r.position[0]);
        const double error =
            std::hypot(dx, double(at[1]) - double(r.position[1])) / double(r.radius);
        if (error > 0.999) continue;
        const double weight = 1 / std::max(error, 1e-3) - 1;
        weights += weight, sum += weight * double(r.irradiance[0]);
        moved += weight * std::max(0.0, 1 + 2 * dx);
      }
      Triple irradiance = {};
      const bool known = cache.Interpolate(at, {0, 0, 1}, irradiance);
      if (weights > 0) {
        ++found;
        ASSERT_TRUE(known);
        if (weights < 0.01) continue;  // at the rim, where rounding decides
        EXPECT_NEAR(double(irradiance[0]), sum / weights, 1e-2);
        EXPECT_NEAR(double(irradiance[1]), moved / weights, 1e-2);
      }
      EXPECT_FALSE(cache.Interpolate({at[0], at[1], 0.5f}, {0, 0, 1}, irradiance));
      EXPECT_FALSE(cache.Interpolate(at, {0, 1, 0}, irradiance));
    }
  }
  EXPECT_GT(found, 100);
}

TEST(IrradianceCache, FollowsTheGradientsOfARecord) {
  IrradianceRecord record = {.position = {1, 2, 3}, .normal = {0, 0, 1}, .radius = 0.5f};
  record.irradiance = {1, 1, 1};
  record.turn[1] = {0, 3, 0};
  record.move[2] = {0, -2, 0};
  const IrradianceCache cache({record}, 0.5f);
  Triple irradiance = {};
  // The normal is turned about the second axis, by an angle of this sine.
  constexpr float kSine = 0.2f;
  ASSERT_TRUE(
      cache.Interpolate({1, 2.1f, 3}, {kSine, 0, std::sqrt(1 - kSine * kSine)}, irradiance));
  EXPECT_NEAR(irradiance[0], 1, 1e-5);
  EXPECT_NEAR(irradiance[1], 1 + 3 * kSine, 1e-5);
  EXPECT_NEAR(irradiance[2], 1 - 2 * 0.1f, 1e-5);
}

// What lies behind a record, as the side of a step does below its edge, sees what the record does
// not.
TEST(IrradianceCache, RecordsDoNotCountBehindTheirSurface) {
  IrradianceRecord record = {.position = {1, 2, 3}, .normal = {0, 0, 1}, .radius = 2};
  record.irradiance = {1, 1, 1};
  const IrradianceCache cache({record}, 1);
  Triple irradiance = {};
  for (const float turn : {0.0f, 0.2f, -0.2f}) {
    const Triple normal = {turn, 0, std::sqrt(1 - turn * turn)};
    EXPECT_TRUE(cache.Interpolate({1, 2.4f, 3}, normal, irradiance)) << turn;
    EXPECT_TRUE(cache.Interpolate({1, 2.4f, 3.4f}, normal, irradiance)) << turn;
    EXPECT_TRUE(cache.Interpolate({1, 2.4f, 2.95f}, normal, irradiance)) << turn;
    EXPECT_FALSE(cache.Interpolate({1, 2.4f, 2.6f}, normal, irradiance)) << turn;
  }
}

// All light is the same everywhere in the cave, so what is interpolated is exact up to the noise of
// the rays of a record.
TEST(IrradianceCache, CaveIsAsBrightAsItsSeries) {
  for (const std::uint32_t depth : {1u, 2u, 5u}) {
    JobRequest request = Request(16, 16, 16);
    request.max_depth = depth;
    request.options.of<IrradianceCacheOptions>() = {.accuracy = 0.3f, .rays = 512};
    const Image picture = Render(ShiningCave(), request);
    double sum[3] = {}, worst = 0;
    for (std::size_t i = 0; i < picture.rgb.size(); ++i) {
      const int c = int(i % 3);
      worst = std::max(worst, std::fabs(double(picture.rgb[i]) / CaveRadiance(c, depth) - 1));
      sum[c] += double(picture.rgb[i]) / (16 * 16);
    }
    EXPECT_LT(worst, 0.05);
    for (int c = 0; c < 3; ++c) EXPECT_NEAR(sum[c] / CaveRadiance(c, depth), 1, 0.007) << depth;
  }
}

TEST(IrradianceCache, MatchesPathTracingWithinItsBias) {
  for (const BsdfKind bsdf : {BsdfKind::kLambert, BsdfKind::kMirror, BsdfKind::kConductor}) {
    const Scene scene = MattRoom(Of(bsdf), kLamp | kEnvironment);
    JobRequest request = Request(30, 18, 64);
    const RenderJob job(scene, request);
    const PictureEstimate cached = EstimateFromEngine(job, 4, 100);
    request.integrator = Integrator::kPath;
    request.samples_per_pixel = 1024;
    const PictureEstimate paths = EstimateFromEngine(RenderJob(scene, request), 2, 200);
    double ratio = 0, all = 0;
    for (std::size_t i = 0; i < paths.mean.size(); ++i)
      ratio += cached.mean[i], all += paths.mean[i];
    const double difference = RelativeDifference(cached, paths);
    std::printf("%u: difference %.4f, mean %.4f\n", unsigned(bsdf), difference, ratio / all);
    EXPECT_LT(difference, 0.04);
    EXPECT_NEAR(ratio / all, 1, 0.01);
  }
}

// No point of a plane sees another one, so there is no light but the direct one, however far its
// shading normals lean: below its triangle a hemisphere sees nothing.
TEST(IrradianceCache, BentNormalsSeeNothingBelowTheirTriangle) {
  Scene scene;
  Mesh floor = Quad(2);
  floor.normals.assign(floor.positions.size(), glm::normalize(glm::vec3(1, 1, 0)));
  Place(scene, floor, AddLambert(scene, "floor", glm::vec3(0.9f)), glm::vec3(0));
  SetConstantLight(scene, 1);
  scene.camera = LookAtCamera({1.5f, 2, 0.5f}, {0, 0, 0}, {0, 1, 0}, 30, false);
  Image pictures[2];
  for (const std::uint32_t depth : {1u, 4u}) {
    JobRequest request = Request(16, 16, 16);
    request.max_depth = depth;
    pictures[depth == 4] = Render(scene, request);
  }
  for (std::size_t i = 0; i < pictures[0].rgb.size(); ++i) {
    EXPECT_GT(pictures[0].rgb[i], 0.1f);
    EXPECT_NEAR(pictures[1].rgb[i], pictures[0].rgb[i], 1e-5 * pictures[0].rgb[i]) << i;
  }
}

// As far as a record counts, its gradient changes the irradiance by the accuracy's share at most,
// also where the record counts farther than its surroundings suggest because pixels are large.
TEST(IrradianceCache, GradientsChangeARecordOnlySlightly) {
  const Scene scene = MattRoom(Of(BsdfKind::kLambert), kLamp | kEnvironment);
  JobRequest request = Request(24, 18, 4);
  request.options.of<IrradianceCacheOptions>() = {.accuracy = 0.2f, .rays = 64};
  const std::vector<IrradianceRecord> records = RecordsOf(RenderJob(scene, request));
  ASSERT_GT(records.size(), 20u);
  const auto luminance = [](double r, double g, double b) {
    return 0.2126 * r + 0.7152 * g + 0.0722 * b;
  };
  double most = 0;
  for (const IrradianceRecord& r : records) {
    double square = 0;
    for (std::size_t axis = 0; axis < 3; ++axis) {
      square += std::pow(luminance(r.move[0][axis], r.move[1][axis], r.move[2][axis]), 2);
    }
    const double all = luminance(r.irradiance[0], r.irradiance[1], r.irradiance[2]);
    if (all > 0) most = std::max(most, std::sqrt(square) * double(r.radius) / all);
  }
  EXPECT_LT(most, 0.2 * 1.001);
  EXPECT_GT(most, 0.1);
}

// Every point of a small floor sees the same of a far ceiling, which the sky below lights evenly.
// Records have rays of their own, so the mean of many comes close to the form factor of the square
// (Howell, configuration B-4).
TEST(IrradianceCache, RecordsAreIndependent) {
  constexpr float kHeight = 20, kHalf = 12, kAlbedo = 0.8f;
  Scene scene;
  Place(scene, Quad(0.1f), AddLambert(scene, "floor", glm::vec3(0.5f)), glm::vec3(0));
  Mesh ceiling = Quad(kHalf);
  FlipOrientation(ceiling);
  Place(scene, ceiling, AddLambert(scene, "ceiling", glm::vec3(kAlbedo)), {0, kHeight, 0});
  SetConstantLight(scene, 1);
  scene.camera = LookAtCamera({0, 0.3f, 0}, {0, 0, 0}, {0, 0, 1}, 30, false);
  JobRequest request = Request(64, 64, 1);
  request.max_depth = 2;
  request.options.of<IrradianceCacheOptions>() = {.accuracy = 1e-4f, .rays = 16};
  const std::vector<IrradianceRecord> records = RecordsOf(RenderJob(scene, request));
  Moments irradiance;
  for (const IrradianceRecord& r : records) irradiance.Add(double(r.irradiance[1]));
  ASSERT_GT(irradiance.count(), 300u);
  const double x = double(kHalf) / double(kHeight), to_edge = x / std::sqrt(1 + x * x);
  const double form_factor = 4 / std::numbers::pi * to_edge * std::atan(to_edge);
  EXPECT_TRUE(AgreesWith(irradiance.mean(), irradiance.standard_error(),
                         double(kAlbedo) * std::numbers::pi * form_factor, kSuiteLevel, 1e-3));
}

TEST(IrradianceCache, PartsOfAFilmEqualTheWhole) {
  const Scene scene = MattRoom(Of(BsdfKind::kMirror), kLamp | kEnvironment);
  JobRequest request = Request(37, 29, 3);
  request.options.of<IrradianceCacheOptions>().rays = 30;
  const Image whole = Render(scene, request);
  request.crop = CropWindow{9, 7, 12, 9};
  request.options.threads = 1, request.options.wave = 64;
  const Image part = Render(scene, request);
  for (int y = 0; y < 9; ++y) {
    for (int x = 0; x < 12; ++x) {
      for (int c = 0; c < 3; ++c) EXPECT_EQ(part.Pixel(x, y)[c], whole.Pixel(x + 9, y + 7)[c]);
    }
  }
}

}  // namespace
}  // namespace skywave
