// Tests illumination maps: look-ups along directions, resampling, packing and accepted sizes.

#include "kernels/lights/environment.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <functional>
#include <limits>
#include <memory>
#include <string>

#include "base/error.h"
#include "lights/maps/projections.h"
#include "lights/maps/resample.h"
#include "lights/strategies/strategy.h"
#include "tests/support/adversarial_maps.h"
#include "tests/support/shade_points.h"
#include "tests/support/targets.h"

namespace skywave {
namespace {

// Returns the radiance along directions: pdf 0 gives the interpolated view of the camera, pdf 1 the
// texels.
soa::Table<EscapeColumns> LookUp(const EnvironmentMap& map, const std::vector<Vec>& directions,
                                 float pdf) {
  const auto n = std::uint32_t(directions.size());
  soa::Table<EscapeColumns> rows(n);
  for (std::uint32_t i = 0; i < n; ++i) {
    Put(directions[i], i, rows->dir_x, rows->dir_y, rows->dir_z);
    rows->pdf[i] = pdf;
  }
  const soa::Table<SurfaceColumns> surfaces(1);
  MakeStrategy("uniform", map)->EvaluateEscaped(LambertPoints(surfaces, 1), n, 1, rows);
  return rows;
}

// Interpolates bilinearly between texel centres; columns wrap, the rows at the poles repeat.
double Interpolated(const Image& image, double u, double v, int channel) {
  const double x = u * image.width - 0.5, y = v * image.height - 0.5;
  const int x0 = int(std::floor(x)), y0 = int(std::floor(y));
  const auto at = [&](int column, int row) {
    column = (column % image.width + image.width) % image.width;
    return double(image.Pixel(column, std::clamp(row, 0, image.height - 1))[channel]);
  };
  const double fx = x - x0, fy = y - y0;
  return (1 - fy) * ((1 - fx) * at(x0, y0) + fx * at(x0 + 1, y0)) +
         fy * ((1 - fx) * at(x0, y0 + 1) + fx * at(x0 + 1, y0 + 1));
}

// Directions are spread everywhere, and densely at the poles and on both sides of the seam.
std::vector<Vec> Directions(const std::array<float, 9>& map_from_world) {
  Random random(61);
  std::vector<Vec> directions;
  for (int i = 0; i < 3000; ++i) directions.push_back(random.Direction());
  for (const double distance : {1e-1, 1e-2, 1e-3, 1e-4, 1e-5, 0.0}) {
    for (int i = 0; i < 40; ++i) {
      const double u = random.Float(), v = random.Float();
      directions.push_back(WorldDirection(map_from_world, u, distance));
      directions.push_back(WorldDirection(map_from_world, u, 1 - distance));
      directions.push_back(WorldDirection(map_from_world, distance, v));
      directions.push_back(WorldDirection(map_from_world, 1 - distance, v));
    }
  }
  return directions;
}

TEST(EnvironmentLookup, TexelsMatchTheReference) {
  for (const NamedMap& named : AdversarialMaps()) {
    for (const NamedOrientation& orientation : Orientations()) {
      SCOPED_TRACE(named.name + " " + orientation.name);
      const EnvironmentMap map = {named.latlong, orientation.map_from_world};
      const Image image = HeldMap(map);
      const std::vector<Vec> directions = Directions(orientation.map_from_world);
      const auto rows = LookUp(map, directions, 1);
      for (std::uint32_t i = 0; i < directions.size(); ++i) {
        double u, v;
        const Vec rounded = Get(i, rows->dir_x, rows->dir_y, rows->dir_z);
        MapPosition(orientation.map_from_world, rounded, u, v);
        if (BorderDistance(image.width, image.height, u, v) < 2e-6) continue;
        const float* texel = image.Pixel(std::min(int(u * image.width), image.width - 1),
                                         std::min(int(v * image.height), image.height - 1));
        ASSERT_EQ(rows->radiance_r[i], texel[0]) << u << " " << v;
        ASSERT_EQ(rows->radiance_g[i], texel[1]);
        ASSERT_EQ(rows->radiance_b[i], texel[2]);
      }
    }
  }
}

TEST(EnvironmentLookup, InterpolationMatchesTheReference) {
  for (const NamedMap& named : AdversarialMaps()) {
    for (const NamedOrientation& orientation : Orientations()) {
      SCOPED_TRACE(named.name + " " + orientation.name);
      const Image& image = named.latlong;
      const EnvironmentMap map = {image, orientation.map_from_world};
      const std::vector<Vec> directions = Directions(orientation.map_from_world);
      const auto rows = LookUp(map, directions, 0);
      const double brightest = *std::max_element(image.rgb.begin(), image.rgb.end());
      for (std::uint32_t i = 0; i < directions.size(); ++i) {
        double u, v;
        const Vec rounded = Get(i, rows->dir_x, rows->dir_y, rows->dir_z);
        MapPosition(orientation.map_from_world, rounded, u, v);
        // The azimuth has an error of 3e-7 / sin theta, which multiplies the gradient of the
        // texels. At the pole itself it is undefined.
        const double sine = std::sin(kPi * v);
        const double texels =
            3e-7 * (image.width / (2 * kPi * std::max(sine, 1e-9)) + image.height);
        if (texels > 0.05) continue;
        for (int c = 0; c < 3; ++c) {
          const float value = c == 0   ? rows->radiance_r[i]
                              : c == 1 ? rows->radiance_g[i]
                                       : rows->radiance_b[i];
          const double exact = Interpolated(image, u, v, c);
          ASSERT_NEAR(value, exact, 1e-5 * exact + texels * brightest)
              << "u " << u << ", v " << v << ", channel " << c;
        }
      }
    }
  }
}

TEST(EnvironmentLookup, AxesLookWhereTheyShould) {
  Image image(8, 4);
  for (int y = 0; y < 4; ++y) {
    for (int x = 0; x < 8; ++x) {
      float* const pixel = image.Pixel(x, y);
      pixel[0] = float(x), pixel[1] = float(y), pixel[2] = 1;
    }
  }
  // Right is +x, forward +y, up +z: the centre of the image is forward, its right half to the
  // right.
  const EnvironmentMap map = {image, {1, 0, 0, 0, 1, 0, 0, 0, 1}};
  const auto rows = LookUp(map,
                           {Unit({0.1, 1, 0.1}),
                            Unit({1, -0.1, 0.1}),
                            Unit({-1, 0.1, -0.1}),
                            Unit({0.1, -1, -0.1}),
                            {0, 0, 1},
                            {0, 0, -1}},
                           1);
  EXPECT_EQ(rows->radiance_r[0], 4);  // just right of the centre
  EXPECT_EQ(rows->radiance_g[0], 1);
  EXPECT_EQ(rows->radiance_r[1], 6);
  EXPECT_EQ(rows->radiance_r[2], 2);
  EXPECT_EQ(rows->radiance_g[2], 2);
  EXPECT_EQ(rows->radiance_r[3], 7);
  EXPECT_EQ(rows->radiance_g[4], 0);
  EXPECT_EQ(rows->radiance_g[5], 3);
}

TEST(EnvironmentLookup, RowsMayMixBothViewsAndTargetsAgree) {
  const EnvironmentMap map = {AdversarialMap("Noise"), Orientations()[2].map_from_world};
  std::vector<Vec> directions = Directions(map.map_from_world);
  directions.resize(kFullWave);
  const auto texels = LookUp(map, directions, 1), smooth = LookUp(map, directions, 0);
  const auto strategy = MakeStrategy("uniform", map);
  const soa::Table<SurfaceColumns> surfaces(1);
  ForEachTarget([&] {
    for (const std::uint32_t n : kRowCounts) {
      soa::Table<EscapeColumns> rows(kFullWave);
      FillWithGarbage(rows.columns(), kFullWave);
      for (std::uint32_t i = 0; i < n; ++i) {
        Put(directions[i], i, rows->dir_x, rows->dir_y, rows->dir_z);
        rows->pdf[i] = i % 3 == 1 ? 0.0f : 0.5f;
      }
      strategy->EvaluateEscaped(LambertPoints(surfaces, n), n, 1, rows);
      for (std::uint32_t i = 0; i < n; ++i) {
        const EscapeColumns& exact = i % 3 == 1 ? smooth : texels;
        ASSERT_EQ(rows->radiance_r[i], exact.radiance_r[i]) << "row " << i << " of " << n;
        ASSERT_EQ(rows->radiance_g[i], exact.radiance_g[i]);
        ASSERT_EQ(rows->radiance_b[i], exact.radiance_b[i]);
      }
    }
  });
}

const std::array<float, 9> kUpright = {1, 0, 0, 0, 1, 0, 0, 0, 1};

TEST(EnvironmentPacking, KeepsTheEnergyOfEveryMap) {
  for (const NamedMap& named : AdversarialMaps()) {
    const Image held = HeldMap({named.latlong, kUpright});
    const auto mean = SphereMean(named.latlong), kept = SphereMean(held);
    // The rounding error of one texel, down to 2^-8 of it, may remain.
    double largest_row = 0;
    for (int row = 0; row < held.height; ++row) {
      largest_row = std::max(largest_row, RowSolidAngle(held.width, held.height, row));
    }
    const double brightest = *std::max_element(held.rgb.begin(), held.rgb.end());
    const double rounding = brightest * 0x1p-8 * largest_row / (4 * kPi);
    for (int c = 0; c < 3; ++c) {
      EXPECT_NEAR(kept[c], mean[c], rounding + 1e-6 * mean[c]) << named.name << " channel " << c;
    }
  }
}

// A texel is rounded down to nine bits of its brightest channel, and inherits an error of the same
// size from its predecessors.
TEST(EnvironmentPacking, StaysNearTheMap) {
  for (const std::string name :
       {"Ramp", "ThreeByTwo", "OneByOne", "TwoByOne", "Constant", "Odd", "Black"}) {
    const Image& image = AdversarialMap(name);
    const Image held = HeldMap({image, kUpright});
    const double brightest = *std::max_element(image.rgb.begin(), image.rgb.end());
    for (std::size_t i = 0; i < image.rgb.size(); ++i) {
      ASSERT_NEAR(held.rgb[i], image.rgb[i], 0x1p-7 * brightest) << name << " " << i;
    }
  }
}

// A sun passes its remainder to its neighbour and takes nothing from other texels.
TEST(EnvironmentPacking, DarkensNoNeighbour) {
  for (const NamedMap& named : AdversarialMaps()) {
    const Image held = HeldMap({named.latlong, kUpright});
    const double brightest = *std::max_element(named.latlong.rgb.begin(), named.latlong.rgb.end());
    for (std::size_t i = 0; i < held.rgb.size(); i += 3) {
      const float* pixel = &named.latlong.rgb[i];
      // This is one unit of the texel's own exponent, or of the smallest exponent.
      const double unit = std::max(
          std::max({held.rgb[i], held.rgb[i + 1], held.rgb[i + 2]}) * 0x1p-8, brightest * 0x1p-39);
      for (std::size_t c = 0; c < 3; ++c) {
        ASSERT_GE(held.rgb[i + c], pixel[c] - unit) << named.name << " " << i + c;
      }
    }
  }
}

TEST(EnvironmentPacking, IsExactForNineBitsAtEveryScale) {
  for (const double scale : {0x1p-90, 0x1p-60, 1.0, 0x1p40, 0x1p118}) {
    Image image(4, 2);
    const double values[8] = {511, 256, 1, 0, 0x1p-10, 255 * 0x1p-20, 384, 257};
    for (int i = 0; i < 8; ++i) {
      for (int c = 0; c < 3; ++c) image.rgb[3 * i + c] = float(values[i] * scale);
    }
    const Image held = HeldMap({image, kUpright});
    EXPECT_EQ(held.rgb, image.rgb) << "scale " << scale;
  }
}

TEST(EnvironmentPacking, TakesTheLargestAndSmallestFloats) {
  for (const float value : {3.4e38f, 1e30f, 1e-30f, 1e-37f, 1e-45f}) {
    Image image(2, 1);
    std::fill(image.rgb.begin(), image.rgb.end(), value);
    for (const float held : HeldMap({image, kUpright}).rgb) {
      ASSERT_TRUE(std::isfinite(held) && held >= 0) << value;
      ASSERT_NEAR(held / value, 1, value > 1e-25f ? 0x1p-8 : 1);
    }
  }
}

TEST(EnvironmentMap, RowsAddUpToTheSphere) {
  for (const auto& [width, height] : {std::pair{1, 1}, {3, 2}, {2, 1}, {1024, 512}, {37, 1001}}) {
    double sum = 0;
    for (int row = 0; row < height; ++row) {
      const double angle = RowSolidAngle(width, height, row);
      EXPECT_NEAR(angle, RowSolidAngle(width, height, height - 1 - row), 1e-12 * angle);
      sum += width * angle;
    }
    EXPECT_NEAR(sum, 4 * kPi, 1e-11);
  }
  // Half the sphere lies above the equator; a tiny cap has area pi r^2.
  EXPECT_NEAR(RowSolidAngle(1, 2, 0), 2 * kPi, 1e-14);
  const double radius = kPi / 100000;
  EXPECT_NEAR(RowSolidAngle(1, 100000, 0) / (kPi * radius * radius), 1, 1e-9);
}

TEST(EnvironmentMap, MeanIsWeightedBySolidAngle) {
  for (const std::string name : {"Constant", "Ramp", "ThreeByTwo", "OneByOne"}) {
    const Image& image = AdversarialMap(name);
    double sum[3] = {};
    for (int y = 0; y < image.height; ++y) {
      const double share =
          (std::cos(kPi * y / image.height) - std::cos(kPi * (y + 1) / image.height)) / 2 /
          image.width;
      for (int x = 0; x < image.width; ++x) {
        for (int c = 0; c < 3; ++c) sum[c] += share * image.Pixel(x, y)[c];
      }
    }
    for (int c = 0; c < 3; ++c) EXPECT_NEAR(SphereMean(image)[c], sum[c], 1e-12 * sum[c]) << name;
  }
}

TEST(EnvironmentMap, ProjectionFollowsFromTheShape) {
  EXPECT_EQ(DetectProjection(Image(64, 32), "map"), Projection::kLatLong);
  EXPECT_EQ(DetectProjection(Image(2, 1), "map"), Projection::kLatLong);
  EXPECT_EQ(DetectProjection(Image(64, 64), "map"), Projection::kAngular);
  EXPECT_EQ(DetectProjection(Image(1, 1), "map"), Projection::kLatLong);
  for (const auto& [width, height] : {std::pair{3, 2}, {1, 2}, {64, 33}, {32, 64}}) {
    try {
      DetectProjection(Image(width, height), "sky.hdr");
      ADD_FAILURE() << width << " x " << height << " was accepted";
    } catch (const InputError& error) {
      const std::string text = error.what();
      EXPECT_NE(text.find("sky.hdr"), std::string::npos) << text;
      EXPECT_NE(text.find("--env-projection"), std::string::npos) << text;
      EXPECT_EQ(error.exit_code(), kExitBadInput);
    }
  }
}

// Paints an angular map from a function of the direction in the map (right, forward, up).
Image PaintAngular(int side, const std::function<std::array<double, 3>(Vec)>& radiance) {
  Image image(side, side);
  for (int py = 0; py < side; ++py) {
    for (int px = 0; px < side; ++px) {
      const double x = 2 * (px + 0.5) / side - 1, y = 1 - 2 * (py + 0.5) / side;
      const double r = std::hypot(x, y);
      if (r > 1) {
        // These pixels must never be read.
        for (int c = 0; c < 3; ++c) image.Pixel(px, py)[c] = 1e9f;
        continue;
      }
      const double sine = r > 0 ? std::sin(kPi * r) / r : 0;
      const auto value = radiance({x * sine, std::cos(kPi * r), y * sine});
      for (int c = 0; c < 3; ++c) image.Pixel(px, py)[c] = float(value[c]);
    }
  }
  return image;
}

TEST(AngularMap, DirectionsLandWhereTheyShould) {
  const auto at = [](Vec d) {
    const double direction[3] = {d.x, d.y, d.z};
    double x, y;
    AngularPosition(direction, x, y);
    return std::pair{x, y};
  };
  const auto expect = [&](Vec d, double x, double y) {
    EXPECT_NEAR(at(d).first, x, 1e-12);
    EXPECT_NEAR(at(d).second, y, 1e-12);
  };
  expect({0, 1, 0}, 0, 0);             // forward: the centre
  expect({1, 0, 0}, 0.5, 0);           // right
  expect({-1, 0, 0}, -0.5, 0);         // left
  expect({0, 0, 1}, 0, 0.5);           // up
  expect(Unit({0, 1, -1}), 0, -0.25);  // half down
  expect(Unit({1, -1, 0}), 0.75, 0);   // halfway to the back
  EXPECT_NEAR(std::hypot(at({0, -1, 0}).first, at({0, -1, 0}).second), 1,
              1e-12);  // backward: the rim
}

TEST(AngularMap, BecomesTheSameEnvironment) {
  const auto environment = [](Vec d) {
    return std::array<double, 3>{2 + d.x, 2 + d.y, 2 + d.z};  // right, forward, up
  };
  const Image latlong = ToLatLong(PaintAngular(256, environment), Projection::kAngular);
  ASSERT_EQ(latlong.width, 256);
  ASSERT_EQ(latlong.height, 128);
  for (int y = 0; y < latlong.height; ++y) {
    for (int x = 0; x < latlong.width; ++x) {
      // A pixel is the mean over its area: the points are uniform in azimuth and cosine.
      constexpr int kSide = 8;
      std::array<double, 3> exact = {};
      Vec d;
      for (int s = 0; s < kSide * kSide; ++s) {
        const double top = std::cos(kPi * y / latlong.height);
        const double bottom = std::cos(kPi * (y + 1) / latlong.height);
        const double cosine = top + (bottom - top) * (s / kSide + 0.5) / kSide;
        d = WorldDirection(kUpright, (x + (s % kSide + 0.5) / kSide) / latlong.width,
                           std::acos(cosine) / kPi);
        for (int c = 0; c < 3; ++c) exact[c] += environment(d)[c] / (kSide * kSide);
      }
      // Near the backward direction, look-ups stay a pixel and a half inside the rim, an error of
      // pi * 3 / 256. At a pole, the mean over a texel lies farther from the pole than the texel's
      // centre.
      const bool pole = y == 0 || y == latlong.height - 1;
      const double tolerance = d.y < -0.98 ? 0.05 : pole ? 5e-3 : 2e-3;
      for (int c = 0; c < 3; ++c) {
        ASSERT_NEAR(latlong.Pixel(x, y)[c], exact[c], tolerance)
            << x << " " << y << " channel " << c;
      }
    }
  }
  for (const double mean : SphereMean(latlong)) EXPECT_NEAR(mean, 2, 1e-3);
}

TEST(AngularMap, KeepsTheEnergyOfALamp) {
  const Vec lamp = Unit({0.5, 0.4, 0.7});
  const double radius = 0.15;
  const auto environment = [&](Vec d) {
    const double level = Angle(d, lamp) < radius ? 1000 : 0;
    return std::array<double, 3>{level, level, level};
  };
  const Image latlong = ToLatLong(PaintAngular(400, environment), Projection::kAngular);
  const double exact = 1000 * (1 - std::cos(radius)) / 2;
  EXPECT_NEAR(SphereMean(latlong)[0] / exact, 1, 0.01);
}

TEST(AngularMap, LatLongStaysAsItIs) {
  EXPECT_EQ(ToLatLong(AdversarialMap("Odd"), Projection::kLatLong).rgb, AdversarialMap("Odd").rgb);
}

}  // namespace
}  // namespace skywave
