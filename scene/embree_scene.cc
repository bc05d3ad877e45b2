#include "scene/embree_scene.h"

#include <fmt/format.h>

#include "base/clock.h"
#include "base/error.h"

namespace skywave {

// Embree calls this for closest hits and for occlusion alike, with N rays in arrays of that length.
// Rays carry their keys (DrawRayKeys) in `id`.
void EmbreeScene::DropTransparent(const RTCFilterFunctionNArguments* arguments) {
  const auto& filter = *static_cast<const AlphaFilter*>(arguments->geometryUserPtr);
  const unsigned n = arguments->N;
  for (unsigned i = 0; i < n; ++i) {
    if (arguments->valid[i] == 0) continue;
    const std::uint32_t triangle = filter.first + RTCHitN_primID(arguments->hit, n, i);
    const float u = RTCHitN_u(arguments->hit, n, i), v = RTCHitN_v(arguments->hit, n, i);
    const std::uint32_t key = RTCRayN_id(arguments->ray, n, i);
    if (!StopsRay(filter.opacity, key, triangle, u, v)) arguments->valid[i] = 0;
  }
}

EmbreeScene::EmbreeScene(const EmbreeTriangles& triangles, const std::string& path, int threads,
                         const std::string& config)
    : filter_{triangles.opacity, triangles.first_with_alpha} {
  const Clock::time_point start = Clock::now();
  StartDevice(path, fmt::format("threads={},set_affinity=0,{}", threads,
                                config.empty() ? DefaultEmbreeConfig() : config));
  scene_.reset(rtcNewScene(device_.get()));
  rtcSetSceneBuildQuality(scene_.get(), RTC_BUILD_QUALITY_HIGH);
  const std::uint32_t with_alpha = triangles.triangle_count - triangles.first_with_alpha;
  Attach(triangles, 0, 0, triangles.first_with_alpha);
  Attach(triangles, 1, triangles.first_with_alpha, with_alpha);
  rtcCommitScene(scene_.get());
  if (const RTCError error = rtcGetDeviceError(device_.get()); error != RTC_ERROR_NONE) {
    throw InputError(InputPosition::File(path),
                     fmt::format("Embree cannot build the scene (error {})", int(error)));
  }
  build_seconds_ = SecondsSince(start);
}

void EmbreeScene::StartDevice(const std::string& path, const std::string& config) {
  device_.reset(rtcNewDevice(config.c_str()));
  if (!device_) {
    throw InputError(InputPosition::File(path), "Embree does not start with: " + config);
  }
  rtcSetDeviceMemoryMonitorFunction(
      device_.get(),
      [](void* sum, ssize_t bytes, bool) {
        *static_cast<std::atomic<std::int64_t>*>(sum) += bytes;
        return true;
      },
      &bytes_);
}

// Adds triangles [first, first + count) as a geometry; geometry 1 is the one with alpha.
void EmbreeScene::Attach(const EmbreeTriangles& triangles, unsigned id, std::uint32_t first,
                         std::uint32_t count) {
  if (count == 0) return;
  RTCGeometry geometry = rtcNewGeometry(device_.get(), RTC_GEOMETRY_TYPE_TRIANGLE);
  rtcSetSharedGeometryBuffer(geometry, RTC_BUFFER_TYPE_VERTEX, 0, RTC_FORMAT_FLOAT3,
                             triangles.vertices, 0, 3 * sizeof(float), triangles.vertex_count);
  rtcSetSharedGeometryBuffer(geometry, RTC_BUFFER_TYPE_INDEX, 0, RTC_FORMAT_UINT3,
                             triangles.indices + 3 * std::size_t{first}, 0,
                             3 * sizeof(std::uint32_t), count);
  if (id == 1) {
    rtcSetGeometryUserData(geometry, &filter_);
    rtcSetGeometryIntersectFilterFunction(geometry, DropTransparent);
    rtcSetGeometryOccludedFilterFunction(geometry, DropTransparent);
  }
  rtcCommitGeometry(geometry);
  rtcAttachGeometryByID(scene_.get(), geometry, id);
  rtcReleaseGeometry(geometry);
}

std::string DefaultEmbreeConfig() {
  return __builtin_cpu_supports("avx2") ? "isa=avx2" : "verbose=0";
}

}  // namespace skywave
