// Compares cameras other than the pinhole with double arithmetic: thin lens, orthographic,
// spherical, screen windows and crops.
#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <cmath>

#include "kernels/camera.h"
#include "scene/builtin/builtin.h"
#include "tests/support/random_rows.h"
#include "tests/support/render_scenes.h"
#include "tests/support/statistics.h"
#include "tests/support/targets.h"
#include "wavefront/frame.h"
#include "wavefront/option_names.h"
#include "wavefront/render.h"

namespace skywave {
namespace {

Vec ToVec(const glm::vec4& v) { return {v.x, v.y, v.z}; }

// The columns of the camera's matrix.
struct Axes {
  Vec x, y, z, origin;
};
Axes AxesOf(const Camera& camera) {
  const glm::mat4& m = camera.world_from_camera;
  return {ToVec(m[0]), ToVec(m[1]), ToVec(m[2]), ToVec(m[3])};
}

// Returns an oblique, left-handed and scaled camera, as pbrt files may define it.
Camera ObliqueCamera(CameraKind kind, float scale) {
  Camera camera = LookAtCamera({1, 2, 3}, {-4, 1.5f, 8}, {0.1f, 1, 0.2f}, 37, true);
  camera.kind = kind;
  for (int i = 0; i < 3; ++i) camera.world_from_camera[i] *= scale;
  return camera;
}

// Rays through random film positions, drawn by a box filter with a radius of `radius` pixels.
struct CameraRays {
  CameraRays(const CameraView& view, float radius, std::uint32_t n, std::uint32_t seed)
      : paths(n), film(RandomUniforms(n, seed)), lens(RandomUniforms(n, seed + 1)), rays(n) {
    Random random(seed + 2);
    for (std::uint32_t i = 0; i < n; ++i) {
      // The film stores whole blocks, and some of their pixels are not in the picture.
      const std::uint32_t pixel = random.Word() % (view.whole_width * view.whole_height);
      paths->pixel[i] = pixel / view.whole_width * view.width + pixel % view.whole_width;
      x.push_back(paths->pixel[i] % view.width + 0.5 + radius * (2 * double(film->u[i]) - 1));
      y.push_back(paths->pixel[i] / view.width + 0.5 + radius * (2 * double(film->v[i]) - 1));
    }
    GenerateCameraRays(view, paths, film, lens, n, rays);
  }
  Vec Origin(std::uint32_t i) const { return Get(i, rays->org_x, rays->org_y, rays->org_z); }
  Vec Direction(std::uint32_t i) const { return Get(i, rays->dir_x, rays->dir_y, rays->dir_z); }

  soa::Table<PathColumns> paths;
  soa::Table<UniformColumns> film, lens;
  soa::Table<RayColumns> rays;
  std::vector<double> x, y;  // on the film [pixels]
};

// Computes Shirley and Chiu's map in its original form, in polar coordinates.
void Disc(double u, double v, double& x, double& y) {
  const double a = 2 * u - 1, b = 2 * v - 1;
  if (a == 0 && b == 0) {
    x = y = 0;
    return;
  }
  const double r = std::fabs(a) > std::fabs(b) ? a : b;
  const double phi = std::fabs(a) > std::fabs(b) ? kPi / 4 * b / a : kPi / 2 - kPi / 4 * a / b;
  x = r * std::cos(phi), y = r * std::sin(phi);
}

double DistanceToRay(Vec origin, Vec direction, Vec point) {
  return Length(Cross(Unit(direction), point - origin));
}

TEST(Lens, RaysStartOnItAndConvergeInTheFocalPlane) {
  const auto box = FilterOffsets(PixelFilter::kBox, 0.5f);
  constexpr int kWidth = 64, kHeight = 48;
  for (const CameraKind kind : {CameraKind::kPerspective, CameraKind::kOrthographic}) {
    for (const float scale : {1.0f, 2.5f}) {
      Camera camera = ObliqueCamera(kind, scale);
      camera.lens_radius = 0.25f;
      camera.focal_distance = 3;
      const Axes c = AxesOf(camera);
      const CameraView view = MakeCameraView(camera, kWidth, kHeight, box.data());
      ASSERT_TRUE(view.has_lens());
      const CameraRays r(view, 0.5f, kFullWave, 91);
      const bool perspective = kind == CameraKind::kPerspective;
      const double pixel =
          (perspective ? 2 * std::tan(37 * kPi / 360) : 2.0) / std::min(kWidth, kHeight);
      double farthest = 0;
      for (std::uint32_t i = 0; i < kFullWave; ++i) {
        const double sx = (r.x[i] - kWidth / 2.0) * pixel, sy = (kHeight / 2.0 - r.y[i]) * pixel;
        double lx = 0, ly = 0;
        Disc(r.lens->u[i], r.lens->v[i], lx, ly);
        const Vec shift = 0.25 * lx * c.x + 0.25 * ly * c.y;
        const Vec screen = sx * c.x + sy * c.y;
        const Vec start = perspective ? c.origin : c.origin + screen;
        const Vec sharp = perspective ? c.origin + 3 * (screen + c.z) : start + 3 * c.z;
        ASSERT_LT(Length(r.Origin(i) - (start + shift)), 2e-6 * scale) << "row " << i;
        ASSERT_LT(DistanceToRay(r.Origin(i), r.Direction(i), sharp), 2e-5 * scale) << "row " << i;
        ASSERT_GT(Dot(r.Direction(i), c.z), 0);
        ASSERT_NEAR(Length(r.Direction(i)), 1, 1e-6);
        farthest = std::max(farthest, std::hypot(lx, ly));
      }
      EXPECT_GT(farthest, 0.99);
      EXPECT_LE(farthest, 1 + 1e-9);
    }
  }
}

TEST(Lens, PointsAreEvenOnTheDisc) {
  constexpr std::uint32_t kSamples = 100000;
  constexpr int kRings = 8, kSectors = 12;
  Camera camera;  // at the origin, along z
  camera.lens_radius = 2;
  const auto none = FilterOffsets(PixelFilter::kBox, 0.5f);
  const CameraRays r(MakeCameraView(camera, 1, 1, none.data()), 0.5f, kSamples, 95);
  std::vector<double> observed(kRings * kSectors);
  const std::vector<double> expected(kRings * kSectors, double(kSamples) / (kRings * kSectors));
  for (std::uint32_t i = 0; i < kSamples; ++i) {
    const Vec p = 0.5 * r.Origin(i);
    const double area = p.x * p.x + p.y * p.y, turn = std::atan2(p.y, p.x) / (2 * kPi) + 0.5;
    const int ring = std::min(int(area * kRings), kRings - 1);
    ++observed[ring * kSectors + std::min(int(turn * kSectors), kSectors - 1)];
  }
  EXPECT_TRUE(MatchesExpected(observed, expected, SidakLevel(1)));
}

TEST(Lens, WithoutRadiusTheLensUniformsAreNotRead) {
  const auto box = FilterOffsets(PixelFilter::kBox, 0.5f);
  for (const CameraKind kind : kCameraKinds) {
    const CameraView view = MakeCameraView(ObliqueCamera(kind, 1), 64, 48, box.data());
    CameraRays r(view, 0.5f, kFullWave, 101);
    soa::Table<RayColumns> again(kFullWave);
    FillWithGarbage(r.lens.columns(), kFullWave);
    GenerateCameraRays(view, r.paths, r.film, r.lens, kFullWave, again);
    EXPECT_EQ(ColumnBits(again.columns(), kFullWave), ColumnBits(r.rays.columns(), kFullWave));
  }
}

TEST(Orthographic, RaysAreParallelAndEvenlySpaced) {
  const auto box = FilterOffsets(PixelFilter::kBox, 0.5f);
  for (const auto& [width, height] : {std::pair{64, 48}, {48, 64}, {1, 1}}) {
    const Camera camera = ObliqueCamera(CameraKind::kOrthographic, 2.5f);
    const Axes c = AxesOf(camera);
    const CameraRays r(MakeCameraView(camera, width, height, box.data()), 0.5f, kFullWave, 111);
    const double pixel = 2.0 / std::min(width, height);
    for (std::uint32_t i = 0; i < kFullWave; ++i) {
      const Vec start =
          c.origin + (r.x[i] - width / 2.0) * pixel * c.x + (height / 2.0 - r.y[i]) * pixel * c.y;
      ASSERT_LT(Length(r.Origin(i) - start), 5e-6) << "row " << i;
      ASSERT_LT(Angle(r.Direction(i), c.z), 1e-6);
    }
  }
}

TEST(LatLong, MatchesDoubleArithmeticAndWraps) {
  // A filter of three pixels extends over all four sides of so small a film.
  const auto wide = FilterOffsets(PixelFilter::kBox, 3.0f);
  for (const auto& [width, height] : {std::pair{8, 4}, {512, 256}, {3, 7}}) {
    const Camera camera = ObliqueCamera(CameraKind::kLatLong, 2.5f);
    const Axes c = AxesOf(camera);
    const CameraRays r(MakeCameraView(camera, width, height, wide.data()), 3, kFullWave, 121);
    for (std::uint32_t i = 0; i < kFullWave; ++i) {
      const double theta = kPi * r.y[i] / height, phi = 2 * kPi * (r.x[i] / width - 0.5);
      const Vec exact = std::sin(theta) * std::sin(phi) * c.x + std::cos(theta) * c.y +
                        std::sin(theta) * std::cos(phi) * c.z;
      ASSERT_LT(Angle(r.Direction(i), exact), 3e-6) << "row " << i;
      ASSERT_LT(Length(r.Origin(i) - c.origin), 1e-9);
      ASSERT_NEAR(Length(r.Direction(i)), 1, 1e-6);
    }
  }
}

// Maps a direction (in camera space) to the square by inverting Clarberg's map through the angle.
void SquareOf(Vec d, double& u, double& v) {
  const double r = std::sqrt(1 - std::fabs(d.y));  // y is the axis through the centre
  const double angle = std::atan2(std::fabs(d.z), std::fabs(d.x)) * 2 / kPi;
  double b = angle * r, a = r - b;
  if (d.y < 0) {
    std::swap(a, b);
    a = 1 - a, b = 1 - b;
  }
  u = (std::copysign(a, d.x) + 1) / 2, v = (std::copysign(b, d.z) + 1) / 2;
}

TEST(EqualArea, InvertsTheMapToTheSquare) {
  const auto box = FilterOffsets(PixelFilter::kBox, 0.5f);
  for (const int side : {1, 2, 64, 257}) {
    const Camera camera = ObliqueCamera(CameraKind::kEqualArea, 2.5f);
    const Axes c = AxesOf(camera);
    const CameraRays r(MakeCameraView(camera, side, side, box.data()), 0.5f, kFullWave, 131);
    for (std::uint32_t i = 0; i < kFullWave; ++i) {
      const Vec d = Unit(r.Direction(i));
      double u = 0, v = 0;
      SquareOf({Dot(d, Unit(c.x)), Dot(d, Unit(c.y)), Dot(d, Unit(c.z))}, u, v);
      // Near the centre of the square an error of the direction is amplified by the root of 1 -
      // |y|.
      ASSERT_NEAR(u, r.x[i] / side, 1e-3) << "row " << i;
      ASSERT_NEAR(v, r.y[i] / side, 1e-3) << "row " << i;
    }
  }
}

TEST(EqualArea, IsContinuousAcrossTheSidesOfTheSquare) {
  // Positions that a filter draws outside, paired with the equivalent ones inside.
  const std::array<double, 4> pairs[] = {
      {-0.1, 0.3, 0.1, 0.7}, {1.1, 0.3, 0.9, 0.7}, {0.3, -0.1, 0.7, 0.1}, {0.3, 1.1, 0.7, 0.9}};
  for (const auto& p : pairs) {
    Vec directions[2];
    for (int k = 0; k < 2; ++k) {
      // On a film of one pixel, the offset from its centre is the position.
      std::vector<float> offsets(kFilterCells + 1);
      Camera camera;
      camera.kind = CameraKind::kEqualArea;
      // u = 0 reads the first entry, v = 1/2 the middle one.
      offsets[0] = offsets[1] = float(p[2 * k] - 0.5);
      offsets[kFilterCells / 2] = offsets[kFilterCells / 2 + 1] = float(p[2 * k + 1] - 0.5);
      soa::Table<PathColumns> paths(1);
      soa::Table<UniformColumns> film(1);
      soa::Table<RayColumns> rays(1);
      paths->pixel[0] = 0;
      film->u[0] = 0, film->v[0] = 0.5f;
      GenerateCameraRays(MakeCameraView(camera, 1, 1, offsets.data()), paths, film, film, 1, rays);
      directions[k] = Get(0, rays->dir_x, rays->dir_y, rays->dir_z);
    }
    EXPECT_LT(Angle(directions[0], directions[1]), 1e-5);
  }
}

TEST(EqualArea, EveryPixelHasTheSameSolidAngle) {
  constexpr std::uint32_t kSamples = 100000;
  constexpr int kRings = 8, kSectors = 12;
  Camera camera;
  camera.kind = CameraKind::kEqualArea;
  const auto box = FilterOffsets(PixelFilter::kBox, 0.5f);
  const CameraRays r(MakeCameraView(camera, 16, 16, box.data()), 0.5f, kSamples, 141);
  std::vector<double> observed(kRings * kSectors);
  const std::vector<double> expected(kRings * kSectors, double(kSamples) / (kRings * kSectors));
  for (std::uint32_t i = 0; i < kSamples; ++i) {
    const Vec d = r.Direction(i);
    const int ring = std::min(int((d.y + 1) / 2 * kRings), kRings - 1);
    const double turn = std::atan2(d.z, d.x) / (2 * kPi) + 0.5;
    ++observed[ring * kSectors + std::min(int(turn * kSectors), kSectors - 1)];
  }
  EXPECT_TRUE(MatchesExpected(observed, expected, SidakLevel(1)));
}

TEST(Fisheye, AngleGrowsWithTheDistanceFromTheMiddle) {
  // A filter of two pixels draws positions on both sides of the circle.
  const auto wide = FilterOffsets(PixelFilter::kBox, 2.0f);
  for (const float fov : {20.0f, 180.0f, 360.0f}) {
    for (const auto& [width, height] : {std::pair{64, 48}, {48, 64}, {7, 7}}) {
      Camera camera = ObliqueCamera(CameraKind::kFisheye, 2.5f);
      camera.fov_degrees = fov;
      const Axes c = AxesOf(camera);
      const CameraRays r(MakeCameraView(camera, width, height, wide.data()), 2, kFullWave, 191);
      int seen = 0;
      for (std::uint32_t i = 0; i < kFullWave; ++i) {
        const double dx = r.x[i] - width / 2.0, dy = r.y[i] - height / 2.0;
        const double radius = std::hypot(dx, dy), rim = std::min(width, height) / 2.0;
        ASSERT_NEAR(Length(r.Direction(i)), 1, 1e-6);
        ASSERT_LT(Length(r.Origin(i) - c.origin), 1e-9);
        if (std::fabs(radius - rim) < 1e-4) continue;
        const bool inside = radius < rim;
        ASSERT_EQ(r.rays->throughput_g[i], inside ? 1 : 0) << "row " << i;
        ASSERT_EQ(r.rays->t_far[i] >= 0, inside) << "row " << i;
        if (!inside) continue;
        const double theta = radius / rim * fov * kPi / 360;
        const Vec exact = std::cos(theta) * Unit(c.z) + std::sin(theta) * dx / radius * Unit(c.x) -
                          std::sin(theta) * dy / radius * Unit(c.y);
        ASSERT_LT(Angle(r.Direction(i), exact), 3e-6) << "row " << i;
        ++seen;
      }
      EXPECT_GT(seen, int(kFullWave) / 3);
      EXPECT_LT(seen, int(kFullWave));
    }
  }
}

TEST(Fisheye, TheMiddleOfTheFilmLooksAhead) {
  std::vector<float> none(kFilterCells + 1);  // a filter without width
  const Camera camera = ObliqueCamera(CameraKind::kFisheye, 1);
  const CameraRays r(MakeCameraView(camera, 1, 1, none.data()), 0, 1, 193);
  EXPECT_LT(Angle(r.Direction(0), AxesOf(camera).z), 1e-6);
}

// Rays outside the circle are closed: no backend finds a surface for them, and they see no
// environment.
TEST(Fisheye, SeesNothingOutsideOfItsCircle) {
  for (const char* const name : {"furnace", "gallery"}) {
    JobRequest request = SmallRequest(24, 16, 4);
    request.camera.kind = CameraKind::kFisheye;
    request.camera.fov_degrees = 360;
    request.filter = PixelFilter::kBox;
    for (const std::uint32_t max_depth : {0u, 3u}) {
      request.max_depth = max_depth;
      const RenderJob job(BuiltinScene(name), request);
      std::vector<float> first;
      for (const Backend backend : kBackends) {
        FrameView frame = job.frame();
        frame.tracer.closest = frame.tracer.occlusion = backend;
        Film film = job.MakeFilm();
        RenderFrame(frame, film);
        const Image image = film.Resolve(4);
        for (int y = 0; y < 16; ++y) {
          for (int x = 0; x < 24; ++x) {
            const double radius = std::hypot(x + 0.5 - 12, y + 0.5 - 8);
            const float red = image.Pixel(x, y)[0];
            ASSERT_TRUE(radius <= 8.8 || red == 0) << x << ", " << y;
            ASSERT_TRUE(radius >= 7.2 || max_depth == 0 || red > 0) << x << ", " << y;
          }
        }
        if (first.empty()) first = image.rgb;
        EXPECT_EQ(image.rgb, first) << ToString(backend);
      }
    }
  }
}

// The rays of a pixel and of its neighbours span an area: that of a square of the size returned,
// where pixels are not slanted.
TEST(PixelSize, IsTheSideOfWhatAPixelCovers) {
  const std::vector<float> none(kFilterCells + 1);  // rays go through the middles of pixels
  struct Row {
    CameraKind kind;
    int width, height;
  };
  // Pixels of a map of the sphere are squares in the middle if it has this shape.
  for (const Row& row : {Row{CameraKind::kPerspective, 640, 480},
                         {CameraKind::kOrthographic, 480, 640},
                         {CameraKind::kLatLong, 1024, 512},
                         {CameraKind::kEqualArea, 512, 512},
                         {CameraKind::kFisheye, 640, 480}}) {
    for (const float scale : {1.0f, 2.5f}) {
      SCOPED_TRACE(std::string(ToString(row.kind)) + " " + std::to_string(scale));
      Camera camera = ObliqueCamera(row.kind, scale);
      if (row.kind == CameraKind::kFisheye) camera.fov_degrees = 200;
      const CameraView view = MakeCameraView(camera, row.width, row.height, none.data());
      // In the middle of the square rays on both sides of a diagonal belong to different formulae.
      const bool square = row.kind == CameraKind::kEqualArea;
      const auto column = std::uint32_t(square ? 0.7 * row.width : row.width / 2);
      const std::uint32_t pixel = std::uint32_t(row.height / 2) * view.width + column;
      soa::Table<PathColumns> paths(3);
      paths->pixel[0] = pixel, paths->pixel[1] = pixel + 1, paths->pixel[2] = pixel + view.width;
      const soa::Table<UniformColumns> uniforms(3);
      soa::Table<RayColumns> rays(3);
      GenerateCameraRays(view, paths, uniforms, uniforms, 3, rays);
      for (const float distance : {0.5f, 20.0f}) {
        const auto point = [&](std::uint32_t i) {
          return Get(i, rays->org_x, rays->org_y, rays->org_z) +
                 double(distance) * Get(i, rays->dir_x, rays->dir_y, rays->dir_z);
        };
        const double area = Length(Cross(point(1) - point(0), point(2) - point(0)));
        EXPECT_NEAR(double(PixelSize(view, distance)) / std::sqrt(area), 1, 5e-3) << distance;
        // Where it does not depend on the distance, textures are looked up by the angle alone.
        if (row.kind == CameraKind::kPerspective || row.kind == CameraKind::kFisheye) {
          EXPECT_NEAR(double(PixelAngle(view)) * double(distance) / std::sqrt(area), 1, 5e-3);
        }
      }
    }
  }
}

TEST(ScreenWindow, IsWhatTheFilmShows) {
  const auto box = FilterOffsets(PixelFilter::kBox, 0.5f);
  for (const CameraKind kind : {CameraKind::kPerspective, CameraKind::kOrthographic}) {
    Camera camera = ObliqueCamera(kind, 1);
    camera.window = ScreenWindow{-0.5f, 2, -1, 0.25f};
    const Axes c = AxesOf(camera);
    const CameraRays r(MakeCameraView(camera, 40, 10, box.data()), 0.5f, kFullWave, 151);
    const double unit = kind == CameraKind::kPerspective ? std::tan(37 * kPi / 360) : 1;
    for (std::uint32_t i = 0; i < kFullWave; ++i) {
      const double sx = unit * (-0.5 + 2.5 * r.x[i] / 40), sy = unit * (0.25 - 1.25 * r.y[i] / 10);
      const Vec screen = sx * c.x + sy * c.y;
      if (kind == CameraKind::kPerspective) {
        ASSERT_LT(Angle(r.Direction(i), screen + c.z), 2e-6);
      } else {
        ASSERT_LT(Length(r.Origin(i) - (c.origin + screen)), 3e-6);
      }
    }
  }
  // The default, [-1, 1] on the shorter side, must equal the same explicit window.
  Camera camera = ObliqueCamera(CameraKind::kPerspective, 1);
  const CameraRays plain(MakeCameraView(camera, 64, 48, box.data()), 0.5f, 100, 161);
  camera.window = ScreenWindow{-4.0f / 3, 4.0f / 3, -1, 1};
  const CameraRays said(MakeCameraView(camera, 64, 48, box.data()), 0.5f, 100, 161);
  for (std::uint32_t i = 0; i < 100; ++i) {
    ASSERT_LT(Angle(plain.Direction(i), said.Direction(i)), 1e-6);
  }
}

TEST(Crop, RaysAreThoseOfTheWholeFilm) {
  const auto offsets = FilterOffsets(PixelFilter::kGaussian, 1.5f);
  constexpr CropWindow kPart = {7, 5, 20, 9};
  constexpr std::uint32_t kPixels = kPart.width * kPart.height;
  for (const CameraKind kind : kCameraKinds) {
    const Camera camera = ObliqueCamera(kind, 1);
    const CameraView whole = MakeCameraView(camera, 64, 48, offsets.data());
    const CameraView part = MakeCameraView(camera, 64, 48, offsets.data(), kPart);
    const auto film = RandomUniforms(kPixels, 171);
    soa::Table<PathColumns> of_whole(kPixels), of_part(kPixels);
    for (std::uint32_t i = 0; i < kPixels; ++i) {
      const std::uint32_t x = kPart.x + i % kPart.width, y = kPart.y + i / kPart.width;
      of_part->pixel[i] = (y - part.first_row) * part.width + x - part.first_column;
      of_whole->pixel[i] = y * whole.width + x;
    }
    soa::Table<RayColumns> a(kPixels), b(kPixels);
    GenerateCameraRays(whole, of_whole, film, film, kPixels, a);
    GenerateCameraRays(part, of_part, film, film, kPixels, b);
    EXPECT_EQ(ColumnBits(a.columns(), kPixels), ColumnBits(b.columns(), kPixels));
  }
}

TEST(CameraKinds, BitsDoNotDependOnTargetOrNumberOfRows) {
  const auto offsets = FilterOffsets(PixelFilter::kBlackmanHarris, 1.5f);
  for (const CameraKind kind : kCameraKinds) {
    Camera camera = ObliqueCamera(kind, 1);
    camera.lens_radius = 0.1f, camera.focal_distance = 4;
    const CameraView view = MakeCameraView(camera, 31, 33, offsets.data());
    const CameraRays full(view, 1.5f, kFullWave, 181);
    ForEachTarget([&] {
      for (const std::uint32_t n : kRowCounts) {
        soa::Table<RayColumns> rays(kFullWave);
        GenerateCameraRays(view, full.paths, full.film, full.lens, n, rays);
        EXPECT_EQ(ColumnBits(rays.columns(), n), ColumnBits(full.rays.columns(), n))
            << "kind " << int(kind) << ", " << n << " rows";
      }
    });
  }
}

}  // namespace
}  // namespace skywave
