#include "scene/gltf/lights.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "base/error.h"

namespace skywave {
namespace {

constexpr double kBrightest = 1e18;

// Returns the intensity or irradiance per channel.
glm::vec3 Emission(const tinygltf::Light& from, const std::string& path) {
  glm::dvec3 emission(from.intensity);
  for (std::size_t c = 0; c < 3 && c < from.color.size(); ++c) emission[int(c)] *= from.color[c];
  for (int c = 0; c < 3; ++c) {
    if (!(emission[c] >= 0 && emission[c] <= kBrightest)) {
      throw InputError(InputPosition::File(path),
                       fmt::format("light '{}' is negative or brighter than 1e18", from.name));
    }
  }
  return glm::vec3(emission);
}

}  // namespace

void AddGltfLight(const tinygltf::Model& model, const tinygltf::Node& node, const glm::dmat4& world,
                  const std::string& path, Scene& scene, Warnings& warnings) {
  const auto found = node.extensions.find("KHR_lights_punctual");
  if (found == node.extensions.end()) return;
  const tinygltf::Value& extension = found->second;
  const int index =
      extension.IsObject() && extension.Has("light") && extension.Get("light").IsNumber()
          ? extension.Get("light").GetNumberAsInt()
          : -1;
  if (index < 0 || std::size_t(index) >= model.lights.size()) {
    throw InputError(InputPosition::File(path), fmt::format("there is no light {}", index));
  }
  const tinygltf::Light& from = model.lights[std::size_t(index)];
  PunctualLight light;
  light.name = from.name;
  light.emission = Emission(from, path);
  light.position = glm::vec3(world[3]);
  const glm::dvec3 backwards(world[2]);  // lights look along -z
  if (from.type == "spot") {
    const double inner = from.spot.innerConeAngle, outer = from.spot.outerConeAngle;
    if (!(inner >= 0 && inner <= outer && outer > 0 && outer <= 1.5708)) {
      throw InputError(InputPosition::File(path),
                       fmt::format("light '{}' has a cone from {} to {}", from.name, inner, outer));
    }
    light.kind = LocalLightKind::kSpot;
    light.curve = SpotCurve::kSquare;
    light.cos_full = float(std::cos(inner)), light.cos_dark = float(std::cos(outer));
    light.direction = -glm::vec3(glm::normalize(backwards));
  } else if (from.type == "directional") {
    light.kind = LocalLightKind::kDistant;
    light.direction = glm::vec3(glm::normalize(backwards));
  } else if (from.type != "point") {
    AddWarning(warnings, InputPosition::File(path),
               fmt::format("lights of the type \"{}\" are not known: left out", from.type));
    return;
  }
  const glm::vec3 &p = light.position, &d = light.direction;
  if (!std::isfinite(p.x + p.y + p.z) || !std::isfinite(d.x + d.y + d.z)) {
    throw InputError(
        InputPosition::File(path),
        fmt::format("light '{}' is nowhere: its nodes' transform is singular", from.name));
  }
  scene.lights.push_back(light);
}

}  // namespace skywave
