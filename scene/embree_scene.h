// Embree's scene of the triangles of a Geometry: the device, the BVH, and the filter that lets rays
// pass through alpha. Rays are traced by wavefront/rays/trace.cc alone.
#pragma once

#include <atomic>
#include <cstddef>
#include <cstdint>
#include <memory>
#include <string>
#include <type_traits>

#include "kernels/surface/opacity.h"
#include "scene/embree.h"

namespace skywave {

// The triangles that Embree builds over. They must stay where they are as long as the scene lives.
struct EmbreeTriangles {
  const float* vertices;  // xyz of each, and one float of padding after the last one
  std::size_t vertex_count;
  const std::uint32_t* indices;  // three per triangle
  std::uint32_t triangle_count;
  // Rays may pass through triangles from this one on: Embree asks `opacity` at every hit of theirs.
  std::uint32_t first_with_alpha;
  OpacityView opacity;
};

// Triangles [0, first_with_alpha) are primitives of geometry 0, the others, if there are any, of
// geometry 1.
class EmbreeScene {
 public:
  EmbreeScene(const EmbreeScene&) = delete;  // Embree keeps addresses of its members
  EmbreeScene& operator=(const EmbreeScene&) = delete;
  // Builds the BVH on `threads` threads (0: all). Embree gets `config`; if it is empty,
  // DefaultEmbreeConfig() instead. Throws InputError(path) if Embree fails.
  EmbreeScene(const EmbreeTriangles& triangles, const std::string& path, int threads,
              const std::string& config);

  RTCScene scene() const { return scene_.get(); }
  std::size_t bytes() const { return std::size_t(bytes_.load()); }
  double build_seconds() const { return build_seconds_; }

 private:
  // The filter is asked about triangles of geometry 1, whose primitives count from `first`.
  struct AlphaFilter {
    OpacityView opacity;
    std::uint32_t first;
  };
  struct Release {
    void operator()(RTCDevice device) const { rtcReleaseDevice(device); }
    void operator()(RTCScene scene) const { rtcReleaseScene(scene); }
  };

  void StartDevice(const std::string& path, const std::string& config);
  void Attach(const EmbreeTriangles& triangles, unsigned id, std::uint32_t first,
              std::uint32_t count);
  static void DropTransparent(const RTCFilterFunctionNArguments* arguments);

  std::atomic<std::int64_t> bytes_ = 0;  // first: the device counts until it is released
  AlphaFilter filter_;
  std::unique_ptr<std::remove_pointer_t<RTCDevice>, Release> device_;
  std::unique_ptr<std::remove_pointer_t<RTCScene>, Release> scene_;
  double build_seconds_ = 0;
};

// Returns "isa=avx2" where the processor has it: hits then have the same bits on every such
// machine, and AVX-512 machines lose nothing (measured: docs/benchmarks.md).
std::string DefaultEmbreeConfig();

}  // namespace skywave
