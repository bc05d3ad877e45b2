#include "tests/support/adversarial_maps.h"
#include "tests/support/shade_points.h"

#include <algorithm>
#include <cmath>
#include <functional>
#include <stdexcept>
#include <vector>

#include "lights/strategies/strategy.h"

namespace skywave {
namespace {

using Radiance = std::array<double, 3>;

Image Paint(int width, int height, const std::function<Radiance(int, int)>& radiance) {
  Image image(width, height);
  for (int y = 0; y < height; ++y) {
    for (int x = 0; x < width; ++x) {
      const Radiance value = radiance(x, y);
      for (int c = 0; c < 3; ++c) image.Pixel(x, y)[c] = float(value[c]);
    }
  }
  return image;
}

Image Noise(int width, int height, double spread, std::uint32_t seed) {
  Random random(seed);
  return Paint(width, height, [&](int, int) {
    const double level = std::exp(spread * random.Between(-1, 1));
    return Radiance{level * random.Between(0.5, 1), level, level * random.Between(0.2, 1)};
  });
}

std::vector<NamedMap> MakeMaps() {
  const auto lit = [](bool is, double bright, double dark) {
    const double level = is ? bright : dark;
    return Radiance{level, 0.75 * level, 0.5 * level};
  };
  std::vector<NamedMap> maps;
  maps.push_back(
      {"OneTexel", Paint(64, 32, [&](int x, int y) { return lit(x == 40 && y == 9, 1e6, 0); })});
  maps.push_back(
      {"Seam", Paint(32, 16, [&](int x, int) { return lit(x == 0 || x == 31, 50, 0.01); })});
  maps.push_back({"NorthPole", Paint(32, 16, [&](int, int y) { return lit(y == 0, 1e4, 0.1); })});
  maps.push_back({"SouthPole", Paint(33, 17, [&](int, int y) { return lit(y == 16, 1e4, 0); })});
  maps.push_back({"Ramp", Paint(48, 24, [](int x, int y) {
                    return Radiance{x + 0.5, 2 * y + 1.0, 12.0 + x * y * 0.1};
                  })});
  maps.push_back({"ThreeByTwo", Paint(3, 2, [](int x, int y) {
                    return Radiance{1.0 + x, 2.0 + 3 * y, 1.0 + x * y};
                  })});
  maps.push_back({"OneByOne", Paint(1, 1, [](int, int) { return Radiance{3, 2, 1}; })});
  maps.push_back({"TwoByOne", Paint(2, 1, [](int x, int) { return Radiance{1.0 + 9 * x, 2, 1}; })});
  maps.push_back({"Black", Paint(19, 9, [](int, int) { return Radiance{0, 0, 0}; })});
  maps.push_back({"Constant", Paint(32, 16, [](int, int) { return Radiance{0.5, 0.5, 0.5}; })});
  maps.push_back({"Odd", Noise(45, 23, 1, 1)});
  maps.push_back({"Sun", Paint(128, 64, [](int x, int y) {
                    const bool sun = std::hypot(x - 90.0, y - 20.0) < 2.5;
                    const double sky = y < 32 ? 2 - y / 32.0 : 0.1;
                    return sun ? Radiance{1e6, 9e5, 7e5} : Radiance{0.4 * sky, 0.6 * sky, sky};
                  })});
  maps.push_back({"Noise", Noise(64, 32, 6, 2)});
  // More than 256 columns need search trees of two levels.
  maps.push_back({"Wide", Noise(1100, 40, 3, 3)});
  return maps;
}

std::vector<NamedOrientation> MakeOrientations() {
  const Vec up = Unit({0.3, -0.5, 0.8}), right = Unit(Cross({0.2, 1, 0.1}, up));
  const Vec forward = Cross(up, right);
  const auto rows = [](Vec r, Vec f, Vec u) {
    return std::array<float, 9>{float(r.x), float(r.y), float(r.z), float(f.x), float(f.y),
                                float(f.z), float(u.x), float(u.y), float(u.z)};
  };
  return {{"Upright", rows({1, 0, 0}, {0, 1, 0}, {0, 0, 1})},
          {"Rotated", rows(right, forward, up)},
          {"Mirrored", rows(-right, forward, up)}};
}

}  // namespace

std::span<const NamedMap> AdversarialMaps() {
  static const std::vector<NamedMap> maps = MakeMaps();
  return maps;
}

const Image& AdversarialMap(const std::string& name) {
  for (const NamedMap& map : AdversarialMaps()) {
    if (map.name == name) return map.latlong;
  }
  throw std::invalid_argument(name);
}

std::span<const NamedOrientation> Orientations() {
  static const std::vector<NamedOrientation> orientations = MakeOrientations();
  return orientations;
}

Image HeldMap(const EnvironmentMap& map) {
  Image held(map.latlong->width, map.latlong->height);
  const auto n = std::uint32_t(held.width * held.height);
  soa::Table<EscapeColumns> rows(n);
  for (std::uint32_t i = 0; i < n; ++i) {
    const double u = (i % std::uint32_t(held.width) + 0.5) / held.width;
    const double v = (i / std::uint32_t(held.width) + 0.5) / held.height;
    Put(WorldDirection(map.map_from_world, u, v), i, rows->dir_x, rows->dir_y, rows->dir_z);
    rows->pdf[i] = 1;
  }
  const soa::Table<SurfaceColumns> surfaces(1);
  MakeStrategy("uniform", map)->EvaluateEscaped(LambertPoints(surfaces, 1), n, 1, rows);
  for (std::uint32_t i = 0; i < n; ++i) {
    float* const pixel = &held.rgb[3 * std::size_t(i)];
    pixel[0] = rows->radiance_r[i], pixel[1] = rows->radiance_g[i], pixel[2] = rows->radiance_b[i];
  }
  return held;
}

Vec WorldDirection(const std::array<float, 9>& m, double u, double v) {
  const double turn = 2 * kPi * (u - 0.5), sine = std::sin(kPi * v);
  const double right = sine * std::sin(turn), forward = sine * std::cos(turn),
               up = std::cos(kPi * v);
  return Unit({m[0] * right + m[3] * forward + m[6] * up, m[1] * right + m[4] * forward + m[7] * up,
               m[2] * right + m[5] * forward + m[8] * up});
}

void MapPosition(const std::array<float, 9>& m, Vec w, double& u, double& v) {
  const double right = m[0] * w.x + m[1] * w.y + m[2] * w.z;
  const double forward = m[3] * w.x + m[4] * w.y + m[5] * w.z;
  const double up = m[6] * w.x + m[7] * w.y + m[8] * w.z;
  u = 0.5 + std::atan2(right, forward) / (2 * kPi);
  v = std::atan2(std::hypot(right, forward), up) / kPi;
}

double BorderDistance(int width, int height, double u, double v) {
  const auto to_integer = [](double x) { return std::fabs(x - std::round(x)); };
  const double across = to_integer(u * width) / width * 2 * kPi * std::sin(kPi * v);
  // The poles are not borders between rows.
  const double row = v * height, last = height - 0.5;
  const double down = row < 0.5 || row > last ? 1 : to_integer(row) / height * kPi;
  return std::min(across, down);
}

}  // namespace skywave
