// Compares camera rays with double arithmetic, on films of awkward sizes, and tests the pixel
// filters.

#include "kernels/camera.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>

#include "tests/support/random_rows.h"
#include "tests/support/statistics.h"
#include "tests/support/targets.h"
#include "wavefront/frame.h"

namespace skywave {
namespace {

const std::vector<float> kNoOffsets(kFilterCells + 1, 0.0f);

// Returns a camera whose rays reveal the film position: direction (x, y, 1) * scale.
CameraView FlatCamera(std::uint32_t width, float scale, const float* offsets) {
  return {.origin = {1, 2, 3},
          .corner = {0, 0, 1},
          .right = {scale, 0, 0},
          .down = {0, scale, 0},
          .forward = {0, 0, 1},
          .lens_x = {},
          .lens_y = {},
          .width = width,
          .filter_offset = offsets};
}

TEST(Camera, FindsPixelsOfAnyFilm) {
  for (const std::uint32_t width : {1u, 2u, 3u, 7u, 41u, 49u, 640u, 1921u, 4099u, 16384u, 32768u}) {
    const std::uint32_t height = width == 1 ? 4099 : std::min(width, 32768u);
    std::vector<std::uint32_t> rows = {0, 1, height / 3, height / 2, height - 1};
    Random random(81);
    for (int i = 0; i < 100; ++i) rows.push_back(random.Word() % height);
    std::vector<std::uint32_t> pixels;
    for (const std::uint32_t row : rows) {
      if (row >= height) continue;
      for (const std::uint32_t column : {0u, width / 2, width - 1}) {
        pixels.push_back(row * width + column);
      }
    }
    const auto n = std::uint32_t(pixels.size());
    soa::Table<PathColumns> paths(n);
    std::copy(pixels.begin(), pixels.end(), paths->pixel);
    const soa::Table<UniformColumns> film(n);
    const float scale = 1.0f / 4096;
    ForEachTarget([&] {
      soa::Table<RayColumns> rays(n);
      GenerateCameraRays(FlatCamera(width, scale, kNoOffsets.data()), paths, film, film, n, rays);
      for (std::uint32_t i = 0; i < n; ++i) {
        const double x = rays->dir_x[i] / rays->dir_z[i] / scale;
        const double y = rays->dir_y[i] / rays->dir_z[i] / scale;
        ASSERT_NEAR(x, pixels[i] % width + 0.5, 0.1)
            << "pixel " << pixels[i] << ", width " << width;
        ASSERT_NEAR(y, pixels[i] / width + 0.5, 0.1)
            << "pixel " << pixels[i] << ", width " << width;
      }
    });
  }
}

TEST(Camera, DirectionsMatchDoubleArithmetic) {
  const Camera camera = LookAtCamera({1, 2, 3}, {-4, 1.5f, 8}, {0.1f, 1, 0.2f}, 37, false);
  const Vec right = Unit({camera.world_from_camera[0][0], camera.world_from_camera[0][1],
                          camera.world_from_camera[0][2]});
  const Vec up = Unit({camera.world_from_camera[1][0], camera.world_from_camera[1][1],
                       camera.world_from_camera[1][2]});
  const Vec forward = Unit({camera.world_from_camera[2][0], camera.world_from_camera[2][1],
                            camera.world_from_camera[2][2]});
  EXPECT_LT(Angle(forward, Vec{-5, -0.5, 5}), 1e-6) << "looks at its target";
  const auto offsets = FilterOffsets(PixelFilter::kBox, 0.5f);
  for (const auto& [width, height] : {std::pair{640, 480}, {480, 640}, {1, 1}, {301, 7}}) {
    const CameraView view = MakeCameraView(camera, width, height, offsets.data());
    const std::uint32_t n = kFullWave;
    soa::Table<PathColumns> paths(n);
    Random random(82);
    for (std::uint32_t i = 0; i < n; ++i) {
      const std::uint32_t pixel = random.Word() % std::uint32_t(width * height);
      paths->pixel[i] = pixel / std::uint32_t(width) * view.width + pixel % std::uint32_t(width);
    }
    const auto film = RandomUniforms(n, 83);
    soa::Table<RayColumns> rays(n);
    GenerateCameraRays(view, paths, film, film, n, rays);
    // The field of view is that of the shorter side.
    const double pixel = 2 * std::tan(37 * kPi / 360) / std::min(width, height);
    for (std::uint32_t i = 0; i < n; ++i) {
      // With a box filter, the offset is the uniform number itself.
      const double x = paths->pixel[i] % view.width + double(film->u[i]);
      const double y = paths->pixel[i] / view.width + double(film->v[i]);
      const Vec exact =
          forward + (x - width / 2.0) * pixel * right - (y - height / 2.0) * pixel * up;
      const Vec direction = Get(i, rays->dir_x, rays->dir_y, rays->dir_z);
      ASSERT_LT(Angle(direction, exact), 2e-6) << "row " << i;
      ASSERT_NEAR(Length(direction), 1, 1e-6);
      ASSERT_EQ(rays->org_x[i], 1);
      ASSERT_EQ(rays->org_y[i], 2);
      ASSERT_EQ(rays->org_z[i], 3);
      ASSERT_EQ(rays->t_far[i], std::numeric_limits<float>::infinity());
      ASSERT_EQ(rays->throughput_r[i] + rays->throughput_g[i] + rays->throughput_b[i], 3);
      ASSERT_EQ(rays->pdf[i], 0);
      ASSERT_EQ(rays->path[i], i);
      ASSERT_EQ(rays->from[i], i);
    }
  }
}

TEST(Camera, BitsDoNotDependOnTargetOrNumberOfRows) {
  const auto offsets = FilterOffsets(PixelFilter::kBlackmanHarris, 1.5f);
  soa::Table<PathColumns> paths(kFullWave);
  for (std::uint32_t i = 0; i < kFullWave; ++i) paths->pixel[i] = i * 37;
  const auto film = RandomUniforms(kFullWave, 84);
  const CameraView view = FlatCamera(311, 0.003f, offsets.data());
  soa::Table<RayColumns> full(kFullWave);
  GenerateCameraRays(view, paths, film, film, kFullWave, full);
  ForEachTarget([&] {
    for (const std::uint32_t n : kRowCounts) {
      soa::Table<RayColumns> rays(kFullWave);
      GenerateCameraRays(view, paths, film, film, n, rays);
      EXPECT_EQ(ColumnBits(rays.columns(), n), ColumnBits(full.columns(), n)) << n << " rows";
    }
  });
}

struct FilterCase {
  PixelFilter filter;
  float radius;
};
// Returns the unnormalised filter at x in [-1, 1] radii.
double Weight(PixelFilter filter, double x) {
  switch (filter) {
    case PixelFilter::kBox:
      return 1;
    case PixelFilter::kTriangle:
      return 1 - std::fabs(x);
    case PixelFilter::kGaussian:
      return std::exp(-4.5 * x * x) - std::exp(-4.5);
    case PixelFilter::kBlackmanHarris:
      return 0.35875 + 0.48829 * std::cos(kPi * x) + 0.14128 * std::cos(2 * kPi * x) +
             0.01168 * std::cos(3 * kPi * x);
    default:
      break;  // tests/wavefront/pixel_filter_test.cc has those with signs
  }
  return 0;
}

TEST(Filters, SamplesFollowTheFilter) {
  for (const FilterCase& c : {FilterCase{PixelFilter::kBox, 0.5f},
                              {PixelFilter::kBox, 2},
                              {PixelFilter::kTriangle, 1},
                              {PixelFilter::kGaussian, 1.5f},
                              {PixelFilter::kBlackmanHarris, 1.5f},
                              {PixelFilter::kBlackmanHarris, 3}}) {
    SCOPED_TRACE("filter " + std::to_string(int(c.filter)) + " of radius " +
                 std::to_string(c.radius));
    const auto offsets = FilterOffsets(c.filter, c.radius);
    ASSERT_EQ(offsets.size(), kFilterCells + 1);
    EXPECT_TRUE(std::is_sorted(offsets.begin(), offsets.end()));
    for (std::uint32_t i = 0; i <= kFilterCells; ++i) {
      ASSERT_LE(std::fabs(offsets[i]), c.radius);
      ASSERT_NEAR(offsets[i], -offsets[kFilterCells - i], 1e-4 * c.radius) << "cell " << i;
    }
    // The bins are equal parts of the filter, each 32 cells of the table: within a cell offsets are
    // interpolated, which matters in the thin tails only.
    constexpr std::uint32_t kSamples = 100000;
    constexpr int kBins = kFilterCells / 32, kSteps = 100000;
    std::vector<double> cumulative(kSteps + 1);
    for (int i = 0; i < kSteps; ++i) {
      cumulative[i + 1] = cumulative[i] + Weight(c.filter, 2 * (i + 0.5) / kSteps - 1);
    }
    soa::Table<PathColumns> paths(kSamples);
    const auto film = RandomUniforms(kSamples, 85);
    soa::Table<RayColumns> rays(kSamples);
    GenerateCameraRays(FlatCamera(1, 0.01f, offsets.data()), paths, film, film, kSamples, rays);
    std::vector<double> observed_x(kBins), observed_y(kBins);
    const std::vector<double> expected(kBins, double(kSamples) / kBins);
    for (std::uint32_t i = 0; i < kSamples; ++i) {
      const auto bin = [&](double direction) {
        const double offset = direction / rays->dir_z[i] / 0.01f - 0.5;
        EXPECT_LE(std::fabs(offset), c.radius * 1.0001);
        const int step = std::clamp(int((offset / c.radius + 1) / 2 * kSteps), 0, kSteps - 1);
        const double share = (cumulative[step] + cumulative[step + 1]) / 2 / cumulative[kSteps];
        return std::min(int(share * kBins), kBins - 1);
      };
      ++observed_x[bin(rays->dir_x[i])], ++observed_y[bin(rays->dir_y[i])];
    }
    EXPECT_TRUE(MatchesExpected(observed_x, expected, SidakLevel(12)));
    EXPECT_TRUE(MatchesExpected(observed_y, expected, SidakLevel(12)));
  }
}

TEST(Filters, HaveARadiusOfTheirOwn) {
  // A pixel, the neighbours between which is interpolated, three deviations of half a pixel, the
  // support of Mitchell and Netravali's cubic, and four lobes.
  EXPECT_EQ(DefaultFilterRadius(PixelFilter::kBox), 0.5f);
  EXPECT_EQ(DefaultFilterRadius(PixelFilter::kTriangle), 1.0f);
  EXPECT_EQ(DefaultFilterRadius(PixelFilter::kGaussian), 1.5f);
  EXPECT_EQ(DefaultFilterRadius(PixelFilter::kMitchell), 2.0f);
  EXPECT_EQ(DefaultFilterRadius(PixelFilter::kSinc), 4.0f);
  EXPECT_GE(DefaultFilterRadius(PixelFilter::kBlackmanHarris), 1.0f);
}

}  // namespace
}  // namespace skywave
