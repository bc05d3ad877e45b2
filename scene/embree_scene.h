// Embree's scenes of the triangles of a Geometry, one of the world and one of each object: the
// device, the BVHs, and the filter that lets rays pass through alpha. Rays are traced by
// wavefront/rays/trace.cc alone.
#pragma once

#include <atomic>
#include <cstddef>
#include <cstdint>
#include <deque>
#include <memory>
#include <span>
#include <string>
#include <type_traits>
#include <vector>

#include "kernels/surface/opacity.h"
#include "scene/embree.h"

namespace skywave {

// The triangles of the world, or those of an object: [first, end). Rays may pass through those from
// first_with_alpha on. Triangles before it are primitives of geometry 0 of their Embree scene, the
// others, if there are any, of geometry 1.
struct TriangleSpan {
  std::uint32_t first = 0, first_with_alpha = 0, end = 0;
  bool has_alpha() const { return first_with_alpha < end; }
  bool operator==(const TriangleSpan&) const = default;
};

// An object in the world. Instance i is geometry kFirstInstance + i of the world's Embree scene.
struct EmbreeInstance {
  std::uint32_t object = 0;
  float world_from_object[12] = {};  // four columns
};
inline constexpr std::uint32_t kFirstInstance = 2;

// The numbers of primitive 0 of geometries 0 and 1 among all triangles.
struct FirstTriangles {
  std::uint32_t of_geometry[2];
};
struct TrianglePlaces {
  std::vector<FirstTriangles> first;  // row 0: of the world; row 1 + i: of the object of instance i
};

// The triangles that Embree builds over. They must stay where they are as long as the scene lives.
struct EmbreeTriangles {
  const float* vertices;  // xyz of each, and one float of padding after the last one
  std::size_t vertex_count;
  const std::uint32_t* indices;         // three per triangle
  std::span<const TriangleSpan> spans;  // the world's, then those of the objects
  std::span<const EmbreeInstance> instances;
  OpacityView opacity;  // Embree asks it at every hit of a triangle with alpha
  bool calls_filter;    // calls may bring filters of their own
};

class EmbreeScene {
 public:
  EmbreeScene(const EmbreeScene&) = delete;  // Embree keeps addresses of its members
  EmbreeScene& operator=(const EmbreeScene&) = delete;
  // Builds the BVHs on `threads` threads (0: all). Embree gets `config`; if it is empty,
  // DefaultEmbreeConfig() instead. Throws InputError(path) if Embree fails.
  EmbreeScene(const EmbreeTriangles& triangles, const std::string& path, int threads,
              const std::string& config);

  RTCScene scene() const { return scenes_.front().get(); }  // the world's
  std::size_t bytes() const { return std::size_t(bytes_.load()); }
  double build_seconds() const { return build_seconds_; }

 private:
  // The filter is asked about triangles of a geometry 1, whose primitives count from `first`.
  struct AlphaFilter {
    OpacityView opacity;
    std::uint32_t first;
  };
  struct Release {
    void operator()(RTCDevice device) const { rtcReleaseDevice(device); }
    void operator()(RTCScene scene) const { rtcReleaseScene(scene); }
  };

  void StartDevice(const std::string& path, const std::string& config);
  void AddTriangles(const EmbreeTriangles& triangles, const TriangleSpan& span);
  void AddInstances(std::span<const EmbreeInstance> instances);
  static void DropTransparent(const RTCFilterFunctionNArguments* arguments);

  std::atomic<std::int64_t> bytes_ = 0;  // first: the device counts until it is released
  std::deque<AlphaFilter> filters_;
  std::unique_ptr<std::remove_pointer_t<RTCDevice>, Release> device_;
  std::vector<std::unique_ptr<std::remove_pointer_t<RTCScene>, Release>> scenes_;
  double build_seconds_ = 0;
};

// Returns "isa=avx2" where the processor has it: hits then have the same bits on every such machine
// of a vendor, and AVX-512 machines lose nothing (measured: docs/benchmarks.md).
std::string DefaultEmbreeConfig();

}  // namespace skywave
