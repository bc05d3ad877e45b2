// Tests every projection in both directions, the positions of the six axes, solid angles, and
// conversions that conserve light.
#include "lights/maps/projections.h"

#include <gtest/gtest.h>

#include <cmath>
#include <numbers>
#include <random>
#include <string>

#include "base/error.h"
#include "lights/maps/resample.h"
#include "lights/maps/sphere_map.h"
#include "tests/support/light_test_maps.h"

namespace skywave {
namespace {

constexpr double kPi = std::numbers::pi;

std::string Name(Projection projection) { return std::string(ToString(projection)); }

// A smooth environment with three different channels, and a picture of it.
std::array<double, 3> Environment(const Vector3& d) {
  return {2 + d.x + d.y * d.z, 1.5 + d.y, 2 + std::cos(3 * d.z) + d.x * d.y};
}
Image Paint(Projection projection, int width, int height) {
  Image image(width, height);
  for (int y = 0; y < height; ++y) {
    for (int x = 0; x < width; ++x) {
      const auto d = DirectionOfPoint(projection, {(x + 0.5) / width, (y + 0.5) / height});
      for (int c = 0; c < 3; ++c) image.Pixel(x, y)[c] = d ? float(Environment(*d)[c]) : 1e9f;
    }
  }
  return image;
}

TEST(Projections, NamesAndValuesBelongTogether) {
  int index = 0;
  for (Projection projection : ValuesOf<Projection>()) {
    EXPECT_EQ(int(projection), index++);
    EXPECT_EQ(Parse<Projection>(ToString(projection)), projection);
  }
  EXPECT_EQ(index, 8);
  EXPECT_FALSE(Parse<Projection>("latlon"));
}

TEST(Projections, DirectionsComeBack) {
  std::mt19937 random(1);
  for (Projection projection : ValuesOf<Projection>()) {
    for (int i = 0; i < 20000; ++i) {
      const Vector3 d = test::RandomDirection(random);
      const ImagePoint point = PointOfDirection(projection, d);
      ASSERT_TRUE(point.u >= 0 && point.u <= 1 && point.v >= 0 && point.v <= 1);
      const auto back = DirectionOfPoint(projection, point);
      ASSERT_TRUE(back) << Name(projection);
      ASSERT_LT(AngleBetween(d, *back), 1e-7)
          << Name(projection) << d.x << " " << d.y << " " << d.z;
    }
  }
}

TEST(Projections, PointsComeBack) {
  std::mt19937 random(2);
  std::uniform_real_distribution<double> uniform;
  for (Projection projection : ValuesOf<Projection>()) {
    int lit = 0;
    for (int i = 0; i < 20000; ++i) {
      const ImagePoint point = {uniform(random), uniform(random)};
      const auto d = DirectionOfPoint(projection, point);
      EXPECT_EQ(d.has_value(), SolidAngleDensity(projection, point) > 0);
      if (!d) continue;
      ++lit;
      ASSERT_NEAR(Length(*d), 1, 1e-12);
      const ImagePoint back = PointOfDirection(projection, *d);
      ASSERT_NEAR(back.u, point.u, 1e-7) << Name(projection);
      ASSERT_NEAR(back.v, point.v, 1e-7) << Name(projection);
    }
    const double share =
        projection == Projection::kAngular || projection == Projection::kMirrorBall ? kPi / 4
        : projection == Projection::kHorizontalCross || projection == Projection::kVerticalCross
            ? 0.5
            : 1;
    EXPECT_NEAR(lit / 20000.0, share, 0.02) << Name(projection);
  }
}

// The documented convention (docs/probe.md) lists right, left, forward, back, up, down.
TEST(Projections, AxesLandAtTheDocumentedPlaces) {
  const Vector3 axes[6] = {{1, 0, 0}, {-1, 0, 0}, {0, 1, 0}, {0, -1, 0}, {0, 0, 1}, {0, 0, -1}};
  struct Expected {
    Projection projection;
    ImagePoint point[6];
  };
  const double r = std::sqrt(0.5) / 2;
  const Expected table[] = {
      {Projection::kLatLong, {{.75, .5}, {.25, .5}, {.5, .5}, {0, .5}, {.5, 0}, {.5, 1}}},
      {Projection::kAngular, {{.75, .5}, {.25, .5}, {.5, .5}, {1, .5}, {.5, .25}, {.5, .75}}},
      {Projection::kMirrorBall,
       {{.5 + r, .5}, {.5 - r, .5}, {1, .5}, {.5, .5}, {.5, .5 - r}, {.5, .5 + r}}},
      {Projection::kHorizontalCross,
       {{2.5 / 4, .5},
        {.5 / 4, .5},
        {1.5 / 4, .5},
        {3.5 / 4, .5},
        {1.5 / 4, .5 / 3},
        {1.5 / 4, 2.5 / 3}}},
      {Projection::kVerticalCross,
       {{2.5 / 3, 1.5 / 4},
        {.5 / 3, 1.5 / 4},
        {.5, 1.5 / 4},
        {.5, 3.5 / 4},
        {.5, .5 / 4},
        {.5, 2.5 / 4}}},
      {Projection::kCubeStrip,
       {{.5 / 6, .5}, {1.5 / 6, .5}, {4.5 / 6, .5}, {5.5 / 6, .5}, {2.5 / 6, .5}, {3.5 / 6, .5}}},
      {Projection::kCubeColumn,
       {{.5, 1.5 / 6}, {.5, .5 / 6}, {.5, 4.5 / 6}, {.5, 5.5 / 6}, {.5, 2.5 / 6}, {.5, 3.5 / 6}}},
      {Projection::kOctahedral, {{.5, 0}, {.5, 1}, {0, .5}, {1, .5}, {.5, .5}, {0, 0}}},
  };
  for (const Expected& expected : table) {
    for (int i = 0; i < 6; ++i) {
      const ImagePoint point = PointOfDirection(expected.projection, axes[i]);
      const bool down_corner = expected.projection == Projection::kOctahedral && i == 5;
      if (down_corner) {  // any corner will do
        EXPECT_NEAR(std::abs(point.u - 0.5), 0.5, 1e-12);
        EXPECT_NEAR(std::abs(point.v - 0.5), 0.5, 1e-12);
        continue;
      }
      EXPECT_NEAR(point.v, expected.point[i].v, 1e-12)
          << Name(expected.projection) << " axis " << i;
      if (expected.projection == Projection::kLatLong && i >= 4) continue;  // a pole has every u
      EXPECT_NEAR(point.u, expected.point[i].u, 1e-12)
          << Name(expected.projection) << " axis " << i;
    }
  }
}

// Seen from inside, a step to the image's right and a step down have the same orientation in all
// projections except two.
TEST(Projections, OnlyBallAndSquareAreMirrored) {
  std::mt19937 random(3);
  std::uniform_real_distribution<double> uniform(0.02, 0.98);
  for (Projection projection : ValuesOf<Projection>()) {
    for (int i = 0; i < 2000; ++i) {
      const ImagePoint point = {uniform(random), uniform(random)};
      const double step = 1e-6;
      const auto d = DirectionOfPoint(projection, point);
      const auto right = DirectionOfPoint(projection, {point.u + step, point.v});
      const auto down = DirectionOfPoint(projection, {point.u, point.v + step});
      if (!d || !right || !down) continue;
      double side = Dot(Cross(*right - *d, *down - *d), *d);
      if (projection == Projection::kMirrorBall || projection == Projection::kOctahedral) {
        side = -side;  // the ball is a reflection, and the square follows pbrt
      }
      // Right x down points away from the eye, along the view.
      ASSERT_GT(side, 0) << Name(projection) << " " << point.u << " " << point.v;
      ASSERT_NEAR(side / (step * step) / SolidAngleDensity(projection, point), 1, 0.01)
          << Name(projection);
    }
  }
}

// Compares the octahedral square with the formulae of pbrt-v4's lat-long converter: phi = atan2(y,
// x) from 0, theta from +z, in its light space.
TEST(Projections, OctahedralIsWhatPbrtMakesOfALatLong) {
  std::mt19937 random(4);
  std::uniform_real_distribution<double> uniform;
  for (int i = 0; i < 1000; ++i) {
    const ImagePoint point = {uniform(random), uniform(random)};
    const double u = 2 * point.u - 1, v = 2 * point.v - 1;
    const double distance = 1 - std::abs(u) - std::abs(v), r = 1 - std::abs(distance);
    const double phi = ((std::abs(v) - std::abs(u)) / r + 1) * kPi / 4;
    const double x = std::copysign(std::cos(phi), u), y = std::copysign(std::sin(phi), v);
    const double z = std::copysign(1 - r * r, distance);
    double azimuth = std::atan2(y, x);
    if (azimuth < 0) azimuth += 2 * kPi;
    const ImagePoint latlong = {azimuth / (2 * kPi), std::acos(z) / kPi};
    const Vector3 expected = *DirectionOfPoint(Projection::kLatLong, latlong);
    EXPECT_LT(AngleBetween(expected, *DirectionOfPoint(Projection::kOctahedral, point)), 1e-6);
  }
}

// OpenEXR's cube has x to the left, y up and z forward. Its file has +x first, whose columns grow
// with z and whose rows fall with y; those of +y have x to the right and z up, and those of -y have
// z down (ImfEnvmap.h, CubeMap).
TEST(Projections, ColumnsOfFacesAreThoseOfOpenExr) {
  struct Point {
    Vector3 openexr;
    double u, v;  // within the face
    int face;     // from the top
  };
  const double a = 0.5, b = 0.25;
  for (const Point& p : {Point{{1, b, a}, 0.75, 0.375, 0},
                         {{-1, b, a}, 0.25, 0.375, 1},
                         {{a, 1, b}, 0.75, 0.375, 2},
                         {{a, -1, b}, 0.75, 0.625, 3},
                         {{a, b, 1}, 0.25, 0.375, 4},
                         {{a, b, -1}, 0.75, 0.375, 5}}) {
    const Vector3 d = {-p.openexr.x, p.openexr.z, p.openexr.y};
    const ImagePoint at = PointOfDirection(Projection::kCubeColumn, (1 / Length(d)) * d);
    EXPECT_NEAR(at.u, p.u, 1e-12) << p.face;
    EXPECT_NEAR(at.v, (p.face + p.v) / 6, 1e-12) << p.face;
  }
}

TEST(Projections, PixelsAddUpToTheSphere) {
  for (Projection projection : ValuesOf<Projection>()) {
    for (int scale : {1, 2, 7}) {
      int width = 12 * scale, height = 12 * scale;
      if (projection == Projection::kHorizontalCross) height = width / 4 * 3;
      if (projection == Projection::kVerticalCross) height = width / 3 * 4;
      if (projection == Projection::kCubeStrip) height = width / 6;
      if (projection == Projection::kCubeColumn) height = 6 * width;
      double sum = 0;
      for (int y = 0; y < height; ++y) {
        for (int x = 0; x < width; ++x) sum += PixelSolidAngle(projection, width, height, x, y);
      }
      EXPECT_NEAR(sum / (4 * kPi), 1, scale < 7 ? 2e-4 : 5e-5) << Name(projection) << scale;
    }
  }
}

TEST(Resample, BetweenAllProjectionsTheEnvironmentStaysTheSame) {
  for (Projection from : ValuesOf<Projection>()) {
    int width, height;
    DefaultSize(from, 96, width, height);
    const Image image = Paint(from, width, height);
    const auto energy = SphereIntegral(image, from);
    for (Projection to : ValuesOf<Projection>()) {
      int to_width, to_height;
      DefaultSize(to, 64, to_width, to_height);
      const Image result = Resample(image, from, to, to_width, to_height);
      const auto kept = SphereIntegral(result, to);
      for (int c = 0; c < 3; ++c)
        EXPECT_NEAR(kept[c] / energy[c], 1, 1e-5) << Name(from) << Name(to);
      double squares = 0;
      int pixels = 0;
      for (int y = 0; y < to_height; ++y) {
        for (int x = 0; x < to_width; ++x) {
          const auto d = DirectionOfPoint(to, {(x + 0.5) / to_width, (y + 0.5) / to_height});
          if (!d) {
            if (PixelSolidAngle(to, to_width, to_height, x, y) == 0) {
              EXPECT_EQ(result.Pixel(x, y)[0], 0);
            }
            continue;
          }
          ++pixels;
          for (int c = 0; c < 3; ++c)
            squares += std::pow(result.Pixel(x, y)[c] - Environment(*d)[c], 2) / 3;
        }
      }
      // The mirror ball is coarse near its rim, which represents a single direction.
      const bool ball = from == Projection::kMirrorBall || to == Projection::kMirrorBall;
      EXPECT_LT(std::sqrt(squares / pixels), ball ? 0.04 : 0.012) << Name(from) << " " << Name(to);
    }
  }
}

// The solid angle of a triangle of the sphere (van Oosterom and Strackee 1983).
double TriangleSolidAngle(const Vector3& a, const Vector3& b, const Vector3& c) {
  return 2 * std::atan2(std::abs(Dot(a, Cross(b, c))), 1 + Dot(a, b) + Dot(b, c) + Dot(c, a));
}

// Returns the integral of a picture over the sphere by formulae of its own: of zones for lat-long
// maps, and of polygons for cubes, whose pixels have great circles as sides. Pixels of the square
// have equal parts.
std::array<double, 3> IntegralOf(const Image& image, Projection projection) {
  std::array<double, 3> sum = {};
  for (int y = 0; y < image.height; ++y) {
    for (int x = 0; x < image.width; ++x) {
      double solid_angle = 4 * kPi / (double(image.width) * image.height);
      if (projection == Projection::kLatLong) {
        const double top = std::cos(kPi * y / image.height);
        solid_angle = 2 * kPi / image.width * (top - std::cos(kPi * (y + 1) / image.height));
      } else if (projection != Projection::kOctahedral) {
        // Corners are approached from inside, because faces end there.
        std::array<Vector3, 4> corner;
        bool empty = false;
        for (int k = 0; k < 4; ++k) {
          const double right = k % 2 == 0 ? 1e-9 : 1 - 1e-9, down = k < 2 ? 1e-9 : 1 - 1e-9;
          const auto d =
              DirectionOfPoint(projection, {(x + right) / image.width, (y + down) / image.height});
          empty |= !d;
          if (d) corner[std::size_t(k)] = *d;
        }
        solid_angle = empty ? 0
                            : TriangleSolidAngle(corner[0], corner[1], corner[2]) +
                                  TriangleSolidAngle(corner[1], corner[2], corner[3]);
      }
      for (int c = 0; c < 3; ++c) sum[c] += solid_angle * double(image.Pixel(x, y)[c]);
    }
  }
  return sum;
}

// The promise of docs/probe.md, by an integral that the conversion does not scale by. The pixels of
// disks are cut by their rim, so what they hold is a matter of definition.
TEST(Resample, KeepsTheIntegralOverTheSphere) {
  for (Projection from : ValuesOf<Projection>()) {
    for (Projection to : ValuesOf<Projection>()) {
      const auto is_disk = [](Projection p) {
        return p == Projection::kAngular || p == Projection::kMirrorBall;
      };
      if (is_disk(from) || is_disk(to)) continue;
      int width, height, to_width, to_height;
      DefaultSize(from, 60, width, height), DefaultSize(to, 32, to_width, to_height);
      const Image image = Paint(from, width, height);
      const auto wanted = IntegralOf(image, from);
      // Of the environment itself.
      EXPECT_NEAR(wanted[0], 8 * kPi, 0.01) << Name(from);
      EXPECT_NEAR(wanted[2], 8 * kPi + 4 * kPi * std::sin(3) / 3, 0.01) << Name(from);
      const auto kept = IntegralOf(Resample(image, from, to, to_width, to_height), to);
      for (int c = 0; c < 3; ++c) {
        EXPECT_NEAR(kept[c] / wanted[c], 1, 1e-5) << Name(from) << " to " << Name(to);
      }
    }
  }
}

// Between the last pixels and a pole, and at the folded sides of the square, the picture goes on
// with the pixels that are next to them on the sphere.
TEST(Resample, GoesOnBeyondPolesAndSides) {
  for (const Projection from : {Projection::kLatLong, Projection::kOctahedral}) {
    int width, height, to_width, to_height;
    DefaultSize(from, 12, width, height);
    DefaultSize(Projection::kLatLong, 96, to_width, to_height);
    Image image(width, height);
    // Linear functions, of which interpolation loses little.
    for (int y = 0; y < height; ++y) {
      for (int x = 0; x < width; ++x) {
        const Vector3 d = *DirectionOfPoint(from, {(x + 0.5) / width, (y + 0.5) / height});
        image.Pixel(x, y)[0] = float(2 + d.x), image.Pixel(x, y)[1] = float(2 + d.y);
        image.Pixel(x, y)[2] = float(2 + d.z);
      }
    }
    const Image result = Resample(image, from, Projection::kLatLong, to_width, to_height);
    // Between rows and columns that are 15 degrees apart a cosine is off by 0.9 % at most, along
    // either. On the square, which goes from -1 to 1, slopes jump by up to 4 at the axes: a quarter
    // of that is lost over the side of a pixel.
    const double bound = from == Projection::kLatLong ? 0.02 : 2.0 / width;
    for (int y = 0; y < to_height; ++y) {
      for (int x = 0; x < to_width; ++x) {
        const Vector3 d =
            *DirectionOfPoint(Projection::kLatLong, {(x + 0.5) / to_width, (y + 0.5) / to_height});
        ASSERT_NEAR(result.Pixel(x, y)[0], 2 + d.x, bound) << Name(from) << x << "," << y;
        ASSERT_NEAR(result.Pixel(x, y)[1], 2 + d.y, bound) << Name(from) << x << "," << y;
        ASSERT_NEAR(result.Pixel(x, y)[2], 2 + d.z, bound) << Name(from) << x << "," << y;
      }
    }
  }
}

TEST(Resample, OddSizesAndSinglePixelsKeepLight) {
  for (const test::NamedMap& map : test::AdversarialMaps()) {
    const auto energy = SphereIntegral(map.image, Projection::kLatLong);
    for (Projection to : ValuesOf<Projection>()) {
      for (int size : {1, 5, 31}) {
        // All pixels of a small disk are cut by the rim, so only its middle is read.
        const bool disk = to == Projection::kAngular || to == Projection::kMirrorBall;
        if (disk && size < 31 && map.name == "one lit texel") continue;
        int width = size, height = size == 5 ? 3 : size;
        if (to == Projection::kHorizontalCross) width = 4 * size, height = 3 * size;
        if (to == Projection::kVerticalCross) width = 3 * size, height = 4 * size;
        if (to == Projection::kCubeStrip) width = 6 * size, height = size;
        if (to == Projection::kCubeColumn) width = size, height = 6 * size;
        const Image result = Resample(map.image, Projection::kLatLong, to, width, height);
        const auto kept = SphereIntegral(result, to);
        for (int c = 0; c < 3; ++c) {
          EXPECT_NEAR(kept[c], energy[c], 1e-5 * energy[c])
              << map.name << " to " << Name(to) << " " << width << " x " << height;
        }
        for (float value : result.rgb) ASSERT_TRUE(value >= 0 && std::isfinite(value)) << map.name;
      }
    }
  }
}

TEST(Resample, AConstantStaysConstant) {
  const Image image = test::ConstantMap(40, 20, 0.75f);
  for (Projection to : ValuesOf<Projection>()) {
    int width, height;
    DefaultSize(to, 32, width, height);
    const Image result = Resample(image, Projection::kLatLong, to, width, height);
    for (int y = 0; y < height; ++y) {
      for (int x = 0; x < width; ++x) {
        if (!DirectionOfPoint(to, {(x + 0.5) / width, (y + 0.5) / height})) continue;
        // Scaling the cut pixels of a disk to exact energy changes a constant by 1e-5.
        ASSERT_NEAR(result.Pixel(x, y)[1], 0.75, 3e-5) << Name(to);
      }
    }
  }
}

// Even before the final scaling, a sun must keep its position and nearly its brightness: its
// centroid and its share of the light.
TEST(Resample, ASunStaysInPlace) {
  const Image image = test::SunMap(256, 128, 1e4f);
  const SphereMap before = MakeSphereMap(image);
  const auto moment = [](const SphereMap& map) {
    Vector3 sum;
    for (int y = 0; y < map.height; ++y) {
      for (int x = 0; x < map.width; ++x) {
        sum += double(map.luminance[std::size_t(y) * map.width + x]) * map.DirectionIntegral(x, y);
      }
    }
    return sum;
  };
  for (Projection to : ValuesOf<Projection>()) {
    if (to == Projection::kLatLong) continue;
    int width, height;
    DefaultSize(to, 192, width, height);
    const Image there = Resample(image, Projection::kLatLong, to, width, height);
    const Image back = Resample(there, to, Projection::kLatLong, 256, 128);
    const SphereMap after = MakeSphereMap(back);
    EXPECT_NEAR(after.energy / before.energy, 1, 1e-5);
    const Vector3 change = moment(after) - moment(before);
    EXPECT_LT(Length(change), 0.01 * before.energy) << Name(to);
  }
}

TEST(Resample, TheSameProjectionAndSizeGiveACopy) {
  const Image image = test::NoiseMap(31, 17, 3);
  EXPECT_EQ(Resample(image, Projection::kLatLong, Projection::kLatLong, 31, 17).rgb, image.rgb);
}

TEST(Projections, CubesNeedSquareFaces) {
  EXPECT_NO_THROW(CheckProjectionSize(Projection::kHorizontalCross, 8, 6));
  EXPECT_THROW(CheckProjectionSize(Projection::kHorizontalCross, 8, 8), InputError);
  EXPECT_THROW(CheckProjectionSize(Projection::kVerticalCross, 8, 6), InputError);
  EXPECT_THROW(CheckProjectionSize(Projection::kCubeStrip, 7, 1), InputError);
  EXPECT_THROW(ToLatLong(Image(10, 10), Projection::kCubeStrip), InputError);
}

// No texel of the lat-long map is larger than the texels of the square, which are equal.
TEST(Projections, SquaresKeepTheirDetail) {
  for (const int side : {1, 2, 7, 64, 1024}) {
    const int height = LatLongHeight(Projection::kOctahedral, side, side);
    EXPECT_LE(RowSolidAngle(2 * height, height, height / 2), 4 * M_PI / (double(side) * side));
  }
  // The map of the largest square has no more texels than a map may have.
  for (const int side : {11586, 16384, 32768}) {
    const auto height = std::int64_t(LatLongHeight(Projection::kOctahedral, side, side));
    EXPECT_LE(2 * height * height, std::int64_t{1} << 28);
    EXPECT_GT(2 * (height + 1) * (height + 1), std::int64_t{1} << 28);
  }
  // Checks of two by two texels keep half of their contrast.
  Image checks(64, 64);
  for (int i = 0; i < 64 * 64; ++i) {
    std::fill_n(checks.Pixel(i % 64, i / 64), 3, float((i % 64 / 2 + i / 64 / 2) % 2));
  }
  const Image latlong = ToLatLong(checks, Projection::kOctahedral);
  double squares = 0, weights = 0;
  for (int y = 0; y < latlong.height; ++y) {
    const double area = RowSolidAngle(latlong.width, latlong.height, y);
    for (int x = 0; x < latlong.width; ++x) {
      const double off = 2 * double(latlong.Pixel(x, y)[0]) - 1;
      squares += area * off * off, weights += area;
    }
  }
  EXPECT_GT(std::sqrt(squares / weights), 0.5);
}

TEST(Projections, ShapesOfCrossesAreDetected) {
  EXPECT_EQ(DetectProjection(Image(8, 6), "m"), Projection::kHorizontalCross);
  EXPECT_EQ(DetectProjection(Image(6, 8), "m"), Projection::kVerticalCross);
  EXPECT_EQ(DetectProjection(Image(8, 8), "m"), Projection::kAngular);
  EXPECT_EQ(DetectProjection(Image(8, 4), "m"), Projection::kLatLong);
}

}  // namespace
}  // namespace skywave
