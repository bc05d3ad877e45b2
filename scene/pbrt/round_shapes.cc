#include "scene/pbrt/round_shapes.h"

#include <fmt/format.h>

#include <algorithm>
#include <iterator>

#include "base/error.h"
#include "scene/shapes/patches.h"
#include "scene/shapes/shapes.h"

namespace skywave {
namespace {

// Returns a number that must be above zero.
float FindPositive(PbrtParameters& parameters, std::string_view name, float otherwise) {
  const float value = FindFloat(parameters, name).value_or(otherwise);
  if (!(value > 0)) {
    throw InputError(parameters.position,
                     fmt::format("{}: the {} is {}", parameters.directive, name, value));
  }
  return value;
}

float FindPhi(PbrtParameters& parameters) {
  return std::min(FindPositive(parameters, "phimax", 360), 360.0f);
}

// Holds "zmin" and "zmax" in order. Reading them throws InputError if they are equal.
struct Range {
  float low, high;
};
Range FindRange(PbrtParameters& parameters, float low, float high) {
  const float z0 = FindFloat(parameters, "zmin").value_or(low),
              z1 = FindFloat(parameters, "zmax").value_or(high);
  if (z0 == z1) {
    throw InputError(parameters.position,
                     fmt::format("{}: zmin and zmax are both {}", parameters.directive, z0));
  }
  return {std::min(z0, z1), std::max(z0, z1)};
}

// A whole sphere is built without poles and seam, unless texture coordinates need them.
Mesh MakeSphere(PbrtParameters& parameters, bool needs_uvs) {
  const float radius = FindPositive(parameters, "radius", 1);
  const float phi = FindPhi(parameters);
  const auto [z0, z1] = FindRange(parameters, -radius, radius);
  const float low = std::clamp(z0, -radius, radius), high = std::clamp(z1, -radius, radius);
  const bool whole = low == -radius && high == radius && phi == 360;
  return whole && !needs_uvs ? Sphere(radius) : SpherePatch(radius, low, high, phi);
}

Mesh MakeDisk(PbrtParameters& parameters, bool) {
  const float radius = FindPositive(parameters, "radius", 1);
  const float inner = FindFloat(parameters, "innerradius").value_or(0);
  if (!(inner >= 0 && inner < radius)) {
    throw InputError(parameters.position,
                     fmt::format("{}: the innerradius {} is not between 0 and the radius",
                                 parameters.directive, inner));
  }
  const float height = FindFloat(parameters, "height").value_or(0);
  return DiskPatch(radius, inner, height, FindPhi(parameters));
}

Mesh MakeCylinder(PbrtParameters& parameters, bool) {
  const float radius = FindPositive(parameters, "radius", 1);
  const auto [low, high] = FindRange(parameters, -1, 1);
  return CylinderPatch(radius, low, high, FindPhi(parameters));
}

Mesh MakeCone(PbrtParameters& parameters, bool) {
  const float radius = FindPositive(parameters, "radius", 1);
  return ConePatch(radius, FindPositive(parameters, "height", 1), FindPhi(parameters));
}

Mesh MakeParaboloid(PbrtParameters& parameters, bool) {
  const float radius = FindPositive(parameters, "radius", 1);
  const auto [low, high] = FindRange(parameters, 0, 1);
  if (!(low >= 0)) {
    throw InputError(parameters.position,
                     fmt::format("{}: zmin is {}, below the apex", parameters.directive, low));
  }
  return ParaboloidPatch(radius, low, high, FindPhi(parameters));
}

glm::vec3 FindPoint(PbrtParameters& parameters, std::string_view name, const glm::vec3& otherwise) {
  const PbrtParameter* const found = Find(parameters, {"point", "point3"}, name);
  if (found == nullptr || found->floats.size() < 3) return otherwise;
  return {found->floats[0], found->floats[1], found->floats[2]};
}

struct Line {
  glm::dvec3 p1, p2;
};
Line FindLine(PbrtParameters& parameters) {
  return {FindPoint(parameters, "p1", {0, 0, 0}), FindPoint(parameters, "p2", {1, 1, 1})};
}

// Whether a line (a + b z, z) that turns about the z axis is nearest to it at z = 0, that is, a and
// b are at right angles. pbrt-v3 looks for a r^2 - c z^2 = 1 through points of the line, which is
// its surface only then.
bool HasWaistAtOrigin(const Line& line) {
  const glm::dvec3 d = line.p2 - line.p1;
  if (d.z == 0) return line.p1.z == 0;
  const glm::dvec2 b = glm::dvec2(d) / d.z, a = glm::dvec2(line.p1) - line.p1.z * b;
  return std::abs(glm::dot(a, b)) <= 1e-4 * (glm::dot(a, a) + glm::dot(b, b));
}

Mesh MakeHyperboloid(PbrtParameters& parameters, bool) {
  const auto [p1, p2] = FindLine(parameters);
  if (p1 == p2) {
    throw InputError(parameters.position, parameters.directive + ": p1 and p2 are the same point");
  }
  // pbrt puts the point that is not in the plane of the origin second.
  return p2.z == 0 ? HyperboloidPatch(p2, p1, FindPhi(parameters))
                   : HyperboloidPatch(p1, p2, FindPhi(parameters));
}

struct RoundShape {
  std::string_view type;
  std::vector<std::string_view> numbers;  // that make its form
  Mesh (*make)(PbrtParameters& parameters, bool needs_uvs);
};
const RoundShape kRoundShapes[] = {
    {"sphere", {"radius", "zmin", "zmax", "phimax"}, MakeSphere},
    {"disk", {"radius", "innerradius", "height", "phimax"}, MakeDisk},
    {"cylinder", {"radius", "zmin", "zmax", "phimax"}, MakeCylinder},
    {"cone", {"radius", "height", "phimax"}, MakeCone},
    {"paraboloid", {"radius", "zmin", "zmax", "phimax"}, MakeParaboloid},
    {"hyperboloid", {"p1", "p2", "phimax"}, MakeHyperboloid},
};

const RoundShape* FindRoundShape(std::string_view type) {
  const auto found = std::find_if(std::begin(kRoundShapes), std::end(kRoundShapes),
                                  [&](const RoundShape& shape) { return shape.type == type; });
  return found == std::end(kRoundShapes) ? nullptr : &*found;
}

}  // namespace

bool IsRoundPbrtShape(std::string_view type) { return FindRoundShape(type) != nullptr; }

PbrtRoundNumbers FindRoundNumbers(std::string_view type, PbrtParameters& parameters) {
  PbrtRoundNumbers round;
  bool whole = type == "sphere";
  for (const std::string_view name : FindRoundShape(type)->numbers) {
    const PbrtParameter* const found = Find(parameters, {"float", "point", "point3"}, name);
    whole = whole && (found == nullptr || name == "radius");
    if (found == nullptr) {
      round.numbers.emplace_back();
    } else {
      round.numbers.insert(round.numbers.end(), found->floats.begin(), found->floats.end());
    }
  }
  if (!whole) return round;
  round.numbers.clear();
  round.scale = FindPositive(parameters, "radius", 1);
  std::erase_if(parameters.list, [](const auto& parameter) {
    return parameter.name == "radius" && parameter.type == "float";
  });
  return round;
}

Mesh MakeRoundPbrtShape(std::string_view type, PbrtParameters& parameters, bool needs_uvs,
                        Warnings& warnings) {
  if (type == "hyperboloid" && !HasWaistAtOrigin(FindLine(parameters))) {
    AddWarning(warnings, parameters.position,
               parameters.directive +
                   ": it is what the line from p1 to p2 sweeps; pbrt-v3 intersects another surface "
                   "where that is not thinnest at z = 0");
  }
  return FindRoundShape(type)->make(parameters, needs_uvs);
}

}  // namespace skywave
