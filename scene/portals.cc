#include "scene/portals.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <optional>

#include "base/error.h"

namespace skywave {
namespace {

constexpr double kTolerance = 1e-3;

std::string Text(const glm::vec3& p) { return fmt::format("({} {} {})", p.x, p.y, p.z); }

// Returns the corners of the quadrilateral that two triangles make, in the order of the first one,
// if they have two corners in common.
std::optional<std::array<glm::vec3, 4>> Joined(const std::array<glm::vec3, 3>& a,
                                               const std::array<glm::vec3, 3>& b) {
  const auto in = [](const std::array<glm::vec3, 3>& triangle, const glm::vec3& p) {
    return std::find(triangle.begin(), triangle.end(), p) != triangle.end();
  };
  for (std::size_t i = 0; i < 3; ++i) {
    const glm::vec3 &alone = a[i], &next = a[(i + 1) % 3], &last = a[(i + 2) % 3];
    if (in(b, alone) || !in(b, next) || !in(b, last)) continue;
    const auto opposite =
        std::find_if(b.begin(), b.end(), [&](const auto& p) { return p != next && p != last; });
    if (opposite == b.end()) continue;
    return std::array{alone, next, *opposite, last};
  }
  return std::nullopt;
}

}  // namespace

Portal PortalOfCorners(const std::array<glm::vec3, 4>& corners) {
  for (const glm::vec3& corner : corners) {
    if (!std::isfinite(corner.x + corner.y + corner.z)) {
      throw InputError({}, "a portal with a corner that is not finite");
    }
  }
  const glm::dvec3 a(corners[0]), x = glm::dvec3(corners[3]) - a, y = glm::dvec3(corners[1]) - a;
  const double width = glm::length(x), height = glm::length(y);
  if (!(width > 0 && height > 0)) throw InputError({}, "a portal has two corners in one place");
  const glm::dvec3 rest = glm::dvec3(corners[2]) - (a + x + y);
  if (std::abs(glm::dot(x, y)) > kTolerance * width * height) {
    throw InputError({}, fmt::format("the sides of the portal meet at no right angle at {}; give "
                                     "its corners in order, one after the other",
                                     Text(corners[0])));
  }
  if (glm::length(rest) > kTolerance * std::min(width, height)) {
    throw InputError({},
                     fmt::format("the portal is not a plane rectangle: opposite to {} its corner "
                                 "would be {}, and it is {}",
                                 Text(corners[0]), Text(glm::vec3(a + x + y)), Text(corners[2])));
  }
  // What the tolerance has let pass is taken out of the second side.
  const glm::dvec3 upright = y - x * (glm::dot(x, y) / (width * width));
  return {.corner = corners[0], .side_x = glm::vec3(x), .side_y = glm::vec3(upright)};
}

std::vector<Portal> PortalsOfMesh(const Mesh& mesh) {
  std::vector<std::array<glm::vec3, 3>> triangles;
  for (const glm::uvec3& t : mesh.triangles) {
    triangles.push_back({mesh.positions[t.x], mesh.positions[t.y], mesh.positions[t.z]});
  }
  if (triangles.size() > 2 * kMaxPortals) {
    throw InputError({}, fmt::format("the mesh '{}' has {} triangles; at most {} rectangles of two "
                                     "triangles can be portals",
                                     mesh.name, triangles.size(), kMaxPortals));
  }
  std::vector<Portal> portals;
  while (!triangles.empty()) {
    const std::array<glm::vec3, 3> triangle = triangles.back();
    triangles.pop_back();
    bool joined = false;
    for (std::size_t i = 0; i < triangles.size() && !joined; ++i) {
      const auto corners = Joined(triangle, triangles[i]);
      if (!corners) continue;
      try {
        portals.push_back(PortalOfCorners(*corners));
      } catch (const InputError&) {
        continue;  // another one may fit
      }
      triangles.erase(triangles.begin() + std::ptrdiff_t(i));
      joined = true;
    }
    if (!joined) {
      throw InputError({}, fmt::format("the mesh '{}' is not made of rectangles: nothing completes "
                                       "its triangle at {}",
                                       mesh.name, Text(triangle[0])));
    }
  }
  return portals;
}

}  // namespace skywave
