// The tables of a scene: the triangles that Embree builds over, and the packed records that kernels
// read at a hit.
#pragma once

#include <cstddef>
#include <cstdint>
#include <string>
#include <vector>

#include "kernels/bsdf/bsdf.h"
#include "kernels/bsdf/coat_tables.h"
#include "kernels/bsdf/dielectric_tables.h"
#include "kernels/columns.h"
#include "kernels/partition.h"
#include "kernels/surface/instances.h"
#include "kernels/surface/opacity.h"
#include "scene/embree_scene.h"
#include "scene/materials/normal_map_tables.h"
#include "scene/materials/texture_tables.h"
#include "scene/scene.h"

namespace skywave {

// A mesh in the tables.
struct MeshPlace {
  std::uint32_t mesh;  // index into Scene::meshes; on from there, into those of Scene::objects
  std::uint32_t first_triangle, first_vertex;
};

// The triangles of the world come first, then those of each object; among them, meshes through
// whose material rays may pass come last. After all triangles come the variants of those whose
// material is a mixture (kMixedTriangle). A table that no kernel reads in a scene is empty or null.
struct GeometryTables {
  std::vector<float> vertices;         // xyz in the space of the mesh, one float of padding
  std::vector<std::uint32_t> corners;  // three vertices per record, one word of padding
  std::vector<MeshPlace> meshes;       // all meshes, in the order of their triangles
  std::uint32_t meshes_in_world = 0;   // of `meshes`; the others are in objects
  std::vector<TriangleSpan> spans;     // of the world, then of each object
  std::vector<EmbreeInstance> instances;
  std::vector<InstanceRecord> instance_records;  // of the world, then of each instance
  TrianglePlaces places;                         // likewise
  std::vector<TriangleRecord> triangles;         // the records: triangles, then variants
  std::vector<std::uint32_t> mixed;          // of every variant: the record that it is a variant of
  std::vector<std::uint32_t> tangents;       // by record, for PrepareTangents
  std::vector<std::uint32_t> vertex_colors;  // three per record, packed as texels
  std::vector<float> vertex_alphas;          // three per triangle, for OpacityView
  BsdfSet bsdfs = 0;                         // those of the triangles
  bool one_sided = false;                    // camera rays pass through the back of some triangle
  std::vector<std::uint8_t> catchers;        // by material, 1 for catchers; empty: there are none
  std::vector<std::uint8_t> holdouts;        // likewise
  bool has_unshadowed = false;               // some surface throws no shadow of some light
  // Whether some rays pass through surfaces that others meet.
  bool calls_filter() const { return one_sided || !catchers.empty() || has_unshadowed; }

  std::vector<MaterialRecord> materials;
  NormalMapTables normal_maps;         // for BendNormals
  NormalMapTables base_normal_maps;    // for WriteBaseNormals
  std::vector<OpacityRecord> opacity;  // by material
  bool varied = false;                 // MaterialView::varied
  bool two_widths = false;             // MaterialView::two_widths
  bool glass_layers = false;           // MaterialView::glass_layers
  bool absorbs = false;                // light is lost inside some material
  std::vector<float> measured;
  std::vector<CoatTable> coats;              // by kCoatTable of the materials that have one
  std::vector<DielectricTable> dielectrics;  // likewise by kDielectricTable
  const ConductorTables* ggx = nullptr;
  const SheenTables* sheen = nullptr;
  const AnisotropicTables* anisotropic = nullptr;
  TextureTables textures;

  std::size_t vertex_count() const { return vertices.size() / 3; }
  std::size_t triangle_count() const { return triangles.size() - mixed.size(); }
  bool has_alpha() const;  // whether rays may pass through some triangle
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
