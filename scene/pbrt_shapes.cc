#include "scene/pbrt_shapes.h"

#include <fmt/format.h>

#include "base/error.h"
#include "scene/loop_subdivision.h"
#include "scene/ply.h"
#include "scene/shapes.h"

namespace skywave {
namespace {

using TypeNames = std::initializer_list<std::string_view>;

std::vector<glm::vec3> FindVectors(PbrtParameters& parameters, TypeNames types,
                                   std::string_view name) {
  const PbrtParameter* found = Find(parameters, types, name);
  std::vector<glm::vec3> vectors;
  if (!found) return vectors;
  vectors.reserve(found->floats.size() / 3);
  for (std::size_t i = 0; i + 2 < found->floats.size(); i += 3) {
    vectors.emplace_back(found->floats[i], found->floats[i + 1], found->floats[i + 2]);
  }
  return vectors;
}

std::vector<glm::vec3> RequirePositions(PbrtParameters& parameters) {
  std::vector<glm::vec3> positions = FindVectors(parameters, {"point", "point3"}, "P");
  if (positions.empty()) {
    throw InputError(parameters.position, parameters.directive + " needs vertices \"point3 P\"");
  }
  return positions;
}

std::vector<glm::uvec3> RequireTriangles(PbrtParameters& parameters, std::size_t vertices) {
  const PbrtParameter* found = Find(parameters, {"integer"}, "indices");
  if (!found) {
    // pbrt-v4: three vertices need no indices.
    if (vertices == 3) return {glm::uvec3(0, 1, 2)};
    throw InputError(parameters.position, parameters.directive + " needs \"integer indices\"");
  }
  const std::vector<std::int32_t>& indices = found->ints;
  if (indices.empty() || indices.size() % 3 != 0) {
    throw InputError(found->position, fmt::format("{}: {} indices are no triangles",
                                                  parameters.directive, indices.size()));
  }
  std::vector<glm::uvec3> triangles(indices.size() / 3);
  for (std::size_t i = 0; i < indices.size(); ++i) {
    if (indices[i] < 0 || static_cast<std::size_t>(indices[i]) >= vertices) {
      throw InputError(found->position,
                       fmt::format("{}: index {} (number {}) is not in 0..{}, the vertices given",
                                   parameters.directive, indices[i], i, vertices - 1));
    }
    triangles[i / 3][static_cast<int>(i % 3)] = static_cast<std::uint32_t>(indices[i]);
  }
  return triangles;
}

void CheckPerVertex(const PbrtParameters& parameters, std::string_view name, std::size_t count,
                    std::size_t vertices) {
  if (count != 0 && count != vertices) {
    throw InputError(parameters.position, fmt::format("{}: {} \"{}\" for {} vertices",
                                                      parameters.directive, count, name, vertices));
  }
}

std::vector<glm::vec2> FindUvs(PbrtParameters& parameters) {
  std::vector<glm::vec2> uvs;
  for (const std::string_view name : {"uv", "st"}) {
    const PbrtParameter* found = Find(parameters, {"point2", "float"}, name);
    if (!found || !uvs.empty()) continue;
    if (found->floats.size() % 2 != 0) {
      throw InputError(found->position,
                       fmt::format("{}: {} values of \"{}\" are no pairs", parameters.directive,
                                   found->floats.size(), name));
    }
    for (std::size_t i = 0; i < found->floats.size(); i += 2) {
      uvs.emplace_back(found->floats[i], found->floats[i + 1]);
    }
  }
  return uvs;
}

Mesh TriangleMesh(PbrtParameters& parameters) {
  Mesh mesh;
  mesh.positions = RequirePositions(parameters);
  mesh.triangles = RequireTriangles(parameters, mesh.positions.size());
  mesh.normals = FindVectors(parameters, {"normal", "normal3"}, "N");
  mesh.uvs = FindUvs(parameters);
  CheckPerVertex(parameters, "N", mesh.normals.size(), mesh.positions.size());
  CheckPerVertex(parameters, "uv", mesh.uvs.size(), mesh.positions.size());
  NormalizeNormals(mesh);
  // As pbrt, which turns the geometric normal to the side of the shading normals.
  AlignWindingWithNormals(mesh);
  return mesh;
}

Mesh PlyMesh(PbrtParameters& parameters,
             const std::function<std::string(const std::string&)>& resolve) {
  const auto filename = FindString(parameters, "filename");
  if (!filename) {
    throw InputError(parameters.position, parameters.directive + " needs a \"string filename\"");
  }
  try {
    return ReadPly(resolve(*filename));
  } catch (const InputError& error) {
    // Both places: the mesh's, and that of the scene that asks for it.
    throw InputError(parameters.position, error.what(), error.exit_code());
  }
}

Mesh LoopSubdivisionSurface(PbrtParameters& parameters, Warnings& warnings) {
  const std::vector<glm::vec3> positions = RequirePositions(parameters);
  const std::vector<glm::uvec3> triangles = RequireTriangles(parameters, positions.size());
  const auto v4_levels = FindInt(parameters, "levels"), v3_levels = FindInt(parameters, "nlevels");
  const int levels = v4_levels.value_or(v3_levels.value_or(3));
  std::size_t count = triangles.size();
  for (int level = 0; level < levels && count <= kMaxSubdividedTriangles; ++level) count *= 4;
  if (levels < 0 || count > kMaxSubdividedTriangles) {
    throw InputError(parameters.position,
                     fmt::format("{}: {} levels are negative or make more than {} triangles",
                                 parameters.directive, levels, kMaxSubdividedTriangles));
  }
  const std::string scheme = FindString(parameters, "scheme").value_or("loop");
  if (scheme != "loop") {
    AddWarning(warnings, parameters.position,
               fmt::format("{}: scheme \"{}\" is not supported: loop is used", parameters.directive,
                           scheme));
  }
  return LoopSubdivide(positions, triangles, levels);
}

Mesh PbrtSphere(PbrtParameters& parameters, Warnings& warnings) {
  const float radius = FindFloat(parameters, "radius").value_or(1);
  if (!(radius > 0)) {
    throw InputError(parameters.position,
                     fmt::format("{}: the radius is {}", parameters.directive, radius));
  }
  const float low = FindFloat(parameters, "zmin").value_or(-radius);
  const float high = FindFloat(parameters, "zmax").value_or(radius);
  const float phi = FindFloat(parameters, "phimax").value_or(360);
  if (std::min(low, high) > -radius || std::max(low, high) < radius || phi < 360) {
    AddWarning(
        warnings, parameters.position,
        parameters.directive + ": parts of spheres are not supported: the whole is rendered");
  }
  return Sphere(radius);
}

}  // namespace

std::optional<Mesh> MakePbrtShape(const std::string& type, PbrtParameters& parameters,
                                  const std::function<std::string(const std::string&)>& resolve,
                                  Warnings& warnings) {
  std::optional<Mesh> mesh;
  if (type == "trianglemesh") {
    mesh = TriangleMesh(parameters);
  } else if (type == "plymesh") {
    mesh = PlyMesh(parameters, resolve);
  } else if (type == "loopsubdiv") {
    mesh = LoopSubdivisionSurface(parameters, warnings);
  } else if (type == "sphere") {
    mesh = PbrtSphere(parameters, warnings);
  } else {
    AddWarning(warnings, parameters.position, parameters.directive + " is not supported: left out");
    return std::nullopt;
  }
  ReportUnused(parameters, warnings);
  return mesh;
}

}  // namespace skywave
