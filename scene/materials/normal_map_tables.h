// The maps that bend normals: by material, and how they lie on each triangle.
#pragma once

#include <cstddef>
#include <cstdint>
#include <functional>
#include <glm/vec3.hpp>
#include <optional>
#include <span>
#include <vector>

#include "kernels/columns.h"
#include "kernels/surface/normal_map.h"
#include "scene/materials/texture_tables.h"
#include "scene/scene.h"

namespace skywave {

// A material's texture of normals or heights.
struct NormalMap {
  std::optional<std::uint32_t> texture;
  float scale = 1;
  bool in_texels = false;  // Material::height_in_texels
  bool of_base = false;    // NormalMapRecord::of_base
};
// Returns that of a material or, under a coat with other normals, of the coat.
NormalMap MapOf(const Material& material);
// Returns that of what lies below such a coat.
NormalMap BaseMapOf(const Material& material);

struct NormalMapTables {
  std::vector<NormalMapRecord> records;  // by material; empty: no material has a map
  std::vector<TriangleTangents> axes;    // by record of a triangle
  std::vector<TriangleSlopes> slopes;    // likewise, where there are heights that are lengths
  NormalMapView view() const;            // valid as long as the tables stay where they are
  std::size_t bytes() const;
};

// The mesh of a triangle record, and its corners there.
struct RecordCorners {
  const Mesh& mesh;
  glm::uvec3 corners;
};

// Returns the tables of the maps that `map_of` names for the records `triangles`: variants of one
// triangle may have different maps.
NormalMapTables MakeNormalMaps(
    const Scene& scene, NormalMap map_of(const Material&), const TextureTables& textures,
    std::span<const TriangleRecord> triangles,
    const std::function<RecordCorners(std::uint32_t record)>& corners_of);

}  // namespace skywave
