// Compares connections to the camera with the camera's own rays: they must reverse them, and splats
// must cover the film exactly.

#include "kernels/light_paths/camera_connection.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>

#include "tests/support/random_rows.h"
#include "tests/support/render_scenes.h"
#include "tests/support/statistics.h"
#include "tests/support/targets.h"
#include "wavefront/frame.h"

namespace skywave {
namespace {

constexpr int kWidth = 64, kHeight = 48;

struct CameraCase {
  CameraKind kind;
  bool lens;
};
const CameraCase kCases[] = {{CameraKind::kPerspective, false},  {CameraKind::kPerspective, true},
                             {CameraKind::kOrthographic, false}, {CameraKind::kOrthographic, true},
                             {CameraKind::kLatLong, false},      {CameraKind::kEqualArea, false},
                             {CameraKind::kFisheye, false}};

// The camera is oblique, left-handed and scaled.
Camera CameraOf(const CameraCase& c) {
  Camera camera = LookAtCamera({1, 2, 3}, {-4, 1.5f, 8}, {0.1f, 1, 0.2f}, 70, true);
  for (int i = 0; i < 3; ++i) camera.world_from_camera[i] *= 1.5f;
  camera.kind = c.kind;
  if (c.kind == CameraKind::kFisheye) camera.fov_degrees = 200;
  if (c.lens) camera.lens_radius = 0.25f, camera.focal_distance = 3;
  return camera;
}

struct Connected {
  explicit Connected(std::uint32_t n) : points(n), lens(n), lights(n), cameras(n) {}
  soa::Table<SurfaceColumns> points;
  soa::Table<UniformColumns> lens;
  soa::Table<LightColumns> lights;
  soa::Table<CameraColumns> cameras;
};

class CameraConnections : public testing::TestWithParam<std::size_t> {
 protected:
  CameraConnections()
      : offsets_(FilterOffsets(PixelFilter::kBox, 0.5f)),
        camera_(CameraOf(kCases[GetParam()])),
        view_(MakeCameraView(camera_, kWidth, kHeight, offsets_.data())) {}
  bool plane() const { return HasPlaneFilm(camera_.kind); }
  Vec Axis(int i) const {
    const glm::vec4& v = camera_.world_from_camera[i];
    return {v.x, v.y, v.z};
  }
  std::vector<float> offsets_;
  Camera camera_;
  CameraView view_;
};

TEST_P(CameraConnections, RetraceCameraRays) {
  constexpr std::uint32_t n = kFullWave;
  soa::Table<PathColumns> paths(n);
  const auto film = RandomUniforms(n, 301);
  Connected c(n);
  Random random(302);
  for (std::uint32_t i = 0; i < n; ++i) {
    paths->pixel[i] = random.Word() % (kWidth * kHeight);
    c.lens->u[i] = random.Float(), c.lens->v[i] = random.Float();
  }
  soa::Table<RayColumns> rays(n);
  GenerateCameraRays(view_, paths, film, c.lens, n, rays);
  std::vector<double> distance(n);
  for (std::uint32_t i = 0; i < n; ++i) {
    distance[i] = random.Between(2, 9);
    const Vec org = Get(i, rays->org_x, rays->org_y, rays->org_z);
    const Vec dir = Get(i, rays->dir_x, rays->dir_y, rays->dir_z);
    Put(org + distance[i] * dir, i, c.points->org_x, c.points->org_y, c.points->org_z);
  }
  ConnectCamera(view_, c.points, c.lens, n, c.lights, c.cameras);
  std::uint32_t seen = 0;
  for (std::uint32_t i = 0; i < n; ++i) {
    if (rays->t_far[i] < 0) continue;  // outside the fisheye's circle
    ++seen;
    ASSERT_NEAR(c.lights->t_far[i], distance[i], 1e-5 * distance[i]) << "row " << i;
    const Vec dir = Get(i, rays->dir_x, rays->dir_y, rays->dir_z);
    ASSERT_LT(Length(Get(i, c.lights->dir_x, c.lights->dir_y, c.lights->dir_z) + dir), 5e-6);
    const double x = paths->pixel[i] % kWidth + double(film->u[i]);
    const double y = double(paths->pixel[i] / kWidth) + film->v[i];
    // Near a pole, a horizontal shift hardly changes the direction.
    const double across = camera_.kind == CameraKind::kLatLong ? std::sin(kPi * y / kHeight) : 1;
    ASSERT_NEAR((c.cameras->x[i] - x) * across, 0, 2e-3) << "row " << i;
    ASSERT_NEAR(c.cameras->y[i], y, 2e-3) << "row " << i;
  }
  EXPECT_GT(seen, n / 2);
}

TEST_P(CameraConnections, SeeNothingBehindThem) {
  if (!plane()) GTEST_SKIP();
  Connected c(3);
  const Vec origin = Axis(3), forward = Axis(2);
  Put(origin - 2 * forward, 0, c.points->org_x, c.points->org_y, c.points->org_z);
  Put(origin, 1, c.points->org_x, c.points->org_y, c.points->org_z);
  Put(origin + 2 * forward, 2, c.points->org_x, c.points->org_y, c.points->org_z);
  for (int i = 0; i < 3; ++i) c.lens->u[i] = c.lens->v[i] = 0.5f;
  ConnectCamera(view_, c.points, c.lens, 3, c.lights, c.cameras);
  EXPECT_LT(c.lights->t_far[0], 0);
  EXPECT_EQ(c.cameras->importance[0], 0);
  EXPECT_TRUE(std::isfinite(c.cameras->importance[1]));
  EXPECT_GT(c.lights->t_far[2], 0);
}

// Points on an area that covers the whole view must, weighted by importance and cosine, count the
// whole film exactly once.
TEST_P(CameraConnections, ImportanceIsPixelsOverArea) {
  constexpr std::uint32_t kPoints = 200000;
  Connected c(kPoints);
  Random random(311);
  const Vec origin = Axis(3), forward = Unit(Axis(2));
  const Vec s = Unit(Cross(forward, {0.2, 0.9, 0.1})), t = Cross(forward, s);
  constexpr double kRadius = 4, kSide = 32;  // the sphere's radius, or the side of a square across
                                             // the view
  std::vector<Vec> normals(kPoints);
  for (std::uint32_t i = 0; i < kPoints; ++i) {
    c.lens->u[i] = random.Float(), c.lens->v[i] = random.Float();
    Vec point;
    if (plane()) {
      // The square is tilted, so that its cosines differ from those of the axis.
      const Vec tilted = Unit(s + 0.3 * forward);
      normals[i] = Cross(tilted, t);
      point = origin + 7 * forward + random.Between(-0.5, 0.5) * kSide * tilted +
              random.Between(-0.5, 0.5) * kSide * t;
    } else {
      normals[i] = random.Direction();
      point = origin + kRadius * normals[i];
    }
    Put(point, i, c.points->org_x, c.points->org_y, c.points->org_z);
  }
  ConnectCamera(view_, c.points, c.lens, kPoints, c.lights, c.cameras);
  Moments sum;
  const double area = plane() ? kSide * kSide : 4 * kPi * kRadius * kRadius;
  for (std::uint32_t i = 0; i < kPoints; ++i) {
    const bool inside = c.lights->t_far[i] > 0 && c.cameras->x[i] >= 0 &&
                        c.cameras->x[i] < kWidth && c.cameras->y[i] >= 0 &&
                        c.cameras->y[i] < kHeight;
    const Vec dir = Get(i, c.lights->dir_x, c.lights->dir_y, c.lights->dir_z);
    sum.Add(inside ? area * c.cameras->importance[i] * std::fabs(Dot(dir, normals[i])) : 0);
  }
  double pixels = kWidth * kHeight;
  if (camera_.kind == CameraKind::kFisheye) pixels = kPi * 24 * 24;
  EXPECT_TRUE(AgreesWith(sum.mean(), sum.standard_error(), pixels, SidakLevel(std::size(kCases)),
                         1e-5 * pixels));
}

TEST_P(CameraConnections, BitsDoNotDependOnTargetOrNumberOfRows) {
  Connected c(kFullWave);
  Random random(321);
  for (std::uint32_t i = 0; i < kFullWave; ++i) {
    c.lens->u[i] = random.Float(), c.lens->v[i] = random.Float();
    const Vec point = Axis(3) + 3 * Unit(Axis(2)) + 3 * random.Direction();
    Put(point, i, c.points->org_x, c.points->org_y, c.points->org_z);
  }
  const auto densities = FilterDensities(offsets_, 0.5f);
  const auto uniforms = RandomUniforms(kFullWave, 322);
  for (const std::uint32_t n : kRowCounts) {
    ExpectSameOnEveryTarget([&] {
      ConnectCamera(view_, c.points, c.lens, n, c.lights, c.cameras);
      ChoosePixels(view_, {densities.data(), 0.5f}, uniforms, n, c.lights, c.cameras);
      std::vector<std::uint32_t> bits;
      for (std::uint32_t i = 0; i < n; ++i) {
        if (c.lights->t_far[i] < 0) continue;
        for (const float f : {c.lights->dir_x[i], c.lights->t_far[i], c.cameras->x[i],
                              c.cameras->importance[i], c.cameras->weight[i]}) {
          bits.push_back(std::bit_cast<std::uint32_t>(f));
        }
        bits.push_back(c.cameras->pixel[i]);
      }
      return bits;
    });
  }
}

constexpr const char* kCaseNames[] = {"Perspective",      "ThinLens", "Orthographic",
                                      "OrthographicLens", "LatLong",  "EqualArea",
                                      "Fisheye"};
INSTANTIATE_TEST_SUITE_P(All, CameraConnections, testing::Range(std::size_t{0}, std::size(kCases)),
                         [](const testing::TestParamInfo<std::size_t>& row) {
                           return std::string(kCaseNames[row.param]);
                         });

struct FilterCase {
  PixelFilter filter;
  float radius;
};
const FilterCase kFilters[] = {{PixelFilter::kBox, 0.5f},
                               {PixelFilter::kBox, 2.0f},
                               {PixelFilter::kTriangle, 1.0f},
                               {PixelFilter::kGaussian, 1.5f},
                               {PixelFilter::kBlackmanHarris, 1.5f}};

// Returns the density of the offsets of camera rays by their own table, in the cell around
// `offset`.
double DensityOf(const std::vector<float>& offsets, double offset) {
  for (std::size_t k = 0; k + 1 < offsets.size(); ++k) {
    if (offset >= offsets[k] && offset < offsets[k + 1]) {
      return 1 / (double(kFilterCells) * (double(offsets[k + 1]) - offsets[k]));
    }
  }
  return 0;
}

TEST(FilterDensities, AreThoseOfTheOffsets) {
  for (const FilterCase& f : kFilters) {
    const auto offsets = FilterOffsets(f.filter, f.radius);
    const auto densities = FilterDensities(offsets, f.radius);
    double sum = 0, most = 0;
    for (const float d : densities) sum += d, most = std::max(most, double(d));
    const double cell = 2 * f.radius / kFilterCells;
    EXPECT_NEAR(sum * cell, 1, 1e-6);
    for (std::size_t i = 8; i < kFilterCells; i += 37) {
      const double offset = (double(i) + 0.5) * cell - f.radius;
      EXPECT_NEAR(densities[i], DensityOf(offsets, offset), 0.02 * most) << offset;
    }
  }
}

// For one film position and a regular grid of uniforms, every pixel receives its filter's weight
// there.
TEST(ChoosePixels, SharesASplatByTheFilters) {
  constexpr std::uint32_t kGrid = 128, n = kGrid * kGrid;
  Camera camera;
  for (const FilterCase& f : kFilters) {
    const auto offsets = FilterOffsets(f.filter, f.radius);
    const auto densities = FilterDensities(offsets, f.radius);
    const CameraView view = MakeCameraView(camera, 16, 12, offsets.data(), CropWindow{2, 1, 9, 8});
    for (const auto& [x, y] : {std::pair{6.3, 5.8}, {2.1, 1.2}, {10.9, 8.6}, {1.7, 9.4}}) {
      Connected c(n);
      soa::Table<UniformColumns> uniforms(n);
      for (std::uint32_t i = 0; i < n; ++i) {
        uniforms->u[i] = (float(i % kGrid) + 0.5f) / kGrid;
        uniforms->v[i] = (float(i / kGrid) + 0.5f) / kGrid;
        c.cameras->x[i] = float(x), c.cameras->y[i] = float(y), c.lights->t_far[i] = 1;
      }
      ChoosePixels(view, {densities.data(), f.radius}, uniforms, n, c.lights, c.cameras);
      std::vector<double> got(std::size_t(view.width) * view.height);
      for (std::uint32_t i = 0; i < n; ++i) {
        if (c.lights->t_far[i] < 0) continue;
        ASSERT_LT(c.cameras->pixel[i], got.size());
        got[c.cameras->pixel[i]] += c.cameras->weight[i] / double(n);
      }
      for (std::uint32_t row = 0; row < view.height; ++row) {
        for (std::uint32_t column = 0; column < view.width; ++column) {
          const double weight = DensityOf(offsets, x - (view.first_column + column + 0.5)) *
                                DensityOf(offsets, y - (view.first_row + row + 0.5));
          EXPECT_NEAR(got[row * view.width + column], weight, 0.03)
              << "pixel (" << column << ", " << row << "), radius " << f.radius;
        }
      }
    }
  }
}

// Uniform splats over the film and its surroundings must give a uniform picture, also at the edges
// of the film.
TEST(ChoosePixels, MakesEvenSplatsAnEvenPicture) {
  constexpr std::uint32_t n = 400000;
  constexpr int width = 12, height = 8;
  for (const CameraKind kind : kCameraKinds) {
    Camera camera;
    camera.kind = kind;
    const bool wraps = kind == CameraKind::kLatLong || kind == CameraKind::kEqualArea;
    const auto offsets = FilterOffsets(PixelFilter::kBlackmanHarris, 1.5f);
    const auto densities = FilterDensities(offsets, 1.5f);
    const CameraView view = MakeCameraView(camera, width, height, offsets.data());
    Connected c(n);
    Random random(331);
    const auto uniforms = RandomUniforms(n, 332);
    const double rim = wraps ? 0 : 2, area = (width + 2 * rim) * (height + 2 * rim);
    for (std::uint32_t i = 0; i < n; ++i) {
      c.cameras->x[i] = float(random.Between(-rim, width + rim));
      c.cameras->y[i] = float(random.Between(-rim, height + rim));
      c.lights->t_far[i] = 1;
    }
    ChoosePixels(view, {densities.data(), 1.5f}, uniforms, n, c.lights, c.cameras);
    std::vector<Moments> sums(width * height);
    std::vector<double> sum(width * height), squares(width * height);
    for (std::uint32_t i = 0; i < n; ++i) {
      if (c.lights->t_far[i] < 0) continue;
      sum[c.cameras->pixel[i]] += area * c.cameras->weight[i];
      squares[c.cameras->pixel[i]] += std::pow(area * c.cameras->weight[i], 2);
    }
    for (std::size_t pixel = 0; pixel < sum.size(); ++pixel) {
      const double mean = sum[pixel] / n;
      const double error = std::sqrt((squares[pixel] / n - mean * mean) / n);
      EXPECT_TRUE(AgreesWith(mean, error, 1, SidakLevel(5 * width * height)))
          << "camera " << int(kind) << ", pixel " << pixel;
    }
  }
}

}  // namespace
}  // namespace skywave
