#include "wavefront/rays/trace.h"

#include <algorithm>
#include <cstring>
#include <limits>

#include "kernels/camera.h"
#include "wavefront/rays/ray_recorder.h"

namespace skywave {
namespace {

constexpr std::uint32_t kPacket = 8;
constexpr std::uint32_t kArray = 128;  // rays of a call, on the stack: 10 KiB

// A view has the columns of a batch of rays, whatever table they come from.
struct RayView {
  float *org_x, *org_y, *org_z, *dir_x, *dir_y, *dir_z, *t_far;
  const std::uint32_t* keys;  // null: no alpha
};

RayView View(const RayColumns& r, const std::uint32_t* keys) {
  return {r.org_x, r.org_y, r.org_z, r.dir_x, r.dir_y, r.dir_z, r.t_far, keys};
}

static_assert(kPacket == kBeamRays);

// Coherent packets go down the tree as one frustum: camera rays then take 0.8 of the time, bounce
// and shadow rays twice as long.
RTCIntersectContext Context(bool coherent) {
  RTCIntersectContext context;
  rtcInitIntersectContext(&context);
  context.flags =
      coherent ? RTC_INTERSECT_CONTEXT_FLAG_COHERENT : RTC_INTERSECT_CONTEXT_FLAG_INCOHERENT;
  return context;
}

RTCRayNp StreamOf(const RayView& rays) {
  RTCRayNp ray = {};  // tnear, time, mask and flags null: 0, no motion, all, unused
  ray.org_x = rays.org_x, ray.org_y = rays.org_y, ray.org_z = rays.org_z;
  ray.dir_x = rays.dir_x, ray.dir_y = rays.dir_y, ray.dir_z = rays.dir_z;
  ray.tfar = rays.t_far;
  ray.id = const_cast<std::uint32_t*>(rays.keys);  // only read; null: 0
  return ray;
}

RTCRay SingleRay(const RayView& rays, std::uint32_t i) {
  RTCRay ray = {};
  ray.org_x = rays.org_x[i], ray.org_y = rays.org_y[i], ray.org_z = rays.org_z[i];
  ray.dir_x = rays.dir_x[i], ray.dir_y = rays.dir_y[i], ray.dir_z = rays.dir_z[i];
  ray.tfar = rays.t_far[i];
  ray.mask = ~0u;
  if (rays.keys != nullptr) ray.id = rays.keys[i];
  return ray;
}

// Copies the first `count` of eight values, from a column or to it; all eight are copied as two
// vectors.
template <class To, class From>
void CopyPacket(const From* from, std::uint32_t count, To* to) {
  static_assert(sizeof(To) == sizeof(From));
  if (count == kPacket) {
    std::memcpy(to, from, kPacket * sizeof(To));
  } else {
    std::memcpy(to, from, count * sizeof(To));
  }
}

// A packet is eight rays; columns that are the same for all packets are set once.
struct Packet {
  Packet() {
    std::memset(&rays, 0, sizeof rays);
    std::fill_n(rays.ray.mask, kPacket, ~0u);
  }
  // Loads rays [i, i + count) of eight; the others get a valid bit of 0.
  void Load(const RayView& from, std::uint32_t i, std::uint32_t count) {
    RTCRay8& to = rays.ray;
    CopyPacket(from.org_x + i, count, to.org_x);
    CopyPacket(from.org_y + i, count, to.org_y);
    CopyPacket(from.org_z + i, count, to.org_z);
    CopyPacket(from.dir_x + i, count, to.dir_x);
    CopyPacket(from.dir_y + i, count, to.dir_y);
    CopyPacket(from.dir_z + i, count, to.dir_z);
    CopyPacket(from.t_far + i, count, to.tfar);
    if (from.keys != nullptr) CopyPacket(from.keys + i, count, to.id);
    for (std::uint32_t lane = 0; lane < kPacket; ++lane) {
      valid[lane] = -int((lane < count) & (to.tfar[lane] >= 0));
    }
  }
  alignas(32) RTCRayHit8 rays;
  alignas(32) int valid[kPacket];
};

void Occlude(RTCScene scene, Backend backend, const RayView& rays, std::uint32_t n) {
  RTCIntersectContext context = Context(/*coherent=*/false);
  switch (backend) {
    case Backend::kBest:
    case Backend::kStream: {
      RTCRayNp ray = StreamOf(rays);
      rtcOccludedNp(scene, &context, &ray, n);
      break;
    }
    case Backend::kPacket: {
      Packet packet;
      for (std::uint32_t i = 0; i < n; i += kPacket) {
        const std::uint32_t count = std::min(kPacket, n - i);
        packet.Load(rays, i, count);
        rtcOccluded8(packet.valid, scene, &context, &packet.rays.ray);
        CopyPacket(packet.rays.ray.tfar, count, rays.t_far + i);
      }
      break;
    }
    case Backend::kArray:
      for (std::uint32_t i = 0; i < n; i += kArray) {
        RTCRay array[kArray];
        const std::uint32_t count = std::min(kArray, n - i);
        for (std::uint32_t k = 0; k < count; ++k) array[k] = SingleRay(rays, i + k);
        rtcOccluded1M(scene, &context, array, count, sizeof(RTCRay));
        for (std::uint32_t k = 0; k < count; ++k) rays.t_far[i + k] = array[k].tfar;
      }
      break;
    case Backend::kSingle:
      for (std::uint32_t i = 0; i < n; ++i) {
        if (rays.t_far[i] < 0) continue;
        RTCRay ray = SingleRay(rays, i);
        rtcOccluded1(scene, &context, &ray);
        rays.t_far[i] = ray.tfar;
      }
      break;
  }
}

RTCRayHit SingleRayHit(const RayView& rays, std::uint32_t i) {
  RTCRayHit hit;
  hit.ray = SingleRay(rays, i);
  hit.hit.geomID = RTC_INVALID_GEOMETRY_ID;
  return hit;
}

void StoreHit(const RTCRayHit& hit, std::uint32_t i, const RayColumns& rays,
              const HitColumns& hits) {
  rays.t_far[i] = hit.ray.tfar;
  hits.ng_x[i] = hit.hit.Ng_x, hits.ng_y[i] = hit.hit.Ng_y, hits.ng_z[i] = hit.hit.Ng_z;
  hits.u[i] = hit.hit.u, hits.v[i] = hit.hit.v;
  hits.triangle[i] = hit.hit.primID, hits.geom[i] = hit.hit.geomID;
}

void Record(RayRecorder* recorder, RayKind kind, bool occlusion, const RayView& rays,
            std::uint32_t n) {
  if (recorder == nullptr) return;
  const float* const org[3] = {rays.org_x, rays.org_y, rays.org_z};
  const float* const dir[3] = {rays.dir_x, rays.dir_y, rays.dir_z};
  recorder->Record(kind, occlusion, org, dir, rays.t_far, n, rays.keys);
}

// Makes one numbering of the triangles of both geometries.
void NumberTriangles(const HitColumns& hits, std::uint32_t first_with_alpha, std::uint32_t n) {
  for (std::uint32_t i = 0; i < n; ++i) {
    if (hits.geom[i] != 1) continue;
    hits.triangle[i] += first_with_alpha;
    hits.geom[i] = 0;
  }
}

}  // namespace

void TraceClosest(const Tracer& tracer, RayKind kind, const RayColumns& rays, std::uint32_t n,
                  const HitColumns& hits, const std::uint32_t* keys) {
  const RayView view = View(rays, keys);
  Record(tracer.recorder, kind, false, view, n);
  const bool beams = kind == RayKind::kCamera && tracer.beams;
  RTCIntersectContext context = Context(beams);
  switch (beams ? Backend::kPacket : tracer.closest) {
    case Backend::kStream: {
      // A miss leaves the hit as it was, so geom is set to "no hit" beforehand.
      std::fill_n(hits.geom, n, kNoHit);
      RTCRayHitNp batch = {};
      batch.ray = StreamOf(view);
      batch.hit.Ng_x = hits.ng_x, batch.hit.Ng_y = hits.ng_y, batch.hit.Ng_z = hits.ng_z;
      batch.hit.u = hits.u, batch.hit.v = hits.v;
      batch.hit.primID = hits.triangle, batch.hit.geomID = hits.geom;
      rtcIntersectNp(tracer.scene, &context, &batch, n);
      break;
    }
    case Backend::kBest:
    case Backend::kPacket: {
      Packet packet;
      for (std::uint32_t i = 0; i < n; i += kPacket) {
        const std::uint32_t count = std::min(kPacket, n - i);
        packet.Load(view, i, count);
        std::fill_n(packet.rays.hit.geomID, kPacket, RTC_INVALID_GEOMETRY_ID);
        rtcIntersect8(packet.valid, tracer.scene, &context, &packet.rays);
        const RTCHit8& hit = packet.rays.hit;
        CopyPacket(packet.rays.ray.tfar, count, rays.t_far + i);
        CopyPacket(hit.Ng_x, count, hits.ng_x + i);
        CopyPacket(hit.Ng_y, count, hits.ng_y + i);
        CopyPacket(hit.Ng_z, count, hits.ng_z + i);
        CopyPacket(hit.u, count, hits.u + i);
        CopyPacket(hit.v, count, hits.v + i);
        CopyPacket(hit.primID, count, hits.triangle + i);
        CopyPacket(hit.geomID, count, hits.geom + i);
      }
      break;
    }
    case Backend::kArray:
      for (std::uint32_t i = 0; i < n; i += kArray) {
        RTCRayHit array[kArray];
        const std::uint32_t count = std::min(kArray, n - i);
        for (std::uint32_t k = 0; k < count; ++k) array[k] = SingleRayHit(view, i + k);
        rtcIntersect1M(tracer.scene, &context, array, count, sizeof(RTCRayHit));
        for (std::uint32_t k = 0; k < count; ++k) StoreHit(array[k], i + k, rays, hits);
      }
      break;
    case Backend::kSingle:
      for (std::uint32_t i = 0; i < n; ++i) {
        RTCRayHit hit = SingleRayHit(view, i);
        rtcIntersect1(tracer.scene, &context, &hit);
        StoreHit(hit, i, rays, hits);
      }
      break;
  }
  if (tracer.first_with_alpha) NumberTriangles(hits, *tracer.first_with_alpha, n);
}

void TraceShadows(const Tracer& tracer, const SurfaceColumns& surfaces, std::uint32_t n,
                  const LightColumns& lights, const std::uint32_t* keys) {
  const RayView view = {surfaces.org_x, surfaces.org_y, surfaces.org_z, lights.dir_x,
                        lights.dir_y,   lights.dir_z,   lights.t_far,   keys};
  Record(tracer.recorder, RayKind::kShadow, true, view, n);
  Occlude(tracer.scene, tracer.occlusion, view, n);
}

void TraceOcclusion(const Tracer& tracer, const RayColumns& rays, std::uint32_t n,
                    const std::uint32_t* keys) {
  Occlude(tracer.scene, tracer.occlusion, View(rays, keys), n);
}

void TraceEscapes(const Tracer& tracer, RayKind kind, const RayColumns& rays, std::uint32_t n,
                  const HitColumns& hits, const std::uint32_t* keys) {
  Record(tracer.recorder, kind, true, View(rays, keys), n);
  TraceOcclusion(tracer, rays, n, keys);
  for (std::uint32_t i = 0; i < n; ++i) hits.geom[i] = rays.t_far[i] < 0 ? 0 : kNoHit;
}

}  // namespace skywave
