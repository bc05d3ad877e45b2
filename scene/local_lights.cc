#include "scene/local_lights.h"

#include <fmt/format.h>

#include <algorithm>
#include <bit>
#include <cmath>
#include <glm/gtc/constants.hpp>
#include <map>

#include "base/error.h"
#include "image/image.h"
#include "scene/materials/emission_image.h"

namespace skywave {
namespace {

// The environment and the local lights each get at least this share of the light samples when a
// scene has both, because power alone does not show which of them is occluded.
constexpr double kLeastShare = 1.0 / 16;

constexpr double kPi = glm::pi<double>();

void Copy(const glm::vec3& from, float* to) {
  for (int i = 0; i < 3; ++i) to[i] = from[i];
}

}  // namespace

bool HasLocalLights(const Scene& scene) {
  const auto shines = [&](const Mesh& mesh) {
    return mesh.material < scene.materials.size() && !mesh.triangles.empty() &&
           scene.materials[mesh.material].emission != glm::vec3(0);
  };
  return std::any_of(scene.meshes.begin(), scene.meshes.end(), shines) ||
         std::any_of(scene.lights.begin(), scene.lights.end(),
                     [](const PunctualLight& light) { return light.emission != glm::vec3(0); });
}

float BoundingRadius(const Bounds& bounds) { return 0.5f * glm::length(bounds.high - bounds.low); }

double SpotSolidAngle(const PunctualLight& spot) {
  const double full = double(spot.cos_full), dark = double(spot.cos_dark);
  // The mean of the curve between the cones.
  const double mean = spot.curve == SpotCurve::kSmoothStep ? 0.5
                      : spot.curve == SpotCurve::kSquare   ? 1.0 / 3
                                                           : 0.2;
  return 2 * kPi * (1 - full + mean * (full - dark));
}

void LocalLights::Add(const LocalLight& light, const glm::vec3& mean, double power_per_unit) {
  const double power = Luminance(&mean.x) * power_per_unit;
  if (!(power > 0)) return;
  channel_power_ += std::max({mean.x, mean.y, mean.z}) * power_per_unit;
  lights_.push_back(light);
  power_.push_back(power);
  LocalLightTotal& total = totals_[std::size_t(light.kind)];
  ++total.count;
  total.power += power;
}

void LocalLights::AddTriangles(const Scene& scene, const Geometry& geometry,
                               const std::string& path) {
  std::map<std::uint32_t, EmissionImage> images;  // by texture
  for (const MeshPlace& place : geometry.meshes()) {
    const Mesh& mesh = scene.meshes[place.mesh];
    const Material& material = scene.materials[mesh.material];
    const bool shines = material.emission != glm::vec3(0);
    const EmissionImage* image = nullptr;
    std::span<const glm::vec2> uvs;
    if (shines && material.emission_texture) {
      const Texture& texture = scene.textures.at(*material.emission_texture);
      uvs = mesh.UvsOf(texture.uv_set);
      if (!uvs.empty()) {
        image =
            &images.try_emplace(*material.emission_texture, scene.images.at(texture.image), texture)
                 .first->second;
      }
    }
    if (shines) {
      const glm::vec3 seen = material.emission * (image ? image->brightest() : glm::vec3(1));
      brightest_ = std::max({brightest_, seen.x, seen.y, seen.z});
    }
    for (std::size_t i = 0; shines && i < mesh.triangles.size(); ++i) {
      const std::size_t triangle = place.first_triangle + i;
      const glm::vec3 corner = geometry.Corner(triangle, 0);
      const glm::vec3 axis = geometry.Corner(triangle, 1) - corner;
      const glm::vec3 edge = geometry.Corner(triangle, 2) - corner;
      glm::vec3 mean = material.emission;
      if (image != nullptr) {
        const glm::uvec3& t = mesh.triangles[i];
        mean *= image->Mean({uvs[t.x], uvs[t.y], uvs[t.z]});
      }
      LocalLight light = {.kind = LocalLightKind::kTriangle};
      light.area = float(0.5 * glm::length(glm::cross(glm::dvec3(axis), glm::dvec3(edge))));
      light.two_sided = material.emits_on_both_sides;
      light.triangle = std::uint32_t(triangle);
      Copy(material.emission, light.emission);
      Copy(corner, light.position), Copy(axis, light.axis), Copy(edge, light.edge);
      const std::size_t before = lights_.size();
      // The kernel computes the normal from the edges in floats, so degenerate triangles are tested
      // likewise.
      if (light.area > 0 && glm::dot(glm::cross(axis, edge), glm::cross(axis, edge)) > 0) {
        Add(light, mean, kPi * light.area * (light.two_sided ? 2 : 1));
      }
      if (lights_.size() == before) continue;
      if (lights_.size() > kMaxLocalLights) {
        throw InputError(InputPosition::File(path),
                         fmt::format("more than {} triangles and lights shine", kMaxLocalLights));
      }
      light_of_triangle_.resize(geometry.record_count(), kNoLight);
      light_of_triangle_[triangle] = std::uint32_t(before);
      if (image != nullptr) {
        emission_texture_.resize(lights_.size());
        emission_texture_.back() = *material.emission_texture + 1;
      }
      has_alpha_ = has_alpha_ || triangle >= geometry.first_with_alpha();
    }
  }
  for (std::size_t i = geometry.triangle_count(); i < light_of_triangle_.size(); ++i) {
    light_of_triangle_[i] = light_of_triangle_[geometry.TriangleOf(std::uint32_t(i))];
  }
  if (emission_texture_.empty()) return;
  emission_texture_.resize(lights_.size());
  textures_ = geometry.textures();
}

LocalLights::LocalLights(const Scene& scene, const Geometry& geometry, const std::string& path,
                         float radius, double environment_power) {
  const double disk = kPi * double(radius) * radius;
  for (const PunctualLight& from : scene.lights) {
    LocalLight light = {.kind = from.kind};
    light.triangle = std::uint32_t(&from - scene.lights.data());
    Copy(from.emission, light.emission);
    Copy(from.position, light.position);
    Copy(from.direction, light.axis);
    double power_per_unit = 4 * kPi;
    if (from.kind == LocalLightKind::kSpot) {
      light.cone.cos_dark = from.cos_dark;
      light.cone.inverse_range = 1 / std::max(from.cos_full - from.cos_dark, 1e-6f);
      light.cone.curve = from.curve;
      power_per_unit = SpotSolidAngle(from);
    } else if (from.kind == LocalLightKind::kDistant) {
      power_per_unit = disk;
    }
    glm::vec3 mean = from.emission;
    if (from.kind == LocalLightKind::kShaped) {
      light.shape = std::uint32_t(shapes_.shapes.size());
      mean *= glm::vec3(AddLightShape(scene, from, path, shapes_));
      power_per_unit = 1;
    }
    Add(light, mean, power_per_unit);
  }
  AddTriangles(scene, geometry, path);
  if (lights_.empty()) return;

  double power = 0;
  for (const LocalLightTotal& total : totals_) power += total.power;
  const double share = environment_power > 0 ? std::clamp(power / (power + environment_power),
                                                          kLeastShare, 1 - kLeastShare)
                                             : 1;
  alone_ = MakeChoice(power_, kChoiceUnits);
  const auto units = std::uint32_t(std::lround(share * kChoiceUnits));
  shared_ = MakeChoice(power_, std::max(units, std::uint32_t(2 * lights_.size())));

  const std::vector<double> alike(lights_.size(), 1.0);
  const auto places = double(lights_.size() + (environment_power > 0 ? 1 : 0));
  alike_alone_ = MakeChoice(alike, kChoiceUnits);
  alike_shared_ =
      MakeChoice(alike, std::uint32_t(std::lround(double(lights_.size()) / places * kChoiceUnits)));
  if (lights_.size() <= kMostOfEach) {
    only_.assign(lights_.size() + 1, 0);
    only_.resize(2 * lights_.size() + 1, kChoiceUnits);
    // Powers of two, so that probability times picks is exactly 1.
    const std::uint32_t of_each = kChoiceUnits / std::bit_ceil(std::uint32_t(lights_.size()));
    for (std::uint32_t i = 0; i <= lights_.size(); ++i) each_.push_back(i * of_each);
  }

  const double near = 0.01 * radius;
  const double lit = channel_power_ / (4 * kPi * near * near) / kPi;
  if (std::isfinite(lit)) brightest_ = std::max(brightest_, float(std::min(lit, 1e30)));
}

LocalLightView LocalLights::view() const {
  if (lights_.empty()) return {};
  const auto choice = [](const std::vector<std::uint32_t>& first) {
    return LightChoice{first.data(), float(first.back()) / float(kChoiceUnits)};
  };
  return {.lights = lights_.data(),
          .count = std::uint32_t(lights_.size()),
          .light_of_triangle = light_of_triangle_.empty() ? nullptr : light_of_triangle_.data(),
          .alone = choice(alone_),
          .shared = choice(shared_),
          .alike_alone = choice(alike_alone_),
          .alike_shared = choice(alike_shared_),
          .only = only_.empty() ? nullptr : only_.data(),
          .each = {each_.empty() ? nullptr : each_.data(), 1},
          .each_samples = float(std::bit_ceil(std::uint32_t(lights_.size()))),
          .has_alpha = has_alpha_,
          .emission_texture = emission_texture_.empty() ? nullptr : emission_texture_.data(),
          .textures = textures_,
          .shapes = shapes_.view()};
}

std::size_t LocalLights::bytes() const {
  return lights_.size() * sizeof(LocalLight) + power_.size() * sizeof(double) +
         (light_of_triangle_.size() + emission_texture_.size() + alone_.size() + shared_.size() +
          alike_alone_.size() + alike_shared_.size() + only_.size() + each_.size()) *
             sizeof(std::uint32_t) +
         shapes_.bytes();
}

}  // namespace skywave
