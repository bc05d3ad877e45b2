#include "tests/support/oracle_lights.h"

#include <algorithm>
#include <cmath>
#include <limits>

namespace skywave {
namespace {

using glm::dvec3;

constexpr double kInfinity = std::numeric_limits<double>::infinity();

double Area(const OracleLocalLights::Triangle& t) {
  return glm::length(glm::cross(t.corner[1] - t.corner[0], t.corner[2] - t.corner[0])) / 2;
}

double Falloff(const PunctualLight& light, double cosine) {
  if (light.kind != LocalLightKind::kSpot) return 1;
  const double t =
      std::clamp((cosine - light.cos_dark) / (light.cos_full - light.cos_dark), 0.0, 1.0);
  return t * t * (3 - 2 * t);
}

}  // namespace

std::optional<OracleLocalLights::LightSample> OracleLocalLights::Sample(
    const dvec3& point, OracleRandom& random) const {
  const std::size_t count = triangles_.size() + lights_.size();
  const auto index = std::min(std::size_t(random() * double(count)), count - 1);
  if (index >= triangles_.size()) {
    const PunctualLight& light = lights_[index - triangles_.size()];
    const dvec3 emission = dvec3(light.emission) * double(count);
    if (light.kind == LocalLightKind::kDistant) {
      return LightSample{dvec3(light.direction), emission, 0, kInfinity};
    }
    const dvec3 offset = dvec3(light.position) - point;
    const double distance = glm::length(offset);
    const dvec3 direction = offset / distance;
    const double falloff = Falloff(light, -glm::dot(direction, dvec3(light.direction)));
    return LightSample{direction, emission * falloff / (distance * distance), 0, distance};
  }
  const Triangle& triangle = triangles_[index];
  // The point is uniform in the parallelogram, folded over its diagonal.
  double a = random(), b = random();
  if (a + b > 1) a = 1 - a, b = 1 - b;
  const dvec3 e1 = triangle.corner[1] - triangle.corner[0];
  const dvec3 e2 = triangle.corner[2] - triangle.corner[0];
  const dvec3 offset = triangle.corner[0] + a * e1 + b * e2 - point;
  const double distance = glm::length(offset);
  const dvec3 direction = offset / distance;
  const double towards = -glm::dot(glm::normalize(glm::cross(e1, e2)), direction);
  const double cosine = triangle.two_sided ? std::abs(towards) : towards;
  if (!(cosine > 0)) return std::nullopt;
  return LightSample{direction, triangle.radiance, Pdf(triangle, distance, cosine),
                     distance,  triangle.index,    a,
                     b};
}

double OracleLocalLights::Pdf(const Triangle& triangle, double distance, double cosine) const {
  const double count = double(triangles_.size() + lights_.size());
  return distance * distance / (cosine * Area(triangle) * count);
}

}  // namespace skywave
