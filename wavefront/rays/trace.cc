#include "wavefront/rays/trace.h"

#include <algorithm>
#include <cassert>
#include <cmath>
#include <cstring>
#include <glm/glm.hpp>
#include <limits>
#include <numbers>

#include "kernels/camera.h"
#include "wavefront/rays/ray_recorder.h"

namespace skywave {
namespace {

constexpr std::uint32_t kPacket = 8;
constexpr std::uint32_t kPiece = 128;  // rays of a call, where their instances go to the stack

RayStream View(const RayColumns& r, const std::uint32_t* keys) {
  return {r.org_x, r.org_y, r.org_z, r.dir_x, r.dir_y, r.dir_z, r.t_far, keys};
}

RayStream ShadowStream(const SurfaceColumns& surfaces, const LightColumns& lights,
                       const std::uint32_t* keys) {
  return {surfaces.org_x, surfaces.org_y, surfaces.org_z, lights.dir_x,
          lights.dir_y,   lights.dir_z,   lights.t_far,   keys};
}

// Returns the rays from row `begin` on.
RayStream From(const RayStream& rays, std::uint32_t begin) {
  return {rays.org_x + begin, rays.org_y + begin,
          rays.org_z + begin, rays.dir_x + begin,
          rays.dir_y + begin, rays.dir_z + begin,
          rays.t_far + begin, rays.keys == nullptr ? nullptr : rays.keys + begin};
}

static_assert(kPacket == kBeamRays);

// These calls are the fastest for rays that promise nothing
// (docs/decisions/2026-11-22-embree-3-and-4.md).
constexpr Backend kBestClosest = Backend::kPacket;
constexpr Backend kBestOcclusion = kEmbreeHasStreams ? Backend::kStream : Backend::kPacket;

Backend Resolve(Backend backend, Backend best) {
  return backend == Backend::kBest ? best : backend;
}

RTCRay SingleRay(const RayStream& rays, std::uint32_t i) {
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
  void Load(const RayStream& from, std::uint32_t i, std::uint32_t count) {
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

void Occlude(RTCScene scene, Backend backend, const RayStream& rays, std::uint32_t n) {
  assert(IsAvailable(backend));
  EmbreeQuery query(scene, /*coherent=*/false);
  switch (Resolve(backend, kBestOcclusion)) {
    case Backend::kBest:
      break;
    case Backend::kStream:
      if constexpr (kEmbreeHasStreams) OccludedStream(query, rays, n);
      break;
    case Backend::kPacket: {
      Packet packet;
      for (std::uint32_t i = 0; i < n; i += kPacket) {
        const std::uint32_t count = std::min(kPacket, n - i);
        packet.Load(rays, i, count);
        Occluded8(query, packet.valid, packet.rays.ray);
        CopyPacket(packet.rays.ray.tfar, count, rays.t_far + i);
      }
      break;
    }
    case Backend::kSingle:
      for (std::uint32_t i = 0; i < n; ++i) {
        if (rays.t_far[i] < 0) continue;
        RTCRay ray = SingleRay(rays, i);
        Occluded1(query, ray);
        rays.t_far[i] = ray.tfar;
      }
      break;
  }
}

RTCRayHit SingleRayHit(const RayStream& rays, std::uint32_t i) {
  RTCRayHit hit;
  hit.ray = SingleRay(rays, i);
  hit.hit.geomID = RTC_INVALID_GEOMETRY_ID;
  return hit;
}

// Returns the row of the world or of an instance in the tables of places and of instances.
std::uint32_t InstanceRow(std::uint32_t instance) {
  return instance == RTC_INVALID_GEOMETRY_ID ? 0 : instance - kFirstInstance + 1;
}

// Gives a hit of Embree the meaning that it has in HitColumns: one numbering of the triangles of
// the world and of all objects, the instance, and the normal in the world.
void PlaceHit(const Tracer& tracer, std::uint32_t instance, std::uint32_t& triangle,
              std::uint32_t& geom, float& ng_x, float& ng_y, float& ng_z) {
  if (geom == kNoHit) return;
  const std::uint32_t row = InstanceRow(instance);
  triangle += tracer.places->first[row].of_geometry[geom];
  geom = row;
  const auto [x, y, z] = NormalInWorld(tracer.instances[row], ng_x, ng_y, ng_z);
  ng_x = x, ng_y = y, ng_z = z;
}

void StoreHit(const Tracer& tracer, RTCRayHit hit, std::uint32_t i, const RayColumns& rays,
              const HitColumns& hits) {
  if (tracer.places != nullptr) {
    PlaceHit(tracer, hit.hit.instID[0], hit.hit.primID, hit.hit.geomID, hit.hit.Ng_x, hit.hit.Ng_y,
             hit.hit.Ng_z);
  }
  rays.t_far[i] = hit.ray.tfar;
  hits.ng_x[i] = hit.hit.Ng_x, hits.ng_y[i] = hit.hit.Ng_y, hits.ng_z[i] = hit.hit.Ng_z;
  hits.u[i] = hit.hit.u, hits.v[i] = hit.hit.v;
  hits.triangle[i] = hit.hit.primID, hits.geom[i] = hit.hit.geomID;
}

// Traces a stream in pieces whose instances fit on the stack.
void IntersectInstancedStream(const Tracer& tracer, EmbreeQuery& query, const RayStream& rays,
                              const HitColumns& hits, std::uint32_t n) {
  if constexpr (kEmbreeHasStreams) {
    for (std::uint32_t begin = 0; begin < n; begin += kPiece) {
      std::uint32_t instances[kPiece];
      const std::uint32_t count = std::min(kPiece, n - begin);
      const HitColumns at = Slice(hits, begin);
      IntersectStream(query, From(rays, begin), at, instances, count);
      for (std::uint32_t i = 0; i < count; ++i) {
        PlaceHit(tracer, instances[i], at.triangle[i], at.geom[i], at.ng_x[i], at.ng_y[i],
                 at.ng_z[i]);
      }
    }
  }
}

// Makes one numbering of the triangles of both geometries.
void NumberTriangles(const HitColumns& hits, std::uint32_t first_with_alpha, std::uint32_t n) {
  for (std::uint32_t i = 0; i < n; ++i) {
    if (hits.geom[i] != 1) continue;
    hits.triangle[i] += first_with_alpha;
    hits.geom[i] = 0;
  }
}

// ---- What rays do not see ----

// What the filter of a ray needs besides the hit.
struct FilteredContext : EmbreeContext {
  const Tracer* tracer;
  float along;  // 1: rays come from the camera; -1: they go to it; 0: they see both sides
};

// Embree calls this for hits, in the space of the triangle.
void DropUnseen(const RTCFilterFunctionNArguments* arguments) {
  const auto& query = *static_cast<const FilteredContext*>(arguments->context);
  const Tracer& tracer = *query.tracer;
  const unsigned n = arguments->N;
  for (unsigned i = 0; i < n; ++i) {
    if (arguments->valid[i] == 0) continue;
    RTCHitN* const hit = arguments->hit;
    RTCRayN* const ray = arguments->ray;
    const std::uint32_t geometry = RTCHitN_geomID(hit, n, i);
    std::uint32_t triangle = RTCHitN_primID(hit, n, i);
    if (tracer.places != nullptr) {
      triangle +=
          tracer.places->first[InstanceRow(RTCHitN_instID(hit, n, i, 0))].of_geometry[geometry];
    } else if (geometry == 1) {
      triangle += *tracer.first_with_alpha;
    }
    const TriangleRecord& record = tracer.triangles[triangle];
    const float towards = RTCHitN_Ng_x(hit, n, i) * RTCRayN_dir_x(ray, n, i) +
                          RTCHitN_Ng_y(hit, n, i) * RTCRayN_dir_y(ray, n, i) +
                          RTCHitN_Ng_z(hit, n, i) * RTCRayN_dir_z(ray, n, i);
    const bool hidden = query.along != 0 && IsHiddenSide(record.tag, towards * query.along < 0);
    const bool left_out = tracer.only != nullptr && tracer.only[MaterialOf(record)] == 0;
    if (hidden || left_out) arguments->valid[i] = 0;
  }
}

struct FilteredQuery {
  FilteredQuery(const Tracer& tracer, float along) : query(tracer.scene, /*coherent=*/false) {
    query.FilterBy(DropUnseen, context);
    context.tracer = &tracer, context.along = along;
  }
  EmbreeQuery query;
  FilteredContext context;
};

// Returns FilteredContext::along of rays from the camera, or of others.
float AlongOf(const Tracer& tracer, RayKind kind) {
  return kind == RayKind::kCamera && tracer.one_sided ? 1 : 0;
}

// Traces ray i whole by a filtered query.
void TraceFiltered(const Tracer& tracer, FilteredQuery& filtered, const RayStream& rays,
                   const RayColumns& columns, const HitColumns& hits, std::uint32_t i) {
  RTCRayHit hit = SingleRayHit(rays, i);
  Intersect1(filtered.query, hit);
  StoreHit(tracer, hit, i, columns, hits);
  if (tracer.first_with_alpha && tracer.places == nullptr) {
    NumberTriangles(Slice(hits, i), *tracer.first_with_alpha, 1);
  }
}

// Traces camera rays anew that have hit what the camera does not see. Coplanar triangles, one for
// each side, need the whole ray: none of them is beyond the other.
void PassHiddenSides(const Tracer& tracer, const RayStream& rays, const RayColumns& columns,
                     const HitColumns& hits, std::uint32_t n) {
  FilteredQuery seeing(tracer, 1);
  for (std::uint32_t i = 0; i < n; ++i) {
    if (hits.geom[i] == kNoHit) continue;
    const float towards =
        hits.ng_x[i] * rays.dir_x[i] + hits.ng_y[i] * rays.dir_y[i] + hits.ng_z[i] * rays.dir_z[i];
    if (!IsHiddenSide(tracer.triangles[hits.triangle[i]].tag, towards < 0)) continue;
    columns.t_far[i] = std::numeric_limits<float>::infinity();
    TraceFiltered(tracer, seeing, rays, columns, hits, i);
  }
}

// Sets t_far of occluded rays [0, n) negative, as Occlude does.
void OccludeFiltered(const Tracer& tracer, float along, const RayStream& rays, std::uint32_t n) {
  FilteredQuery filtered(tracer, along);
  for (std::uint32_t i = 0; i < n; ++i) {
    if (rays.t_far[i] < 0) continue;
    RTCRay ray = SingleRay(rays, i);
    Occluded1(filtered.query, ray);
    rays.t_far[i] = ray.tfar;
  }
}

// ---- Edges that rays slip through ----

// Calls trace(ray) with the ray of row i moved beside, one way after the other, until it returns
// true.
template <class Trace>
void TryBeside(const Tracer& tracer, const RayStream& rays, std::uint32_t i, const Trace& trace) {
  RTCRay ray = SingleRay(rays, i);
  ray.tfar = std::numeric_limits<float>::infinity();
  const glm::vec3 origin(ray.org_x, ray.org_y, ray.org_z);
  const glm::vec3 along(ray.dir_x, ray.dir_y, ray.dir_z);
  const glm::vec3 other = std::abs(along.x) < 0.5f ? glm::vec3(1, 0, 0) : glm::vec3(0, 1, 0);
  const glm::vec3 across = glm::normalize(glm::cross(along, other));
  const glm::vec3 upward = glm::cross(along, across);
  for (const glm::vec3& way : {across, upward, -across, -upward, -along}) {
    const glm::vec3 moved = origin + tracer.beside * way;
    ray.org_x = moved.x, ray.org_y = moved.y, ray.org_z = moved.z;
    if (trace(ray)) return;
  }
}

// Traces those of rays [0, n) anew that have met nothing.
void CloseLeaks(const Tracer& tracer, const RayStream& rays, const RayColumns& columns,
                const HitColumns& hits, std::uint32_t n) {
  EmbreeQuery query(tracer.scene, /*coherent=*/false);
  for (std::uint32_t i = 0; i < n; ++i) {
    if (hits.geom[i] != kNoHit || !(rays.t_far[i] >= 0)) continue;
    TryBeside(tracer, rays, i, [&](const RTCRay& ray) {
      RTCRayHit hit;
      hit.ray = ray, hit.hit.geomID = RTC_INVALID_GEOMETRY_ID;
      Intersect1(query, hit);
      if (hit.hit.geomID == RTC_INVALID_GEOMETRY_ID) return false;
      StoreHit(tracer, hit, i, columns, hits);
      return true;
    });
  }
}

// Sets t_far of those of rays [0, n) negative that no surface has stopped, though they go to
// infinity, and that one stops beside.
void CloseOpenings(const Tracer& tracer, const RayStream& rays, std::uint32_t n) {
  EmbreeQuery query(tracer.scene, /*coherent=*/false);
  for (std::uint32_t i = 0; i < n; ++i) {
    if (rays.t_far[i] != std::numeric_limits<float>::infinity()) continue;
    TryBeside(tracer, rays, i, [&](RTCRay ray) {
      Occluded1(query, ray);
      if (ray.tfar >= 0) return false;
      rays.t_far[i] = ray.tfar;
      return true;
    });
  }
}

void Record(RayRecorder* recorder, RayKind kind, bool occlusion, const RayStream& rays,
            std::uint32_t n) {
  if (recorder == nullptr) return;
  const float* const org[3] = {rays.org_x, rays.org_y, rays.org_z};
  const float* const dir[3] = {rays.dir_x, rays.dir_y, rays.dir_z};
  recorder->Record(kind, occlusion, org, dir, rays.t_far, n, rays.keys);
}

}  // namespace

bool IsClosedAround(RTCScene scene, const float point[3]) {
  constexpr int kDirections = 1024;
  const double golden_angle = std::numbers::pi * (3 - std::sqrt(5.0));
  EmbreeQuery query(scene, /*coherent=*/false);
  for (int i = 0; i < kDirections; ++i) {
    // Points of a spherical Fibonacci lattice.
    const double y = 1 - (2 * i + 1.0) / kDirections, radius = std::sqrt(1 - y * y);
    RTCRay ray = {};
    ray.org_x = point[0], ray.org_y = point[1], ray.org_z = point[2];
    ray.dir_x = float(radius * std::cos(golden_angle * i)), ray.dir_y = float(y);
    ray.dir_z = float(radius * std::sin(golden_angle * i));
    ray.tfar = std::numeric_limits<float>::infinity();
    ray.mask = ~0u;
    Occluded1(query, ray);
    if (ray.tfar >= 0) return false;
  }
  return true;
}

void TraceClosest(const Tracer& tracer, RayKind kind, const RayColumns& rays, std::uint32_t n,
                  const HitColumns& hits, const std::uint32_t* keys) {
  assert(IsAvailable(tracer.closest));
  const RayStream view = View(rays, keys);
  Record(tracer.recorder, kind, false, view, n);
  if (tracer.only != nullptr) {
    FilteredQuery filtered(tracer, AlongOf(tracer, kind));
    for (std::uint32_t i = 0; i < n; ++i) TraceFiltered(tracer, filtered, view, rays, hits, i);
    return;
  }
  const bool beams = kind == RayKind::kCamera && tracer.beams;
  EmbreeQuery query(tracer.scene, beams);
  switch (beams ? Backend::kPacket : Resolve(tracer.closest, kBestClosest)) {
    case Backend::kBest:
      break;
    case Backend::kStream:
      // A miss leaves the hit as it was, so geom is set to "no hit" beforehand.
      std::fill_n(hits.geom, n, kNoHit);
      if (tracer.places != nullptr) {
        IntersectInstancedStream(tracer, query, view, hits, n);
      } else if constexpr (kEmbreeHasStreams) {
        IntersectStream(query, view, hits, nullptr, n);
      }
      break;
    case Backend::kPacket: {
      Packet packet;
      for (std::uint32_t i = 0; i < n; i += kPacket) {
        const std::uint32_t count = std::min(kPacket, n - i);
        packet.Load(view, i, count);
        std::fill_n(packet.rays.hit.geomID, kPacket, RTC_INVALID_GEOMETRY_ID);
        Intersect8(query, packet.valid, packet.rays);
        RTCHit8& hit = packet.rays.hit;
        for (std::uint32_t k = 0; tracer.places != nullptr && k < count; ++k) {
          PlaceHit(tracer, hit.instID[0][k], hit.primID[k], hit.geomID[k], hit.Ng_x[k], hit.Ng_y[k],
                   hit.Ng_z[k]);
        }
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
    case Backend::kSingle:
      for (std::uint32_t i = 0; i < n; ++i) {
        RTCRayHit hit = SingleRayHit(view, i);
        Intersect1(query, hit);
        StoreHit(tracer, hit, i, rays, hits);
      }
      break;
  }
  if (tracer.beside > 0) CloseLeaks(tracer, view, rays, hits, n);
  if (tracer.first_with_alpha && tracer.places == nullptr) {
    NumberTriangles(hits, *tracer.first_with_alpha, n);
  }
  if (kind == RayKind::kCamera && tracer.one_sided) {
    PassHiddenSides(tracer, view, rays, hits, n);
  }
}

void TraceShadows(const Tracer& tracer, const SurfaceColumns& surfaces, std::uint32_t n,
                  const LightColumns& lights, const std::uint32_t* keys) {
  const RayStream view = ShadowStream(surfaces, lights, keys);
  Record(tracer.recorder, RayKind::kShadow, true, view, n);
  if (tracer.only != nullptr) return OccludeFiltered(tracer, 0, view, n);
  Occlude(tracer.scene, tracer.occlusion, view, n);
  if (tracer.beside > 0) CloseOpenings(tracer, view, n);
}

void TraceToCamera(const Tracer& tracer, const SurfaceColumns& surfaces, std::uint32_t n,
                   const LightColumns& lights, const std::uint32_t* keys) {
  if (!tracer.one_sided) return TraceShadows(tracer, surfaces, n, lights, keys);
  const RayStream view = ShadowStream(surfaces, lights, keys);
  Record(tracer.recorder, RayKind::kShadow, true, view, n);
  OccludeFiltered(tracer, -1, view, n);
}

void TraceOcclusion(const Tracer& tracer, const RayColumns& rays, std::uint32_t n,
                    const std::uint32_t* keys) {
  Occlude(tracer.scene, tracer.occlusion, View(rays, keys), n);
}

void TraceEscapes(const Tracer& tracer, RayKind kind, const RayColumns& rays, std::uint32_t n,
                  const HitColumns& hits, const std::uint32_t* keys) {
  Record(tracer.recorder, kind, true, View(rays, keys), n);
  const float along = AlongOf(tracer, kind);
  if (along != 0 || tracer.only != nullptr) {
    OccludeFiltered(tracer, along, View(rays, keys), n);
  } else {
    TraceOcclusion(tracer, rays, n, keys);
    if (tracer.beside > 0) CloseOpenings(tracer, View(rays, keys), n);
  }
  for (std::uint32_t i = 0; i < n; ++i) hits.geom[i] = rays.t_far[i] < 0 ? 0 : kNoHit;
}

}  // namespace skywave
