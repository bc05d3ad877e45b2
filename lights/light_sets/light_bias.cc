#include "lights/light_sets/light_bias.h"

#include <tbb/parallel_for.h>

#include <algorithm>
#include <cmath>
#include <numbers>

namespace skywave {
namespace {

constexpr int kPairs = 2048;
// The largest number of rows of blocks, and the least number of rows of parts of texels.
constexpr int kMostDown = 256, kLeastDown = 128;
constexpr std::size_t kLanes = 8;

// Blocks of the map as rows of their moments: the integral of luminance times direction.
struct Blocks {
  std::vector<float> x, y, z;  // whole lanes
};

// Returns the picture with every pixel as across x down equal ones.
Image Finer(const Image& image, int across, int down) {
  Image finer(image.width * across, image.height * down);
  for (int y = 0; y < finer.height; ++y) {
    for (int x = 0; x < finer.width; ++x) {
      std::copy_n(image.Pixel(x / across, y / down), 3, finer.Pixel(x, y));
    }
  }
  return finer;
}

Blocks BlocksOf(const SphereMap& map) {
  const int down = (map.height + kMostDown - 1) / kMostDown;
  const int across = (map.width + 2 * kMostDown - 1) / (2 * kMostDown);
  Blocks blocks;
  for (int y0 = 0; y0 < map.height; y0 += down) {
    for (int x0 = 0; x0 < map.width; x0 += across) {
      Vector3 moment;
      for (int y = y0; y < std::min(y0 + down, map.height); ++y) {
        for (int x = x0; x < std::min(x0 + across, map.width); ++x) {
          const double luminance = map.luminance[std::size_t(y) * std::size_t(map.width) + x];
          moment += luminance * map.DirectionIntegral(x, y);
        }
      }
      blocks.x.push_back(float(moment.x / map.energy));
      blocks.y.push_back(float(moment.y / map.energy));
      blocks.z.push_back(float(moment.z / map.energy));
    }
  }
  const std::size_t padded = (blocks.x.size() + kLanes - 1) / kLanes * kLanes;
  for (std::vector<float>* row : {&blocks.x, &blocks.y, &blocks.z}) row->resize(padded);
  return blocks;
}

// Returns the irradiance of blocks on a surface beside a wall, in units of their energy.
double Irradiance(const Blocks& blocks, const Vector3& normal, const Vector3& wall) {
  const float nx = float(normal.x), ny = float(normal.y), nz = float(normal.z);
  const float wx = float(wall.x), wy = float(wall.y), wz = float(wall.z);
  constexpr std::size_t kRun = 64 * kLanes;  // floats add up so many terms, doubles the runs
  double sum = 0;
  for (std::size_t begin = 0; begin < blocks.x.size(); begin += kRun) {
    const std::size_t end = std::min(begin + kRun, blocks.x.size());
    float lanes[kLanes] = {};
    for (std::size_t i = begin; i < end; i += kLanes) {
      for (std::size_t lane = 0; lane < kLanes; ++lane) {
        const float x = blocks.x[i + lane], y = blocks.y[i + lane], z = blocks.z[i + lane];
        const float received = std::max(x * nx + y * ny + z * nz, 0.0f);
        lanes[lane] += x * wx + y * wy + z * wz > 0 ? received : 0;
      }
    }
    for (const float lane : lanes) sum += lane;
  }
  return sum;
}

// Returns the number with the digits of `index` in base `base` after the point, in reverse (Halton
// 1960).
double RadicalInverse(int base, int index) {
  double value = 0, digit = 1.0 / base;
  for (; index > 0; index /= base, digit /= base) value += index % base * digit;
  return value;
}

Vector3 UniformDirection(double u, double v) {
  const double up = 1 - 2 * u, across = std::sqrt(std::max(0.0, 1 - up * up));
  return {across * std::cos(2 * std::numbers::pi * v), across * std::sin(2 * std::numbers::pi * v),
          up};
}

}  // namespace

LightBias::LightBias(const SphereMap& map) : pairs_(kPairs), mean_(map.energy / 8) {
  Blocks blocks;
  const int across = std::max(1, (2 * kLeastDown + map.width - 1) / map.width);
  const int down = std::max(1, (kLeastDown + map.height - 1) / map.height);
  if (across > 1 || down > 1) {
    const Image finer = Finer(*map.image, across, down);
    blocks = BlocksOf(MakeSphereMap(finer));
  } else {
    blocks = BlocksOf(map);
  }
  tbb::parallel_for(0, kPairs, [&](int i) {
    Pair& pair = pairs_[std::size_t(i)];
    pair.normal = UniformDirection(RadicalInverse(2, i + 1), RadicalInverse(3, i + 1));
    pair.wall = UniformDirection(RadicalInverse(5, i + 1), RadicalInverse(7, i + 1));
    pair.irradiance = map.energy * Irradiance(blocks, pair.normal, pair.wall);
  });
}

double LightBias::Of(std::span<const DirectionalLight> lights) const {
  std::vector<double> squares(pairs_.size());
  tbb::parallel_for(std::size_t(0), pairs_.size(), [&](std::size_t i) {
    const Pair& pair = pairs_[i];
    double irradiance = 0;
    for (const DirectionalLight& light : lights) {
      if (!(Dot(light.direction, pair.wall) > 0)) continue;
      irradiance += light.energy * std::max(Dot(light.direction, pair.normal), 0.0);
    }
    squares[i] = (irradiance - pair.irradiance) * (irradiance - pair.irradiance);
  });
  double sum = 0;
  for (const double square : squares) sum += square;
  return std::sqrt(sum / double(pairs_.size())) / mean_;
}

}  // namespace skywave
