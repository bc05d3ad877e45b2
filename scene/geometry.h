// A scene as rays and kernels see it: one Embree scene of all triangles, and the packed tables that
// shading reads at a hit.
#pragma once

#include <embree3/rtcore.h>

#include <cstdint>
#include <memory>
#include <string>
#include <type_traits>
#include <vector>

#include "kernels/bsdf.h"
#include "kernels/columns.h"
#include "kernels/partition.h"
#include "kernels/texture.h"
#include "scene/scene.h"
#include "scene/texture_tables.h"

namespace skywave {

// Immutable once built. Triangle i of the records is primitive i of the only Embree geometry;
// behind them lie the variants of triangles whose material is a mixture (kMixedTriangle).
class Geometry {
 public:
  // Checks every index and coordinate (InputError names `path` and the mesh), turns triangles whose
  // vertex normals point the other way, packs the tables and builds the BVH on `threads` threads
  // (0: all). `embree_config` is handed to rtcNewDevice; empty stands for DefaultEmbreeConfig().
  // `keep_uvs`: the coordinates of the corners are kept even if no material has a texture.
  Geometry(const Scene& scene, const std::string& path, int threads = 0,
           const std::string& embree_config = "", bool keep_uvs = false);

  RTCScene scene() const { return scene_.get(); }
  const TriangleRecord* triangles() const { return triangles_.data(); }
  MaterialView materials() const;
  TextureView textures() const;                                    // empty: no material has one
  const TriangleUvs* uvs() const { return textures_.uvs.data(); }  // by triangle, where kept
  BsdfSet bsdfs() const { return bsdfs_; }
  // One a triangle record, for PrepareTangents; null: no BSDF has one.
  const std::uint32_t* tangents() const { return tangents_.data(); }
  bool has_mixtures() const { return has_mixtures_; }
  std::size_t triangle_count() const { return indices_.size() / 3; }
  // The index in Scene::meshes of the mesh that a triangle record is of.
  std::uint32_t MeshOf(std::uint32_t triangle) const;
  // Where corner 0, 1 or 2 of a triangle is, in the order that decides its geometric normal.
  glm::vec3 Corner(std::size_t triangle, int corner) const;
  std::size_t bytes() const;  // of vertices, indices and tables, without the BVH
  double build_seconds() const { return build_seconds_; }

 private:
  void AppendVariants(const Scene& scene, std::size_t i);

  struct Release {
    void operator()(RTCDevice device) const { rtcReleaseDevice(device); }
    void operator()(RTCScene scene) const { rtcReleaseScene(scene); }
  };
  std::unique_ptr<std::remove_pointer_t<RTCDevice>, Release> device_;
  std::unique_ptr<std::remove_pointer_t<RTCScene>, Release> scene_;
  std::vector<float> vertices_;         // xyz, one float of padding at the end
  std::vector<std::uint32_t> indices_;  // three a triangle
  std::vector<TriangleRecord> triangles_;
  std::vector<std::uint32_t> first_triangle_;  // of every mesh, ascending
  std::vector<std::uint32_t> mixed_;           // of every variant: the record that it is one of
  std::vector<MaterialRecord> materials_;
  BsdfSet bsdfs_ = 0;                    // of the triangles
  std::vector<std::uint32_t> tangents_;  // empty: no BSDF has one
  std::vector<float> measured_;
  bool has_mixtures_ = false;
  TextureTables textures_;
  const ConductorTables* conductor_tables_ = nullptr;  // null: no material needs them
  const SheenTables* sheen_tables_ = nullptr;          // likewise
  double build_seconds_ = 0;
};

// "isa=avx2" where the processor has it: hits then have the same bits on every such machine, and on
// AVX-512 machines nothing is lost (measured: docs/benchmarks.md).
std::string DefaultEmbreeConfig();

// Hash of everything that decides what a scene looks like: meshes, materials, camera and
// environment. Two scenes with the same hash give the same picture for the same settings.
std::uint64_t SceneHash(const Scene& scene);

}  // namespace skywave
