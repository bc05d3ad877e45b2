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
    // Instances of a triangle let the same ray pass independently of each other.
    const std::uint32_t instance = RTCHitN_instID(arguments->hit, n, i, 0) + 1;
    const std::uint32_t key = RTCRayN_id(arguments->ray, n, i) ^ instance * 0x85EBCA6Bu;
    if (!StopsRay(filter.opacity, key, triangle, u, v)) arguments->valid[i] = 0;
  }
}

EmbreeScene::EmbreeScene(const EmbreeTriangles& triangles, const std::string& path, int threads,
                         const std::string& config) {
  const Clock::time_point start = Clock::now();
  StartDevice(path, fmt::format("threads={},set_affinity=0,{}", threads,
                                config.empty() ? DefaultEmbreeConfig() : config));
  for (const TriangleSpan& span : triangles.spans) AddTriangles(triangles, span);
  for (std::size_t object = 1; object < scenes_.size(); ++object) {
    rtcCommitScene(scenes_[object].get());
  }
  AddInstances(triangles.instances);
  rtcCommitScene(scene());
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

// Adds a scene of the triangles of a span.
void EmbreeScene::AddTriangles(const EmbreeTriangles& triangles, const TriangleSpan& span) {
  const RTCScene scene = scenes_.emplace_back(rtcNewScene(device_.get())).get();
  rtcSetSceneBuildQuality(scene, RTC_BUILD_QUALITY_HIGH);
  if (triangles.calls_filter) rtcSetSceneFlags(scene, kFiltersOfCalls);
  const std::uint32_t first[] = {span.first, span.first_with_alpha, span.end};
  for (unsigned id = 0; id < 2; ++id) {
    const std::uint32_t count = first[id + 1] - first[id];
    if (count == 0) continue;
    RTCGeometry geometry = rtcNewGeometry(device_.get(), RTC_GEOMETRY_TYPE_TRIANGLE);
    rtcSetSharedGeometryBuffer(geometry, RTC_BUFFER_TYPE_VERTEX, 0, RTC_FORMAT_FLOAT3,
                               triangles.vertices, 0, 3 * sizeof(float), triangles.vertex_count);
    rtcSetSharedGeometryBuffer(geometry, RTC_BUFFER_TYPE_INDEX, 0, RTC_FORMAT_UINT3,
                               triangles.indices + 3 * std::size_t{first[id]}, 0,
                               3 * sizeof(std::uint32_t), count);
    if (id == 1) {
      rtcSetGeometryUserData(geometry,
                             &filters_.emplace_back(AlphaFilter{triangles.opacity, first[id]}));
      rtcSetGeometryIntersectFilterFunction(geometry, DropTransparent);
      rtcSetGeometryOccludedFilterFunction(geometry, DropTransparent);
    }
    rtcCommitGeometry(geometry);
    rtcAttachGeometryByID(scene, geometry, id);
    rtcReleaseGeometry(geometry);
  }
}

// Adds instances of the scenes of objects, which are committed, to the scene of the world.
void EmbreeScene::AddInstances(std::span<const EmbreeInstance> instances) {
  for (std::size_t i = 0; i < instances.size(); ++i) {
    RTCGeometry geometry = rtcNewGeometry(device_.get(), RTC_GEOMETRY_TYPE_INSTANCE);
    rtcSetGeometryInstancedScene(geometry, scenes_[1 + instances[i].object].get());
    rtcSetGeometryTransform(geometry, 0, RTC_FORMAT_FLOAT3X4_COLUMN_MAJOR,
                            instances[i].world_from_object);
    rtcCommitGeometry(geometry);
    rtcAttachGeometryByID(scene(), geometry, unsigned(kFirstInstance + i));
    rtcReleaseGeometry(geometry);
  }
}

std::string DefaultEmbreeConfig() {
  return __builtin_cpu_supports("avx2") ? "isa=avx2" : "verbose=0";
}

}  // namespace skywave
