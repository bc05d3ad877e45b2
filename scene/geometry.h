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

#include "kernels/bsdf.h"
#include "kernels/columns.h"
#include "kernels/normal_map.h"
#include "kernels/texture.h"
#include "scene/opacity.h"
#include "scene/scene.h"
#include "scene/texture_tables.h"

namespace skywave {

// Immutable once built. Triangle i of the records is primitive i of Embree geometry 0. Where rays
// may pass through a material, its triangles come last and are geometry 1, which asks at every hit.
class Geometry {
 public:
  Geometry(const Geometry&) = delete;  // Embree keeps addresses of its members
  Geometry& operator=(const Geometry&) = delete;
  // Checks every index and coordinate (InputError names `path` and the mesh), turns triangles whose
  // vertex normals point the other way, packs the tables and builds the BVH on `threads` threads
  // (0: all). `embree_config` is handed to rtcNewDevice; empty stands for DefaultEmbreeConfig().
  Geometry(const Scene& scene, const std::string& path, int threads = 0,
           const std::string& embree_config = "");

  RTCScene scene() const { return scene_.get(); }
  const TriangleRecord* triangles() const { return triangles_.data(); }
  MaterialView materials() const;
  TextureView textures() const;  // empty: no material has one
  NormalMapView normal_maps() const;
  // The first triangle of geometry 1; triangle_count() if there is none.
  std::uint32_t first_with_holes() const { return first_with_holes_; }
  bool has_holes() const { return first_with_holes_ < triangles_.size(); }
  std::size_t triangle_count() const { return triangles_.size(); }
  std::size_t bytes() const;  // of vertices, indices and tables, without the BVH
  std::size_t bvh_bytes() const { return std::size_t(embree_bytes_.load()); }
  double build_seconds() const { return build_seconds_; }

 private:
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
  std::vector<MaterialRecord> materials_;
  TextureTables textures_;
  std::vector<NormalMapRecord> normal_maps_;  // by material; empty if there are none
  std::vector<TriangleTangents> tangents_;    // by triangle; empty if there are none
  std::vector<OpacityRecord> opacity_;        // by material; empty if there are no holes
  HoleFilter hole_filter_ = {};
  std::uint32_t first_with_holes_ = 0;
  const ConductorTables* conductor_tables_ = nullptr;  // null: no conductor
  double build_seconds_ = 0;
};

// "isa=avx2" where the processor has it: hits then have the same bits on every such machine, and on
// AVX-512 machines nothing is lost (measured: docs/benchmarks.md).
std::string DefaultEmbreeConfig();

// Hash of everything that decides what a scene looks like: meshes, materials, camera and
// environment. Two scenes with the same hash give the same picture for the same settings.
std::uint64_t SceneHash(const Scene& scene);

}  // namespace skywave
