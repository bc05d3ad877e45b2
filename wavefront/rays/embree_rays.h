// The calls that trace rays in one spelling for Embree 3 and Embree 4. No other file asks for the
// version. Embree 4 has packets and single rays only; functions for streams are declared for both
// versions and defined for Embree 3 alone.
#pragma once

#include <cstdint>

#include "kernels/columns.h"
#include "scene/embree.h"

namespace skywave {

inline constexpr bool kEmbreeHasStreams = RTC_VERSION_MAJOR < 4;

// Columns of rays, from whatever tables they come. Rays have no lower limit of distance.
struct RayStream {
  float *org_x, *org_y, *org_z, *dir_x, *dir_y, *dir_z, *t_far;
  const std::uint32_t* keys;  // for the filter (`id`); null: 0
};

#if RTC_VERSION_MAJOR >= 4

using EmbreeContext = RTCRayQueryContext;

// State shared by all calls on one scene. Coherent packets use frustum traversal.
struct EmbreeQuery {
  EmbreeQuery(RTCScene traced, bool coherent) : scene(traced) {
    rtcInitRayQueryContext(&context);
    rtcInitIntersectArguments(&closest);
    rtcInitOccludedArguments(&any);
    closest.context = any.context = &context;
    closest.flags = any.flags =
        coherent ? RTC_RAY_QUERY_FLAG_COHERENT : RTC_RAY_QUERY_FLAG_INCOHERENT;
  }
  EmbreeQuery(const EmbreeQuery&) = delete;  // the arguments point to the context
  EmbreeQuery& operator=(const EmbreeQuery&) = delete;

  // Asks `filter` about every hit, after the filter of the triangle. It gets `own`, which is a copy
  // of the context with more behind it.
  void FilterBy(RTCFilterFunctionN filter, EmbreeContext& own) {
    rtcInitRayQueryContext(&own);
    closest.context = any.context = &own;
    closest.filter = any.filter = filter;
    const int flags = closest.flags | RTC_RAY_QUERY_FLAG_INVOKE_ARGUMENT_FILTER;
    closest.flags = any.flags = RTCRayQueryFlags(flags);
  }

  RTCScene scene;
  RTCRayQueryContext context;
  RTCIntersectArguments closest;
  RTCOccludedArguments any;
};

// Intersect* find the nearest hit of each ray and Occluded* any hit. Lanes with a valid bit of 0
// are left alone.
inline void Intersect1(EmbreeQuery& query, RTCRayHit& ray) {
  rtcIntersect1(query.scene, &ray, &query.closest);
}
inline void Intersect8(EmbreeQuery& query, const int* valid, RTCRayHit8& rays) {
  rtcIntersect8(valid, query.scene, &rays, &query.closest);
}
inline void Occluded1(EmbreeQuery& query, RTCRay& ray) {
  rtcOccluded1(query.scene, &ray, &query.any);
}
inline void Occluded8(EmbreeQuery& query, const int* valid, RTCRay8& rays) {
  rtcOccluded8(valid, query.scene, &rays, &query.any);
}

void IntersectStream(EmbreeQuery& query, const RayStream& rays, const HitColumns& hits,
                     std::uint32_t* instances, std::uint32_t n);
void OccludedStream(EmbreeQuery& query, const RayStream& rays, std::uint32_t n);

#else

using EmbreeContext = RTCIntersectContext;

struct EmbreeQuery {
  EmbreeQuery(RTCScene traced, bool coherent) : scene(traced) {
    rtcInitIntersectContext(&context);
    context.flags =
        coherent ? RTC_INTERSECT_CONTEXT_FLAG_COHERENT : RTC_INTERSECT_CONTEXT_FLAG_INCOHERENT;
  }

  void FilterBy(RTCFilterFunctionN filter, EmbreeContext& own) {
    rtcInitIntersectContext(&own);
    own.flags = context.flags;
    own.filter = filter;
    current = &own;
  }
  EmbreeQuery(const EmbreeQuery&) = delete;
  EmbreeQuery& operator=(const EmbreeQuery&) = delete;

  RTCScene scene;
  RTCIntersectContext context;
  RTCIntersectContext* current = &context;
};

inline void Intersect1(EmbreeQuery& query, RTCRayHit& ray) {
  rtcIntersect1(query.scene, query.current, &ray);
}
inline void Intersect8(EmbreeQuery& query, const int* valid, RTCRayHit8& rays) {
  rtcIntersect8(valid, query.scene, query.current, &rays);
}
inline void Occluded1(EmbreeQuery& query, RTCRay& ray) {
  rtcOccluded1(query.scene, query.current, &ray);
}
inline void Occluded8(EmbreeQuery& query, const int* valid, RTCRay8& rays) {
  rtcOccluded8(valid, query.scene, query.current, &rays);
}

inline RTCRayNp StreamOf(const RayStream& rays) {
  RTCRayNp ray = {};  // tnear, time, mask and flags null: 0, no motion, all, unused
  ray.org_x = rays.org_x, ray.org_y = rays.org_y, ray.org_z = rays.org_z;
  ray.dir_x = rays.dir_x, ray.dir_y = rays.dir_y, ray.dir_z = rays.dir_z;
  ray.tfar = rays.t_far;
  ray.id = const_cast<std::uint32_t*>(rays.keys);  // only read
  return ray;
}
// A miss leaves its row of `hits` as it was. Where `instances` is not null, it gets the instance
// of each hit, or RTC_INVALID_GEOMETRY_ID.
inline void IntersectStream(EmbreeQuery& query, const RayStream& rays, const HitColumns& hits,
                            std::uint32_t* instances, std::uint32_t n) {
  RTCRayHitNp batch = {};
  batch.ray = StreamOf(rays);
  batch.hit.Ng_x = hits.ng_x, batch.hit.Ng_y = hits.ng_y, batch.hit.Ng_z = hits.ng_z;
  batch.hit.u = hits.u, batch.hit.v = hits.v;
  batch.hit.primID = hits.triangle, batch.hit.geomID = hits.geom;
  batch.hit.instID[0] = instances;
  rtcIntersectNp(query.scene, query.current, &batch, n);
}
inline void OccludedStream(EmbreeQuery& query, const RayStream& rays, std::uint32_t n) {
  RTCRayNp ray = StreamOf(rays);
  rtcOccludedNp(query.scene, query.current, &ray, n);
}

#endif

}  // namespace skywave
