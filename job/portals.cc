#include "job/portals.h"

#include <fmt/format.h>

#include <algorithm>
#include <charconv>
#include <optional>

#include "base/error.h"
#include "base/nearest_name.h"
#include "scene/portals.h"

namespace skywave {
namespace {

// Returns the numbers of "1,2.5,-3", or nothing if the text is something else.
std::optional<std::vector<double>> Numbers(const std::string& text) {
  std::vector<double> numbers;
  const char *next = text.data(), *const end = next + text.size();
  while (true) {
    double number = 0;
    const auto [stop, error] = std::from_chars(next, end, number);
    if (error != std::errc()) return std::nullopt;
    numbers.push_back(number);
    if (stop == end) return numbers;
    if (*stop != ',') return std::nullopt;
    next = stop + 1;
  }
}

std::vector<Portal> PortalsOfText(const std::string& text, Scene& scene) {
  if (const auto numbers = Numbers(text)) {
    if (numbers->size() != 12) {
      throw InputError({}, fmt::format("has {} numbers; a portal is X,Y,Z of four corners, 12 "
                                       "numbers",
                                       numbers->size()));
    }
    std::array<glm::vec3, 4> corners;
    for (std::size_t i = 0; i < 12; ++i) {
      corners[i / 3][int(i % 3)] = float((*numbers)[i] - scene.origin[int(i % 3)]);
    }
    return {PortalOfCorners(corners)};
  }
  std::vector<Portal> portals;
  std::vector<std::string_view> names;
  bool found = false;
  for (const Mesh& mesh : scene.meshes) {
    names.push_back(mesh.name);
    if (mesh.name != text) continue;
    found = true;
    const std::vector<Portal> of_mesh = PortalsOfMesh(mesh);
    portals.insert(portals.end(), of_mesh.begin(), of_mesh.end());
  }
  if (!found) {
    throw InputError({}, fmt::format("is neither 12 numbers nor the name of a mesh; the scene has "
                                     "{}",
                                     NearestFirst(text, names)));
  }
  std::erase_if(scene.meshes, [&](const Mesh& mesh) { return mesh.name == text; });
  return portals;
}

// Whether the light of any portal reaches a part of the scene.
bool LightAnything(const std::vector<Portal>& portals, const Scene& scene) {
  const std::vector<Bounds> instances = InstanceBounds(scene);
  for (const Portal& portal : portals) {
    const glm::vec3 out = glm::cross(portal.side_x, portal.side_y);
    const float margin = 1e-4f * glm::length(out) * glm::length(portal.side_x + portal.side_y);
    for (const Mesh& mesh : scene.meshes) {
      for (const glm::vec3& p : mesh.positions) {
        if (glm::dot(p - portal.corner, out) < -margin) return true;
      }
    }
    for (const Bounds& box : instances) {
      const glm::vec3 deepest = glm::mix(box.high, box.low, glm::greaterThan(out, glm::vec3(0)));
      if (glm::dot(deepest - portal.corner, out) < -margin) return true;
    }
  }
  return false;
}

}  // namespace

void AddPortals(const std::vector<std::string>& texts, Scene& scene) {
  for (const std::string& text : texts) {
    try {
      const std::vector<Portal> portals = PortalsOfText(text, scene);
      if (!LightAnything(portals, scene)) {
        throw InputError({},
                         "faces away from the whole scene: the corners go round counter-clockwise "
                         "(normals point) for the side that is lit; turn them round");
      }
      scene.portals.insert(scene.portals.end(), portals.begin(), portals.end());
    } catch (const InputError& error) {
      throw OptionError("portal", text, error.reason());
    }
  }
  if (scene.portals.size() > kMaxPortals) {
    throw OptionError("portal", "",
                      fmt::format("there are {} portals; at most {} can be used",
                                  scene.portals.size(), kMaxPortals));
  }
}

}  // namespace skywave
