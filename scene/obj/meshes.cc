#include "scene/obj/meshes.h"

#include <fmt/format.h>

#include <algorithm>
#include <cstdint>
#include <span>
#include <utility>

#include "base/error.h"
#include "scene/shapes/mesh.h"
#include "scene/shapes/points.h"
#include "scene/shapes/smooth_normals.h"

namespace skywave {
namespace {

struct ObjTriangle {
  static constexpr std::uint32_t kFlat = 0xFFFFFFFFu;

  tinyobj::index_t corner[3];
  std::uint32_t material = 0, group = 0;
  bool has_normals = false;    // all corners have a normal in the file
  std::uint32_t computed = 0;  // index into SmoothCornerNormals' result if it has none

  bool smooth() const { return has_normals || computed != kFlat; }
};

std::vector<ObjTriangle> CollectTriangles(const tinyobj::attrib_t& attributes,
                                          const std::vector<tinyobj::shape_t>& shapes,
                                          bool has_smoothing, std::size_t materials,
                                          const std::string& path) {
  // The check before has ensured all of this; reading a table at a wrong index would crash.
  const auto inside = [](int index, std::size_t count) {
    return index >= -1 && static_cast<std::size_t>(index + 1) <= count;
  };
  std::vector<ObjTriangle> triangles;
  for (const tinyobj::shape_t& shape : shapes) {
    for (std::size_t i = 0; i + 2 < shape.mesh.indices.size(); i += 3) {
      ObjTriangle t;
      t.has_normals = true;
      for (int c = 0; c < 3; ++c) {
        t.corner[c] = shape.mesh.indices[i + c];
        if (t.corner[c].vertex_index < 0 ||
            !inside(t.corner[c].vertex_index, attributes.vertices.size() / 3) ||
            !inside(t.corner[c].normal_index, attributes.normals.size() / 3) ||
            !inside(t.corner[c].texcoord_index, attributes.texcoords.size() / 2)) {
          throw InputError(InputPosition::File(path), "a face has an index out of range");
        }
        t.has_normals = t.has_normals && t.corner[c].normal_index >= 0;
      }
      const int material = shape.mesh.material_ids.at(i / 3);
      t.material = material > 0 && static_cast<std::size_t>(material) < materials ? material : 0;
      t.group = shape.mesh.smoothing_group_ids.at(i / 3);
      if (!t.has_normals && has_smoothing && t.group == 0) t.computed = ObjTriangle::kFlat;
      triangles.push_back(t);
    }
  }
  return triangles;
}

std::vector<glm::vec3> Positions(const tinyobj::attrib_t& attributes) {
  std::vector<glm::vec3> positions(attributes.vertices.size() / 3);
  for (std::size_t i = 0; i < positions.size(); ++i) {
    positions[i] = {attributes.vertices[3 * i], attributes.vertices[3 * i + 1],
                    attributes.vertices[3 * i + 2]};
  }
  return positions;
}

// Returns the colours of the positions, which programs write in sRGB, if all have one.
std::vector<glm::vec3> Colors(const tinyobj::attrib_t& attributes) {
  if (attributes.colors.size() != attributes.vertices.size()) return {};
  std::vector<glm::vec3> colors(attributes.colors.size() / 3);
  for (std::size_t i = 0; i < colors.size(); ++i) {
    colors[i] = ColorOfSrgb(
        {attributes.colors[3 * i], attributes.colors[3 * i + 1], attributes.colors[3 * i + 2]});
  }
  return colors;
}

// Returns three normals for every smooth triangle that has none in the file; sets `computed`.
std::vector<glm::vec3> ComputeNormals(const std::vector<glm::vec3>& positions, bool has_smoothing,
                                      std::vector<ObjTriangle>& triangles) {
  std::vector<glm::uvec3> corners;
  std::vector<std::uint32_t> groups;
  for (ObjTriangle& t : triangles) {
    if (t.has_normals || t.computed == ObjTriangle::kFlat) continue;
    t.computed = static_cast<std::uint32_t>(corners.size());
    corners.emplace_back(t.corner[0].vertex_index, t.corner[1].vertex_index,
                         t.corner[2].vertex_index);
    if (has_smoothing) groups.push_back(t.group);
  }
  return corners.empty() ? std::vector<glm::vec3>()
                         : SmoothCornerNormals(positions, corners, groups);
}

constexpr std::uint32_t kNone = 0xFFFFFFFFu;

// Merges all corners with the same position, normal and texture coordinates into one vertex.
struct VertexFinder {
  explicit VertexFinder(std::size_t positions) : newest(positions, kNone) {}
  std::vector<std::uint32_t> newest;  // by position in the file: the vertex made from it last
  std::vector<std::uint32_t> before;  // by vertex: the previous one made from the same position
  std::vector<std::uint32_t> origin;  // by vertex: its position in the file
};

std::uint32_t FindOrAddVertex(VertexFinder& finder, std::uint32_t origin, const glm::vec3& position,
                              const glm::vec3* normal, const glm::vec2* uv, Mesh& mesh) {
  // Only hostile files have longer chains; for them, vertices may be duplicated.
  constexpr int kLongestChain = 64;
  int length = 0;
  for (std::uint32_t v = finder.newest[origin]; v != kNone && length < kLongestChain;
       v = finder.before[v], ++length) {
    if ((!normal || mesh.normals[v] == *normal) && (!uv || mesh.uvs[v] == *uv)) return v;
  }
  const auto vertex = static_cast<std::uint32_t>(mesh.positions.size());
  mesh.positions.push_back(position);
  if (normal) mesh.normals.push_back(*normal);
  if (uv) mesh.uvs.push_back(*uv);
  finder.before.push_back(finder.newest[origin]);
  finder.origin.push_back(origin);
  finder.newest[origin] = vertex;
  return vertex;
}

void Forget(VertexFinder& finder) {
  for (const std::uint32_t origin : finder.origin) finder.newest[origin] = kNone;
  finder.before.clear(), finder.origin.clear();
}

// The data that all meshes of a file share.
struct Source {
  const tinyobj::attrib_t& attributes;
  std::vector<glm::vec3> positions;
  std::vector<glm::vec3> colors;    // of the positions, or empty
  std::vector<glm::vec3> computed;  // normals, three per triangle
};

glm::vec3 NormalOf(const Source& source, const ObjTriangle& t, int corner) {
  if (!t.has_normals) return source.computed[3 * std::size_t{t.computed} + corner];
  const float* n = &source.attributes.normals[3 * std::size_t(t.corner[corner].normal_index)];
  return {n[0], n[1], n[2]};
}

glm::vec2 UvOf(const Source& source, const ObjTriangle& t, int corner) {
  if (t.corner[corner].texcoord_index < 0) return glm::vec2(0);
  const float* uv = &source.attributes.texcoords[2 * std::size_t(t.corner[corner].texcoord_index)];
  return {uv[0], uv[1]};
}

Mesh BuildMesh(const Source& source, std::span<const ObjTriangle* const> triangles,
               VertexFinder& finder) {
  const bool smooth = triangles.front()->smooth(), has_uvs = !source.attributes.texcoords.empty();
  Mesh mesh;
  mesh.material = triangles.front()->material;
  mesh.triangles.reserve(triangles.size());
  for (const ObjTriangle* t : triangles) {
    glm::uvec3 vertices;
    for (int c = 0; c < 3; ++c) {
      const auto origin = static_cast<std::uint32_t>(t->corner[c].vertex_index);
      const glm::vec3 normal = smooth ? NormalOf(source, *t, c) : glm::vec3(0);
      const glm::vec2 uv = UvOf(source, *t, c);
      vertices[c] = FindOrAddVertex(finder, origin, source.positions[origin],
                                    smooth ? &normal : nullptr, has_uvs ? &uv : nullptr, mesh);
    }
    mesh.triangles.push_back(vertices);
  }
  if (!source.colors.empty()) {
    for (const std::uint32_t origin : finder.origin) mesh.colors.push_back(source.colors[origin]);
  }
  Forget(finder);
  NormalizeNormals(mesh);
  AlignWindingWithNormals(mesh);
  return mesh;
}

}  // namespace

void BuildObjMeshes(const tinyobj::attrib_t& attributes,
                    const std::vector<tinyobj::shape_t>& shapes, bool has_smoothing,
                    const std::string& path, Scene& scene) {
  std::vector<ObjTriangle> triangles =
      CollectTriangles(attributes, shapes, has_smoothing, scene.materials.size(), path);
  Source source{attributes, Positions(attributes), Colors(attributes), {}};
  // Vertices with colours are of these, and not of the grey that stands for no material.
  if (!source.colors.empty()) scene.materials[0].reflectance = glm::vec3(1);
  source.computed = ComputeNormals(source.positions, has_smoothing, triangles);

  std::vector<const ObjTriangle*> order;
  for (const ObjTriangle& t : triangles) order.push_back(&t);
  const auto key = [](const ObjTriangle* t) { return std::pair(t->material, t->smooth()); };
  std::stable_sort(order.begin(), order.end(),
                   [&](const auto* a, const auto* b) { return key(a) < key(b); });
  VertexFinder finder(source.positions.size());
  for (std::size_t first = 0, last = 0; first < order.size(); first = last) {
    while (last < order.size() && key(order[last]) == key(order[first])) ++last;
    scene.meshes.push_back(
        BuildMesh(source, std::span(order).subspan(first, last - first), finder));
    scene.meshes.back().name = scene.materials[scene.meshes.back().material].name;
  }
}

void BuildObjPoints(const tinyobj::attrib_t& attributes, const ObjStatements& statements,
                    const ReadOptions& options, const std::string& path, Scene& scene,
                    Warnings& warnings) {
  Mesh vertices;
  vertices.positions = Positions(attributes);
  vertices.colors = Colors(attributes);
  vertices.name = "points";
  const bool named = statements.parts_line > 0;
  const bool cloud = !named && statements.faces == 0 && !vertices.positions.empty();
  if (!named && !cloud) return;
  if (!options.point_size) {
    AddWarning(warnings,
               named ? InputPosition::Line(path, statements.parts_line) : InputPosition::File(path),
               fmt::format("{} left out: `point-size {:g}` shows them",
                           named ? "points and lines are" : "vertices without faces are",
                           PointSizeFor(vertices.positions)));
    return;
  }
  if (!vertices.colors.empty()) scene.materials[0].reflectance = glm::vec3(1);
  scene.meshes.push_back(MakePoints(vertices, named ? statements.parts : AllPoints(vertices),
                                    *options.point_size, options.max_triangles, path));
}

}  // namespace skywave
