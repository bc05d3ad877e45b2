// Rays into Embree, a table at a time. The only file pair with Embree ray calls.
#pragma once

#include <embree3/rtcore.h>

#include <cstdint>
#include <optional>

#include "base/names.h"
#include "kernels/columns.h"

namespace skywave {

// How a table reaches Embree. Camera rays have no choice: their beams (kernels/camera.h) come as
// packets that promise coherence. What such a ray finds at the very edge of a triangle may depend
// on its packet, so packets are the same in whatever wave or part of a film. All other rays get the
// same hits, bit by bit, from every backend, since none promises anything.
enum class Backend {
  kBest,    // what is fastest: packets for nearest hits, streams for occlusion
  kStream,  // rtcIntersectNp: columns
  kPacket,  // rtcIntersect8
  kArray,   // rtcIntersect1M: an array of rays
  kSingle   // rtcIntersect1
};
// The calls of Embree that there are.
inline constexpr Backend kBackends[] = {Backend::kStream, Backend::kPacket, Backend::kArray,
                                        Backend::kSingle};
template <>
inline constexpr auto kEnumNames<Backend> =
    std::to_array<Named<Backend>>({{Backend::kBest, "best"},
                                   {Backend::kStream, "stream"},
                                   {Backend::kPacket, "packet"},
                                   {Backend::kArray, "array"},
                                   {Backend::kSingle, "single"}});

class RayRecorder;
enum class RayKind : std::uint32_t;

// What tracing needs: const, a copy a worker. The recorder is null but when a benchmark keeps the
// rays of a frame for a replay.
struct Tracer {
  RTCScene scene = nullptr;
  Backend closest = Backend::kBest;
  Backend occlusion = Backend::kBest;
  bool beams = true;  // without: camera rays are traced as others are
  RayRecorder* recorder = nullptr;
  // Triangles from here on are in the geometry with holes (scene/geometry.h). Unset: there is none,
  // and rays need no keys.
  std::optional<std::uint32_t> first_with_alpha = std::nullopt;
};

// In scenes with holes `keys` decides, ray by ray, which holes are met (DrawRayKeys); else null.

// Finds the nearest hit of rays [0, n): writes t_far of `rays` and all of `hits`. Camera rays are
// whole beams.
void TraceClosest(const Tracer& tracer, RayKind kind, const RayColumns& rays, std::uint32_t n,
                  const HitColumns& hits, const std::uint32_t* keys = nullptr);

// Shadow rays: origins are those of `surfaces`, the rest in `lights`, rows [0, n). Sets t_far of
// occluded rays negative; rows whose t_far is negative already are not traced.
void TraceShadows(const Tracer& tracer, const SurfaceColumns& surfaces, std::uint32_t n,
                  const LightColumns& lights, const std::uint32_t* keys = nullptr);

// Rays [0, n) for which any hit is enough: sets t_far of occluded ones negative. Not recorded.
void TraceOcclusion(const Tracer& tracer, const RayColumns& rays, std::uint32_t n,
                    const std::uint32_t* keys = nullptr);

// For rays that only matter if they leave the scene: writes geom of `hits` (0 or kNoHit), nothing
// else of it, and t_far of `rays`. Cheaper than TraceClosest.
void TraceEscapes(const Tracer& tracer, RayKind kind, const RayColumns& rays, std::uint32_t n,
                  const HitColumns& hits, const std::uint32_t* keys = nullptr);

}  // namespace skywave
