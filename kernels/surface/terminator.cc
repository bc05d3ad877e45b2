#include "kernels/surface/terminator.h"

#undef HWY_TARGET_INCLUDE
#define HWY_TARGET_INCLUDE "kernels/surface/terminator.cc"
#include "hwy/foreach_target.h"
#include "hwy/highway.h"
#include "kernels/simd/math-inl.h"
#include "kernels/surface/corners-inl.h"
#include "kernels/surface/instances-inl.h"

HWY_BEFORE_NAMESPACE();
namespace skywave {
namespace HWY_NAMESPACE {

// Returns how far the plane through a corner, across its normal, lies above a point of the
// triangle, as a vector; no plane lies below.
HWY_INLINE V3 Rise(const V3& point, const V3& corner, const V3& normal) {
  return normal * hn::Max(Dot(corner - point, normal), hn::Zero(F()));
}

void RoundSurfaces(const TriangleTables& triangles, std::uint32_t n, const SurfaceColumns& s) {
  const auto* words = reinterpret_cast<const std::uint32_t*>(triangles.records);
  for (std::uint32_t i = 0; i < n; i += hn::Lanes(F())) {
    const MU rows = RowsBelow(i, n);
    const VU record = hn::IfThenElseZero(rows, Load(s.triangle + i));
    const Words4 triangle = GatherWords4(words, hn::ShiftLeft<2>(record));
    const MF back = hn::RebindMask(F(), hn::TestBit(Load(s.material + i), SetU(kBackFace)));
    const auto side = [&](const V3& normal) HWY_ATTR { return IfThen(back, -normal, normal); };
    const V3 n0 = side(DecodeNormal(triangle.w0)), n1 = side(DecodeNormal(triangle.w1)),
             n2 = side(DecodeNormal(triangle.w2));
    const VF u = Load(s.u + i), v = Load(s.v + i), w = 1.0f - u - v;
    V3 between = n0 * w + n1 * u + n2 * v;

    const auto [p0, p1, p2] = GatherCorners(triangles.corners, triangles.positions, record);
    const V3 flat = p0 * w + p1 * u + p2 * v;
    V3 rise = Rise(flat, p0, n0) * w + Rise(flat, p1, n1) * u + Rise(flat, p2, n2) * v;
    if (triangles.instances != nullptr) {
      const InstanceLanes instance(triangles.instances, s, i, rows);
      between = instance.Normal(between);
      rise = instance.Vector(rise);
    }
    const V3 smooth = Normalize(between);

    const V3 wo = Load3(s.wo_x + i, s.wo_y + i, s.wo_z + i);
    const V3 ng = Load3(s.ng_x + i, s.ng_y + i, s.ng_z + i);
    const V3 org = Load3(s.org_x + i, s.org_y + i, s.org_z + i);
    const MU is_flat = hn::TestBit(triangle.w3, SetU(kFlatTriangle));
    // As in PrepareSurfaces: what is not usable there has been shaded with the geometric normal.
    const MF usable = hn::Gt(Dot(smooth, wo), Set(1e-4f));
    const MF rounded = hn::And(hn::RebindMask(F(), hn::AndNot(is_flat, rows)), usable);
    const V3 normal = IfThen(rounded, smooth, ng);
    const V3 moved = org + rise + (smooth - ng) * Load(s.lift + i);
    const V3 place = IfThen(rounded, moved, org);
    Store3(normal, s.ng_x + i, s.ng_y + i, s.ng_z + i);
    Store3(place, s.org_x + i, s.org_y + i, s.org_z + i);
  }
}

}  // namespace HWY_NAMESPACE
}  // namespace skywave
HWY_AFTER_NAMESPACE();

#if HWY_ONCE
namespace skywave {

HWY_EXPORT(RoundSurfaces);

void RoundSurfaces(const TriangleTables& triangles, std::uint32_t n,
                   const SurfaceColumns& surfaces) {
  HWY_DYNAMIC_DISPATCH(RoundSurfaces)(triangles, n, surfaces);
}

}  // namespace skywave
#endif  // HWY_ONCE
