// The tables of a scene: the triangles that Embree builds over, and the packed records that kernels
// read at a hit.
#pragma once

#include <cstddef>
#include <cstdint>
#include <string>
#include <vector>

#include "kernels/bsdf/bsdf.h"
#include "kernels/bsdf/coat_tables.h"
#include "kernels/columns.h"
#include "kernels/partition.h"
#include "kernels/surface/normal_map.h"
#include "kernels/surface/opacity.h"
#include "scene/materials/texture_tables.h"
#include "scene/scene.h"

namespace skywave {

// A mesh in the tables.
struct MeshPlace {
  std::uint32_t mesh;  // index into Scene::meshes
  std::uint32_t first_triangle, first_vertex;
};

// Meshes through whose material rays may pass come last. Behind all triangles lie the variants of
// those whose material is a mixture (kMixedTriangle). A table that no kernel reads in a scene is
// empty or null.
struct GeometryTables {
  std::vector<float> vertices;               // xyz, one float of padding at the end
  std::vector<std::uint32_t> indices;        // three per triangle
  std::vector<MeshPlace> meshes;             // all meshes, in the order of their triangles
  std::uint32_t first_with_alpha = 0;        // first triangle that rays may pass through
  std::vector<TriangleRecord> triangles;     // the records: triangles, then variants
  std::vector<std::uint32_t> mixed;          // of every variant: the record that it is a variant of
  std::vector<std::uint32_t> tangents;       // by record, for PrepareTangents
  std::vector<std::uint32_t> vertex_colors;  // three per record, packed as texels
  std::vector<TriangleTangents> map_axes;    // by record, for BendNormals
  BsdfSet bsdfs = 0;                         // those of the triangles

  std::vector<MaterialRecord> materials;
  std::vector<NormalMapRecord> normal_maps;  // by material
  std::vector<OpacityRecord> opacity;        // by material
  bool absorbs = false;                      // light is lost inside some material
  std::vector<float> measured;
  std::vector<CoatTable> coats;  // by kCoatTable of the materials that have one
  const ConductorTables* ggx = nullptr;
  const SheenTables* sheen = nullptr;
  TextureTables textures;

  std::size_t vertex_count() const { return vertices.size() / 3; }
  std::size_t triangle_count() const { return indices.size() / 3; }
  bool has_alpha() const { return first_with_alpha < triangle_count(); }
  // Returns the triangle that a record is of: itself, or the one that it is a variant of.
  std::uint32_t TriangleOf(std::uint32_t record) const;
  const MeshPlace& PlaceOf(std::uint32_t triangle) const;
  OpacityView opacity_view() const;
  std::size_t bytes() const;
};

// Checks the scene (geometry_checks.h), turns triangles whose vertex normals point the other way,
// and packs everything. With `keep_uvs` the coordinates of the corners are kept even if no material
// has a texture. Throws InputError(path).
GeometryTables MakeGeometryTables(const Scene& scene, const std::string& path, bool keep_uvs);

}  // namespace skywave
