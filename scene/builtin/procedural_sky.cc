#include "scene/builtin/procedural_sky.h"

#include <algorithm>
#include <cmath>
#include <glm/gtc/constants.hpp>
#include <vector>

namespace skywave {
namespace {

// Returns the direction (right, up, forward) at column x and row y of the map, in texels from the
// top left corner.
glm::dvec3 Direction(const ProceduralSky& sky, double x, double y) {
  const double theta = glm::pi<double>() * y / sky.height;
  const double azimuth = glm::two_pi<double>() * (x / sky.width - 0.5);
  return {std::sin(theta) * std::sin(azimuth), std::cos(theta),
          std::sin(theta) * std::cos(azimuth)};
}

// Returns the solid angle of any texel of row y [sr].
double TexelSolidAngle(const ProceduralSky& sky, int y) {
  const double row = glm::pi<double>() / sky.height;
  return glm::two_pi<double>() / sky.width * (std::cos(y * row) - std::cos((y + 1) * row));
}

glm::dvec3 SkyRadiance(const ProceduralSky& sky, const glm::dvec3& direction,
                       const glm::dvec3& to_sun) {
  // Both fall to 1/e over these distances, [1] and [radians].
  constexpr double kHazeHeight = 0.18, kGlowAngle = 0.16;
  const double haze = std::exp(-std::abs(direction.y) / kHazeHeight);
  const glm::dvec3 away = direction.y >= 0 ? sky.zenith : sky.ground;
  glm::dvec3 radiance = glm::mix(away, glm::dvec3(sky.horizon), haze);
  if (direction.y >= 0) {
    const double angle = std::acos(std::clamp(glm::dot(direction, to_sun), -1.0, 1.0));
    radiance += glm::dvec3(sky.glow) * std::exp(-angle / kGlowAngle);
  } else {
    // Haze is thinner over the ground, so that the horizon stays a visible line.
    radiance = glm::mix(glm::dvec3(sky.ground), radiance, 0.7);
  }
  return radiance;
}

// Returns the fraction of the texel inside the disc, estimated on a regular grid of samples.
double Coverage(const ProceduralSky& sky, int x, int y, const glm::dvec3& to_sun,
                double cos_radius) {
  constexpr int kGrid = 16;
  // No corner of a texel is farther than this from its centre.
  const double reach = glm::pi<double>() / std::min(sky.height, sky.width / 2);
  const double distance =
      std::acos(std::clamp(glm::dot(Direction(sky, x + 0.5, y + 0.5), to_sun), -1.0, 1.0));
  if (distance > std::acos(cos_radius) + reach) return 0;
  int inside = 0;
  for (int i = 0; i < kGrid * kGrid; ++i) {
    const glm::dvec3 direction =
        Direction(sky, x + (i % kGrid + 0.5) / kGrid, y + (i / kGrid + 0.5) / kGrid);
    inside += glm::dot(direction, to_sun) > cos_radius;
  }
  return static_cast<double>(inside) / (kGrid * kGrid);
}

void AddSun(const ProceduralSky& sky, const glm::dvec3& to_sun, Image& image) {
  const double radius = glm::radians(0.5 * sky.sun_diameter_degrees);
  const double cos_radius = std::cos(radius);
  struct Texel {
    int x, y;
    double coverage;
  };
  std::vector<Texel> texels;
  double covered = 0;  // [sr]
  const double sun_row = (90.0 - sky.sun_elevation_degrees) / 180.0 * sky.height;
  const double rows = radius / glm::pi<double>() * sky.height + 1;
  const int first = std::max(0, static_cast<int>(std::floor(sun_row - rows)));
  const int last = std::min(sky.height - 1, static_cast<int>(std::ceil(sun_row + rows)));
  for (int y = first; y <= last; ++y) {
    for (int x = 0; x < sky.width; ++x) {
      const double coverage = Coverage(sky, x, y, to_sun, cos_radius);
      if (coverage == 0) continue;
      texels.push_back({x, y, coverage});
      covered += coverage * TexelSolidAngle(sky, y);
    }
  }
  if (covered == 0) return;
  const double solid_angle = glm::two_pi<double>() * (1 - cos_radius);
  for (const Texel& texel : texels) {
    for (int c = 0; c < 3; ++c) {
      image.Pixel(texel.x, texel.y)[c] +=
          static_cast<float>(sky.sun[c] * texel.coverage * solid_angle / covered);
    }
  }
}

}  // namespace

Image MakeProceduralSky(const ProceduralSky& sky) {
  const glm::dvec3 to_sun = Direction(sky, (sky.sun_azimuth_degrees / 360.0 + 0.5) * sky.width,
                                      (90.0 - sky.sun_elevation_degrees) / 180.0 * sky.height);
  Image image(sky.width, sky.height);
  for (int y = 0; y < sky.height; ++y) {
    for (int x = 0; x < sky.width; ++x) {
      const glm::dvec3 radiance = SkyRadiance(sky, Direction(sky, x + 0.5, y + 0.5), to_sun);
      for (int c = 0; c < 3; ++c) image.Pixel(x, y)[c] = static_cast<float>(radiance[c]);
    }
  }
  AddSun(sky, to_sun, image);
  return image;
}

}  // namespace skywave
