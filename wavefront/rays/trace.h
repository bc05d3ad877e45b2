// Embree traces rays, one table at a time.
#pragma once

#include <algorithm>
#include <array>
#include <cstdint>
#include <optional>

#include "base/names.h"
#include "kernels/columns.h"
#include "scene/embree_scene.h"
#include "wavefront/rays/embree_rays.h"

namespace skywave {

// A backend says how a table reaches Embree. Camera rays have no choice: their beams
// (kernels/camera.h) come as packets that promise coherence. At the very edge of a triangle the hit
// of such a ray may depend on its packet, so packets are the same in whatever wave or part of a
// film. All other rays get the same hits, bit by bit, from every backend, since none promises
// anything.
enum class Backend {
  kBest,    // the fastest for nearest hits, and for occlusion
  kStream,  // columns; Embree 3 alone
  kPacket,  // eight rays
  kSingle   // one ray
};
template <>
inline constexpr auto kEnumNames<Backend> =
    std::to_array<Named<Backend>>({{Backend::kBest, "best"},
                                   {Backend::kStream, "stream"},
                                   {Backend::kPacket, "packet"},
                                   {Backend::kSingle, "single"}});

// These are the calls that the linked Embree has. A Tracer gets no others.
inline constexpr auto kBackends = [] {
  if constexpr (kEmbreeHasStreams) {
    return std::to_array({Backend::kStream, Backend::kPacket, Backend::kSingle});
  } else {
    return std::to_array({Backend::kPacket, Backend::kSingle});
  }
}();
constexpr bool IsAvailable(Backend backend) {
  return backend == Backend::kBest ||
         std::find(kBackends.begin(), kBackends.end(), backend) != kBackends.end();
}

class RayRecorder;
enum class RayKind : std::uint32_t;

// A tracer has what tracing needs; every worker has a copy. The recorder is null unless a benchmark
// keeps the rays of a frame for a replay.
struct Tracer {
  RTCScene scene = nullptr;
  Backend closest = Backend::kBest;
  Backend occlusion = Backend::kBest;
  bool beams = true;  // false: camera rays are traced as others are
  RayRecorder* recorder = nullptr;
  // Set if some triangle has alpha, be it of an object: rays then need keys. Triangles of the world
  // from here on are in the geometry with alpha (scene/geometry.h).
  std::optional<std::uint32_t> first_with_alpha = std::nullopt;
  // Both are null in scenes without instances.
  const TrianglePlaces* places = nullptr;
  const InstanceRecord* instances = nullptr;
  const TriangleRecord* triangles = nullptr;  // the records of all
  bool one_sided = false;                     // the camera does not see both sides of all of them
  // By material; rays meet triangles of materials with 1 alone. Null: they meet all.
  const std::uint8_t* only = nullptr;
  // Where it is positive, the scene is closed around the camera, and rays that meet nothing have
  // slipped through an edge that two triangles share, where Embree's tests of both round the other
  // way. They are traced again from places this far beside, four across their direction, since the
  // edge may lie along any, and one back, for those that begin on the edge. What is met first
  // counts.
  float beside = 0;
};

// Returns whether none of 1024 directions that cover the sphere leads from a point out of the
// scene.
bool IsClosedAround(RTCScene scene, const float point[3]);

// In scenes with alpha `keys` decides, ray by ray, which triangles stop it (DrawRayKeys); else it
// is null.

// Finds the nearest hit of rays [0, n): writes t_far of `rays` and all of `hits`. Camera rays are
// whole beams, and pass through what the camera does not see (kOneSidedTriangle).
void TraceClosest(const Tracer& tracer, RayKind kind, const RayColumns& rays, std::uint32_t n,
                  const HitColumns& hits, const std::uint32_t* keys = nullptr);

// Traces shadow rays: origins are those of `surfaces`, the rest is in `lights`, rows [0, n). Sets
// t_far of occluded rays negative; rows whose t_far is negative already are not traced.
void TraceShadows(const Tracer& tracer, const SurfaceColumns& surfaces, std::uint32_t n,
                  const LightColumns& lights, const std::uint32_t* keys = nullptr);

// The same for connections to the camera, which pass through what the camera does not see.
void TraceToCamera(const Tracer& tracer, const SurfaceColumns& surfaces, std::uint32_t n,
                   const LightColumns& lights, const std::uint32_t* keys = nullptr);

// Traces rays [0, n) for which any hit is enough: sets t_far of occluded ones negative. They are
// not recorded.
void TraceOcclusion(const Tracer& tracer, const RayColumns& rays, std::uint32_t n,
                    const std::uint32_t* keys = nullptr);

// Traces rays that only matter if they leave the scene: writes t_far of `rays` and, of `hits`, only
// geom (0 or kNoHit). It is cheaper than TraceClosest.
void TraceEscapes(const Tracer& tracer, RayKind kind, const RayColumns& rays, std::uint32_t n,
                  const HitColumns& hits, const std::uint32_t* keys = nullptr);

}  // namespace skywave
