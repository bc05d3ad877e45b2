#include "kernels/partition.h"

#include <algorithm>
#include <bit>

#undef HWY_TARGET_INCLUDE
#define HWY_TARGET_INCLUDE "kernels/partition.cc"
#include "hwy/cache_control.h"
#include "hwy/foreach_target.h"
#include "hwy/highway.h"
#include "kernels/simd/simd-inl.h"

HWY_BEFORE_NAMESPACE();
namespace skywave {
namespace HWY_NAMESPACE {

constexpr std::uint32_t kNoQueue = 0xFFFFFFFFu;
constexpr std::uint32_t kAhead = 64;  // rows between the prefetch and the use of a record

// Counts the rows of [0, n) in queue `which`; the padding of the last vector is in no queue.
HWY_INLINE std::uint32_t CountQueue(const std::uint32_t* queue, std::uint32_t n,
                                    std::uint32_t which) {
  const VU wanted = SetU(which);
  VU counts = SetU(0);
  for (std::uint32_t i = 0; i < n; i += hn::Lanes(U())) {
    const auto same = hn::VecFromMask(U(), hn::Eq(Load(queue + i), wanted));
    counts = counts - same;  // all bits set are -1
  }
  return hn::GetLane(hn::SumOfLanes(U(), counts));
}

// Returns the triangles of hits `row` and on; triangle 0, which always exists and is cached, stands
// in for a miss.
HWY_INLINE VU TrianglesHit(const HitColumns& hits, std::uint32_t row, MU hit) {
  return hn::IfThenElseZero(hit, Load(hits.triangle + row));
}

// Prefetches the records of rows [row, n) of a vector, since they are random accesses. There is no
// branch on what rays hit, which is as unpredictable as random numbers.
HWY_INLINE void PrefetchRecords(const HitColumns& hits, const TriangleRecord* triangles,
                                std::uint32_t row, std::uint32_t n) {
  const MU hit = hn::And(RowsBelow(row, n), hn::Ne(Load(hits.geom + row), SetU(kNoHit)));
  alignas(kColumnAlignment) std::uint32_t triangle[kPadRows];
  Store(TrianglesHit(hits, row, hit), triangle);
  for (std::uint32_t lane = 0; lane < hn::Lanes(U()); ++lane) {
    hwy::Prefetch(triangles + triangle[lane]);
  }
}

void ClassifyHits(const HitColumns& hits, const TriangleRecord* triangles, BsdfSet present,
                  const float* ray_pdf, std::uint32_t n, std::uint32_t* queue,
                  std::uint32_t* count) {
  const auto* words = reinterpret_cast<const std::uint32_t*>(triangles);
  // If there is only one BSDF, nothing waits for a record here; surface preparation will find it.
  const bool several = (present & (present - 1)) != 0;
  VU kind = SetU(static_cast<std::uint32_t>(std::countr_zero(present)));
  for (std::uint32_t i = 0; i < std::min(n, kAhead); i += hn::Lanes(U())) {
    PrefetchRecords(hits, triangles, i, n);
  }
  for (std::uint32_t i = 0; i < n; i += hn::Lanes(U())) {
    if (i + kAhead < n) PrefetchRecords(hits, triangles, i + kAhead, n);
    const MU inside = RowsBelow(i, n);
    const MU hit = hn::And(inside, hn::Ne(Load(hits.geom + i), SetU(kNoHit)));
    if (several) {
      const VU triangle = TrianglesHit(hits, i, hit);
      const VU tag = Gather(words, hn::ShiftLeft<2>(triangle) + SetU(3));
      kind = hn::ShiftRight<kKindShift>(tag);
    }
    VU goes_to = kind;
    if (ray_pdf != nullptr) {
      const MF dense = hn::Gt(Load(ray_pdf + i), hn::Zero(F()));
      goes_to = IfThen(hn::RebindMask(U(), dense), SetU(kNoQueue), goes_to);
    }
    goes_to = IfThen(hit, goes_to, SetU(kMissQueue));
    goes_to = IfThen(inside, goes_to, SetU(kNoQueue));
    Store(goes_to, queue + i);
  }
  // One pass per queue over a cached column is cheaper than an inner loop over queues.
  for (BsdfSet rest = present; rest != 0; rest &= rest - 1) {
    const auto which = static_cast<std::uint32_t>(std::countr_zero(rest));
    count[which] += CountQueue(queue, n, which);
  }
  count[kMissQueue] += CountQueue(queue, n, kMissQueue);
}

// Puts the shares of lanes in `textured`, whose words `share` name textures, in their place. These
// lookups are rare and read a few texels each, so they are scalar.
HWY_INLINE VF TexturedShares(const TextureView& textures, MU textured, VU triangle, VU share,
                             const HitColumns& hits, std::uint32_t i) {
  alignas(kColumnAlignment) std::uint32_t lanes[kPadRows], triangles[kPadRows], shares[kPadRows];
  Store(hn::IfThenElseZero(textured, SetU(1)), lanes);
  Store(triangle, triangles), Store(share, shares);
  for (std::uint32_t lane = 0; lane < hn::Lanes(U()); ++lane) {
    if (lanes[lane] == 0) continue;
    shares[lane] = std::bit_cast<std::uint32_t>(
        FirstChannel(textures, shares[lane] & ~kShareOfTexture, triangles[lane], hits.u[i + lane],
                     hits.v[i + lane]));
  }
  return AsFloat(Load(shares));
}

void ChooseMaterials(const TriangleRecord* triangles, const TextureView& textures, const float* u,
                     std::uint32_t n, const HitColumns& hits) {
  const auto* words = reinterpret_cast<const std::uint32_t*>(triangles);
  const VF one = Set(1.0f);
  for (std::uint32_t i = 0; i < n; i += hn::Lanes(U())) {
    const MU hit = hn::And(RowsBelow(i, n), hn::Ne(Load(hits.geom + i), SetU(kNoHit)));
    const VU read = Load(hits.triangle + i);
    VU triangle = hn::IfThenElseZero(hit, read);
    VF uniform = Load(u + i);
    while (true) {
      const VU record = hn::ShiftLeft<2>(triangle);
      const VU tag = Gather(words, record + SetU(3));
      const MU mixed = hn::And(hit, hn::TestBit(tag, SetU(kMixedTriangle)));
      if (hn::AllFalse(U(), mixed)) break;
      const VU bits = Gather(words, record + SetU(1));
      VF share = AsFloat(bits);
      const MU textured = hn::And(mixed, hn::TestBit(bits, SetU(kShareOfTexture)));
      if (!hn::AllFalse(U(), textured)) {
        share = TexturedShares(textures, textured, triangle, bits, hits, i);
      }
      const MF second = hn::Lt(uniform, share);
      const VU first = Gather(words, record);
      const VU chosen = first + hn::IfThenElseZero(hn::RebindMask(U(), second), SetU(1));
      triangle = IfThen(mixed, chosen, triangle);
      // The rest of the uniform is stretched to [0, 1) for the next choice.
      const VF rest = IfThen(second, uniform, uniform - share);
      const VF room = IfThen(second, share, one - share);
      uniform = hn::Min(rest / hn::Max(room, Set(1e-20f)), Set(0x1.fffffep-1f));
    }
    Store(IfThen(hit, triangle, read), hits.triangle + i);
  }
}

std::uint32_t ClassifyEscapes(const HitColumns& hits, std::uint32_t n, std::uint32_t* queue) {
  std::size_t escaped = 0;
  for (std::uint32_t i = 0; i < n; i += hn::Lanes(U())) {
    const MU miss = hn::And(RowsBelow(i, n), hn::Eq(Load(hits.geom + i), SetU(kNoHit)));
    Store(IfThen(miss, SetU(kMissQueue), SetU(kNoQueue)), queue + i);
    escaped += hn::CountTrue(U(), miss);
  }
  return static_cast<std::uint32_t>(escaped);
}

// Moves all but the throughput of the rays of one vector that count with what they see.
HWY_INLINE void MoveSeeing(const RowCompressor& rows, const RayColumns& rays, std::uint32_t i,
                           const EscapeColumns& escaped, std::uint32_t to) {
  rows.Move(rays.dir_x + i, escaped.dir_x + to);
  rows.Move(rays.dir_y + i, escaped.dir_y + to);
  rows.Move(rays.dir_z + i, escaped.dir_z + to);
  rows.Move(rays.pdf + i, escaped.pdf + to);
  rows.Move(rays.path + i, escaped.path + to);
  rows.Move(rays.from + i, escaped.from + to);
}

void MoveEscaped(const RayColumns& rays, const std::uint32_t* queue, std::uint32_t n,
                 const EscapeColumns& escaped) {
  std::uint32_t to = 0;
  for (std::uint32_t i = 0; i < n; i += hn::Lanes(U())) {
    const RowCompressor rows(hn::Eq(Load(queue + i), SetU(kMissQueue)));
    rows.Move(rays.throughput_r + i, escaped.throughput_r + to);
    rows.Move(rays.throughput_g + i, escaped.throughput_g + to);
    rows.Move(rays.throughput_b + i, escaped.throughput_b + to);
    MoveSeeing(rows, rays, i, escaped, to);
    to += rows.count();
  }
}

std::uint32_t MoveControlled(const RayColumns& rays, const std::uint32_t* queue, std::uint32_t n,
                             const ControlColumns& control, const EscapeColumns& escaped) {
  std::uint32_t to = 0;
  for (std::uint32_t i = 0; i < n; i += hn::Lanes(U())) {
    const MF out = hn::RebindMask(F(), hn::Eq(Load(queue + i), SetU(kMissQueue)));
    const V3 throughput =
        Load3(rays.throughput_r + i, rays.throughput_g + i, rays.throughput_b + i);
    const V3 known = Load3(control.r + i, control.g + i, control.b + i);
    const V3 left = {hn::IfThenElseZero(out, throughput.x) - known.x,
                     hn::IfThenElseZero(out, throughput.y) - known.y,
                     hn::IfThenElseZero(out, throughput.z) - known.z};
    const VF zero = hn::Zero(F());
    const MF any = hn::Or(hn::Or(hn::Ne(left.x, zero), hn::Ne(left.y, zero)), hn::Ne(left.z, zero));
    const RowCompressor rows(hn::And(hn::RebindMask(U(), any), RowsBelow(i, n)));
    rows.Append(left.x, escaped.throughput_r + to);
    rows.Append(left.y, escaped.throughput_g + to);
    rows.Append(left.z, escaped.throughput_b + to);
    MoveSeeing(rows, rays, i, escaped, to);
    to += rows.count();
  }
  return to;
}

void MoveHits(const RayColumns& rays, const HitColumns& hits, const std::uint32_t* queue,
              std::uint32_t kind, std::uint32_t n, const SurfaceColumns& surfaces) {
  std::uint32_t to = 0;
  for (std::uint32_t i = 0; i < n; i += hn::Lanes(U())) {
    const MU mask = hn::Eq(Load(queue + i), SetU(kind));
    if (hn::AllFalse(U(), mask)) continue;
    const RowCompressor rows(mask);
    rows.Append(-Load(rays.dir_x + i), surfaces.wo_x + to);
    rows.Append(-Load(rays.dir_y + i), surfaces.wo_y + to);
    rows.Append(-Load(rays.dir_z + i), surfaces.wo_z + to);
    rows.Move(hits.ng_x + i, surfaces.ng_x + to);
    rows.Move(hits.ng_y + i, surfaces.ng_y + to);
    rows.Move(hits.ng_z + i, surfaces.ng_z + to);
    rows.Move(rays.throughput_r + i, surfaces.throughput_r + to);
    rows.Move(rays.throughput_g + i, surfaces.throughput_g + to);
    rows.Move(rays.throughput_b + i, surfaces.throughput_b + to);
    rows.Move(rays.t_far + i, surfaces.t + to);
    rows.Move(hits.u + i, surfaces.u + to);
    rows.Move(hits.v + i, surfaces.v + to);
    rows.Move(hits.triangle + i, surfaces.triangle + to);
    rows.Move(rays.path + i, surfaces.path + to);
    to += rows.count();
  }
}

}  // namespace HWY_NAMESPACE
}  // namespace skywave
HWY_AFTER_NAMESPACE();

#if HWY_ONCE
namespace skywave {

HWY_EXPORT(ClassifyHits);
HWY_EXPORT(ClassifyEscapes);
HWY_EXPORT(ChooseMaterials);
HWY_EXPORT(MoveEscaped);
HWY_EXPORT(MoveControlled);
HWY_EXPORT(MoveHits);

void ClassifyHits(const HitColumns& hits, const TriangleRecord* triangles, BsdfSet present,
                  const float* ray_pdf, std::uint32_t n, std::uint32_t* queue,
                  std::uint32_t* count) {
  HWY_DYNAMIC_DISPATCH(ClassifyHits)(hits, triangles, present, ray_pdf, n, queue, count);
}
void ChooseMaterials(const TriangleRecord* triangles, const TextureView& textures, const float* u,
                     std::uint32_t n, const HitColumns& hits) {
  HWY_DYNAMIC_DISPATCH(ChooseMaterials)(triangles, textures, u, n, hits);
}
std::uint32_t ClassifyEscapes(const HitColumns& hits, std::uint32_t n, std::uint32_t* queue) {
  return HWY_DYNAMIC_DISPATCH(ClassifyEscapes)(hits, n, queue);
}
void MoveEscaped(const RayColumns& rays, const std::uint32_t* queue, std::uint32_t n,
                 const EscapeColumns& escaped) {
  HWY_DYNAMIC_DISPATCH(MoveEscaped)(rays, queue, n, escaped);
}
std::uint32_t MoveControlled(const RayColumns& rays, const std::uint32_t* queue, std::uint32_t n,
                             const ControlColumns& control, const EscapeColumns& escaped) {
  return HWY_DYNAMIC_DISPATCH(MoveControlled)(rays, queue, n, control, escaped);
}
void MoveHits(const RayColumns& rays, const HitColumns& hits, const std::uint32_t* queue,
              std::uint32_t kind, std::uint32_t n, const SurfaceColumns& surfaces) {
  HWY_DYNAMIC_DISPATCH(MoveHits)(rays, hits, queue, kind, n, surfaces);
}

}  // namespace skywave
#endif  // HWY_ONCE
