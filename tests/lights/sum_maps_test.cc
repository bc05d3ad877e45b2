// Tests the sum of environments that have frames and sizes of their own.
#include "lights/maps/sum_maps.h"

#include <gtest/gtest.h>

#include <cmath>

#include "lights/maps/sphere_map.h"
#include "tests/support/random_rows.h"

namespace skywave {
namespace {

// Three smooth functions of a direction in the world.
Vec LightFrom(Vec d) { return {2 + d.x, 2 + d.y * d.z, 2 + std::cos(2 * d.z)}; }

// The columns are the axes of a map in the world.
std::array<std::array<float, 3>, 3> Frame(Vec forward, Vec up) {
  const Vec z = Unit(up), x = Unit(Cross(forward, z)), y = Cross(z, x);
  const auto column = [](Vec v) { return std::array{float(v.x), float(v.y), float(v.z)}; };
  return {column(x), column(y), column(z)};
}

Vec WorldOf(const OrientedMap& map, int x, int y) {
  const Vector3 d = DirectionOfUv((x + 0.5) / map.latlong.width, (y + 0.5) / map.latlong.height);
  const auto& m = map.world_from_map;
  const auto part = [&](std::size_t i) {
    return double(m[0][i]) * d.x + double(m[1][i]) * d.y + double(m[2][i]) * d.z;
  };
  return {part(0), part(1), part(2)};
}

OrientedMap Painted(int height, const std::array<std::array<float, 3>, 3>& frame, double scale) {
  OrientedMap map = {Image(2 * height, height), frame};
  for (int y = 0; y < height; ++y) {
    for (int x = 0; x < 2 * height; ++x) {
      const Vec light = scale * LightFrom(WorldOf(map, x, y));
      Put(light, 0, map.latlong.Pixel(x, y), map.latlong.Pixel(x, y) + 1,
          map.latlong.Pixel(x, y) + 2);
    }
  }
  return map;
}

// Every direction of the world keeps its light, on the grid of the finest map.
TEST(SumMaps, AddsLightFromTheSameDirection) {
  const OrientedMap fine = Painted(48, Frame({0.3, 0.8, 0.1}, {0.2, -0.4, 0.9}), 1);
  const OrientedMap other = Painted(40, Frame({-0.7, 0.2, 0.5}, {0.6, 0.5, -0.3}), 0.5);
  OrientedMap constant = fine;
  constant.latlong = Image(1, 1);
  for (float& value : constant.latlong.rgb) value = 3;
  const OrientedMap sum = SumMaps({other, constant, fine});
  ASSERT_EQ(sum.latlong.height, 48);
  EXPECT_EQ(sum.world_from_map, fine.world_from_map);
  double squares = 0;
  for (int y = 0; y < 48; ++y) {
    for (int x = 0; x < 96; ++x) {
      const Vec expected = 1.5 * LightFrom(WorldOf(fine, x, y)) + Vec{3, 3, 3};
      const float* const rgb = sum.latlong.Pixel(x, y);
      const Vec off = Vec{rgb[0], rgb[1], rgb[2]} - expected;
      ASSERT_LT(Length(off), 0.02) << x << ", " << y;
      squares += Dot(off, off) / (48 * 96);
    }
  }
  EXPECT_LT(std::sqrt(squares), 0.003);
}

}  // namespace
}  // namespace skywave
