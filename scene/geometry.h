// A scene as rays and kernels see it: one Embree scene of all triangles, and the packed tables that
// shading reads at a hit.
#pragma once

#include <embree3/rtcore.h>

#include <atomic>
#include <cstdint>
#include <memory>
#include <string>
#include <type_traits>
#include <vector>

#include "kernels/bsdf/bsdf.h"
#include "kernels/columns.h"
#include "kernels/partition.h"
#include "kernels/surface/normal_map.h"
#include "kernels/surface/texture.h"
#include "scene/materials/opacity.h"
#include "scene/materials/texture_tables.h"
#include "scene/scene.h"

namespace skywave {

// A mesh in the tables of Geometry.
struct MeshPlace {
  std::uint32_t mesh;  // index into Scene::meshes
  std::uint32_t first_triangle, first_vertex;
};

// Immutable once built. Triangle i of the records is primitive i of Embree geometry 0. Where rays
// may pass through a material, its meshes come last and are geometry 1, which asks at every hit.
// Behind all triangles lie the variants of those whose material is a mixture (kMixedTriangle).
class Geometry {
 public:
  Geometry(const Geometry&) = delete;  // Embree keeps addresses of its members
  Geometry& operator=(const Geometry&) = delete;
  // Checks every index and coordinate (InputError names `path` and the mesh), turns triangles whose
  // vertex normals point the other way, packs the tables and builds the BVH on `threads` threads
  // (0: all). `embree_config` is handed to rtcNewDevice; empty stands for DefaultEmbreeConfig().
  // `keep_uvs`: the coordinates of the corners are kept even if no material has a texture.
  Geometry(const Scene& scene, const std::string& path, int threads = 0,
           const std::string& embree_config = "", bool keep_uvs = false);

  RTCScene scene() const { return scene_.get(); }
  const TriangleRecord* triangles() const { return triangles_.data(); }
  MaterialView materials() const;
  TextureView textures() const;  // empty: no material has one
  NormalMapView normal_maps() const;
  const TriangleUvs* uvs() const { return textures_.uvs.data(); }  // by record, where kept
  BsdfSet bsdfs() const { return bsdfs_; }
  // Three a triangle record, for TintByVertices; null: no mesh has colours.
  const std::uint32_t* vertex_colors() const {
    return vertex_colors_.empty() ? nullptr : vertex_colors_.data();
  }
  bool absorbs() const { return absorbs_; }  // whether light is lost inside some material
  // One a triangle record, for PrepareTangents; null: no BSDF has one.
  const std::uint32_t* tangents() const { return tangents_.data(); }
  bool has_mixtures() const { return has_mixtures_; }
  std::size_t triangle_count() const { return indices_.size() / 3; }
  std::size_t record_count() const { return triangles_.size(); }  // variants included
  // The first triangle of geometry 1; triangle_count() if there is none.
  std::uint32_t first_with_alpha() const { return first_with_alpha_; }
  bool has_alpha() const { return first_with_alpha_ < triangle_count(); }
  const OpacityView& opacity() const { return alpha_filter_.opacity; }  // where there are holes
  // All meshes, in the order of their triangles.
  const std::vector<MeshPlace>& meshes() const { return meshes_; }
  // The triangle that a record is of: itself, or what it is a variant of.
  std::uint32_t TriangleOf(std::uint32_t record) const;
  // The index in Scene::meshes of the mesh that a triangle record is of.
  std::uint32_t MeshOf(std::uint32_t record) const { return PlaceOf(TriangleOf(record)).mesh; }
  // Where corner 0, 1 or 2 of a triangle is, in the order that decides its geometric normal.
  glm::vec3 Corner(std::size_t triangle, int corner) const;
  std::size_t bytes() const;  // of vertices, indices and tables, without the BVH
  std::size_t bvh_bytes() const { return std::size_t(embree_bytes_.load()); }
  double build_seconds() const { return build_seconds_; }

 private:
  void AppendVariants(const Scene& scene, std::size_t i);
  void MakeMapAxes(const Scene& scene);
  const MeshPlace& PlaceOf(std::uint32_t triangle) const;

  struct Release {
    void operator()(RTCDevice device) const { rtcReleaseDevice(device); }
    void operator()(RTCScene scene) const { rtcReleaseScene(scene); }
  };
  std::atomic<std::int64_t> embree_bytes_ = 0;  // first: the device counts until it is released
  std::unique_ptr<std::remove_pointer_t<RTCDevice>, Release> device_;
  std::unique_ptr<std::remove_pointer_t<RTCScene>, Release> scene_;
  std::vector<float> vertices_;         // xyz, one float of padding at the end
  std::vector<std::uint32_t> indices_;  // three a triangle
  std::vector<TriangleRecord> triangles_;
  std::vector<MeshPlace> meshes_;
  std::vector<std::uint32_t> mixed_;  // of every variant: the record that it is one of
  std::vector<MaterialRecord> materials_;
  BsdfSet bsdfs_ = 0;                         // of the triangles
  std::vector<std::uint32_t> tangents_;       // empty: no BSDF has one
  std::vector<std::uint32_t> vertex_colors_;  // packed as texels; empty: no mesh has them
  bool absorbs_ = false;
  std::vector<float> measured_;
  bool has_mixtures_ = false;
  TextureTables textures_;
  std::vector<NormalMapRecord> normal_maps_;  // by material; empty if there are none
  std::vector<TriangleTangents> map_axes_;    // by record; empty if there are none
  std::vector<OpacityRecord> opacity_;        // by material; empty if there are no holes
  AlphaFilter alpha_filter_ = {};
  std::uint32_t first_with_alpha_ = 0;
  const ConductorTables* conductor_tables_ = nullptr;  // null: no material needs them
  const SheenTables* sheen_tables_ = nullptr;          // likewise
  double build_seconds_ = 0;
};

// "isa=avx2" where the processor has it: hits then have the same bits on every such machine, and on
// AVX-512 machines nothing is lost (measured: docs/benchmarks.md).
std::string DefaultEmbreeConfig();

}  // namespace skywave
