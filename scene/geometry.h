// A scene as rays and kernels see it: Embree's scenes of the world and of each object, and the
// packed tables that shading reads at a hit.
#pragma once

#include <cstddef>
#include <cstdint>
#include <memory>
#include <span>
#include <string>
#include <vector>

#include "kernels/bsdf/bsdf.h"
#include "kernels/columns.h"
#include "kernels/partition.h"
#include "kernels/surface/normal_map.h"
#include "kernels/surface/opacity.h"
#include "kernels/surface/surface.h"
#include "kernels/surface/texture.h"
#include "scene/embree_scene.h"
#include "scene/geometry_tables.h"
#include "scene/scene.h"

namespace skywave {

// A Geometry does not change once it is built. The records of triangles are those of the world,
// then those of each object (TriangleSpan), then the variants of all whose material is a mixture
// (kMixedTriangle).
class Geometry {
 public:
  Geometry(const Geometry&) = delete;  // Embree keeps addresses of its tables
  Geometry& operator=(const Geometry&) = delete;
  // Checks every index and coordinate (InputError names `path` and the mesh), turns triangles whose
  // vertex normals point the other way, packs the tables and builds the BVH on `threads` threads
  // (0: all). Embree gets `embree_config`; empty stands for DefaultEmbreeConfig(). With `keep_uvs`
  // the coordinates of the corners are kept even if no material has a texture. The BVH is that of
  // `twin`, made with the same threads and configuration, if both have the same triangles and no
  // ray passes through any: then they differ in materials only.
  Geometry(const Scene& scene, const std::string& path, int threads = 0,
           const std::string& embree_config = "", bool keep_uvs = false,
           const std::shared_ptr<const Geometry>& twin = nullptr);

  RTCScene scene() const { return embree_->scene(); }
  const TriangleRecord* triangles() const { return tables_.triangles.data(); }
  TriangleTables triangle_tables() const {
    return {triangles(), tables_.corners.data(), tables_.vertices.data(), instances()};
  }
  MaterialView materials() const;
  TextureView textures() const;  // empty: no material has one
  NormalMapView normal_maps() const { return tables_.normal_maps.view(); }
  NormalMapView base_normal_maps() const { return tables_.base_normal_maps.view(); }
  const TriangleUvs* uvs() const { return tables_.textures.uvs.data(); }  // by record, where kept
  BsdfSet bsdfs() const { return tables_.bsdfs; }
  // Whether there are mirrors or clear glass.
  bool has_deltas() const { return (tables_.bsdfs >> kFirstDeltaBsdf) != 0; }
  // Three per triangle record, for TintByVertices; null: no mesh has colours.
  const std::uint32_t* vertex_colors() const {
    return tables_.vertex_colors.empty() ? nullptr : tables_.vertex_colors.data();
  }
  const glm::vec3& origin() const { return origin_; }  // Scene::origin
  bool absorbs() const { return tables_.absorbs; }     // whether light is lost inside some material
  // One per triangle record, for PrepareTangents; null: no BSDF has one.
  const std::uint32_t* tangents() const { return tables_.tangents.data(); }
  bool has_one_sided() const { return tables_.one_sided; }  // triangles (kOneSidedTriangle)
  // By material: 1 for catchers, or for holdouts; null: there are none.
  const std::uint8_t* catchers() const {
    return tables_.catchers.empty() ? nullptr : tables_.catchers.data();
  }
  const std::uint8_t* holdouts() const {
    return tables_.holdouts.empty() ? nullptr : tables_.holdouts.data();
  }
  // Returns the material of the triangle that a record is of: the mixture, if it is one of two.
  std::uint32_t MaterialOfRecord(std::uint32_t record) const {
    return MaterialOf(tables_.triangles[TriangleOf(record)]);
  }
  bool IsCatcher(std::uint32_t record) const {
    return !tables_.catchers.empty() && tables_.catchers[MaterialOfRecord(record)] != 0;
  }
  bool has_mixtures() const { return !tables_.mixed.empty(); }
  std::size_t triangle_count() const { return tables_.triangle_count(); }
  std::size_t vertex_count() const { return tables_.vertex_count(); }
  std::size_t record_count() const { return tables_.triangles.size(); }  // variants included
  // The first triangle of the world that rays may pass through, or the end of the world's.
  std::uint32_t first_with_alpha() const { return tables_.spans.front().first_with_alpha; }
  bool has_alpha() const { return tables_.has_alpha(); }   // objects included
  const OpacityView& opacity() const { return opacity_; }  // where there are holes
  // The world's meshes, in the order of their triangles.
  std::span<const MeshPlace> meshes() const {
    return std::span(tables_.meshes).first(tables_.meshes_in_world);
  }
  std::size_t instance_count() const { return tables_.instances.size(); }
  // Of the world, then of each instance; null: there is none.
  const InstanceRecord* instances() const {
    return tables_.instances.empty() ? nullptr : tables_.instance_records.data();
  }
  const TrianglePlaces* places() const {
    return tables_.instances.empty() ? nullptr : &tables_.places;
  }
  // Returns the triangle that a record is of: itself, or the one that it is a variant of.
  std::uint32_t TriangleOf(std::uint32_t record) const { return tables_.TriangleOf(record); }
  // Returns the mesh that a triangle record is of, as MeshPlace counts them.
  std::uint32_t MeshOf(std::uint32_t record) const {
    return tables_.PlaceOf(TriangleOf(record)).mesh;
  }
  // The number of meshes, those of objects included.
  std::size_t mesh_count() const { return tables_.meshes.size(); }
  // Returns the position of corner 0, 1 or 2 of a triangle, in the order that decides its geometric
  // normal and in the space of its mesh.
  glm::vec3 Corner(std::size_t triangle, int corner) const;
  std::size_t bytes() const { return tables_.bytes(); }                         // without the BVH
  std::size_t bvh_bytes() const { return shares_bvh_ ? 0 : embree_->bytes(); }  // of its own
  double build_seconds() const { return shares_bvh_ ? 0 : embree_->build_seconds(); }

 private:
  const glm::vec3 origin_;
  const GeometryTables tables_;
  const OpacityView opacity_;
  const bool shares_bvh_;
  const std::shared_ptr<const EmbreeScene> embree_;  // keeps the twin that it is shared with
};

}  // namespace skywave
