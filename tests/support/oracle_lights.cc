#include "tests/support/oracle_lights.h"

#include <algorithm>
#include <cmath>
#include <glm/gtc/constants.hpp>
#include <limits>

namespace skywave {
namespace {

using glm::dvec3;

constexpr double kInfinity = std::numeric_limits<double>::infinity();
constexpr double kPi = glm::pi<double>();

double Area(const OracleLocalLights::Triangle& t) {
  return glm::length(glm::cross(t.corner[1] - t.corner[0], t.corner[2] - t.corner[0])) / 2;
}

double Falloff(const PunctualLight& light, double cosine) {
  const double t =
      std::clamp((cosine - light.cos_dark) / (light.cos_full - light.cos_dark), 0.0, 1.0);
  if (light.curve == SpotCurve::kSmoothStep) return t * t * (3 - 2 * t);
  return std::pow(t, light.curve == SpotCurve::kSquare ? 2 : 4);
}

// Returns the texel at (s, t) of the unit square, t downwards.
dvec3 Texel(const CompactImage& image, double s, double t) {
  const auto at = [](double x, int count) {
    return std::clamp(int(std::floor(x * count)), 0, count - 1);
  };
  const auto rgb = image.Pixel(at(s, image.width), at(t, image.height));
  return {rgb[0], rgb[1], rgb[2]};
}

}  // namespace

dvec3 OracleLightFactor(const PunctualLight& light, const std::vector<CompactImage>& images,
                        const dvec3& direction) {
  if (light.kind == LocalLightKind::kPoint) return dvec3(1);
  if (light.kind == LocalLightKind::kSpot) {
    return dvec3(Falloff(light, glm::dot(glm::normalize(direction), dvec3(light.direction))));
  }
  const LightForm& form = light.form.value();
  const dvec3 d = glm::normalize(glm::inverse(glm::dmat3(form.world_from_light)) * direction);
  if (form.mapping == LightMapping::kCone) return dvec3(Falloff(light, d.z));
  const CompactImage& image = images.at(form.image.value());
  if (form.mapping == LightMapping::kPlane) {
    const double x = d.x / d.z / form.half_size.x, y = d.y / d.z / form.half_size.y;
    if (d.z <= 0 || std::abs(x) > 1 || std::abs(y) > 1) return dvec3(0);
    return Texel(image, (1 + x) / 2, (1 - y) / 2);
  }
  // The upper hemisphere fills the diamond in the middle of the square; each quadrant of the lower
  // one is folded outwards.
  const double r = std::sqrt(1 - std::abs(d.z));
  const double share = std::atan2(std::abs(d.y), std::abs(d.x)) / (kPi / 2);
  double a = r * (1 - share), b = r * share;
  if (d.z < 0) {
    const double inner = a;
    a = 1 - b, b = 1 - inner;
  }
  return Texel(image, (1 + std::copysign(a, d.x)) / 2, (1 + std::copysign(b, d.y)) / 2);
}

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
    const dvec3 factor = OracleLightFactor(light, images_, -direction);
    return LightSample{direction, emission * factor / (distance * distance), 0, distance};
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
