#include "kernels/surface/surface.h"

#include <cmath>

#undef HWY_TARGET_INCLUDE
#define HWY_TARGET_INCLUDE "kernels/surface/surface.cc"
#include "hwy/foreach_target.h"
#include "hwy/highway.h"
#include "kernels/simd/exp-inl.h"
#include "kernels/surface/corners-inl.h"
#include "kernels/surface/instances-inl.h"
#include "kernels/surface/lift-inl.h"

HWY_BEFORE_NAMESPACE();
namespace skywave {
namespace HWY_NAMESPACE {

template <bool kInstanced>
HWY_INLINE void PrepareRows(const TriangleTables& tables, const MaterialRecord* materials,
                            std::uint32_t n, const SurfaceColumns& s) {
  const auto* words = reinterpret_cast<const std::uint32_t*>(tables.records);
  const auto* material_words = reinterpret_cast<const std::uint32_t*>(materials);
  for (std::uint32_t i = 0; i < n; i += hn::Lanes(F())) {
    const VU record = hn::IfThenElseZero(RowsBelow(i, n), Load(s.triangle + i));
    const Words4 triangle = GatherWords4(words, hn::ShiftLeft<2>(record));
    const V3 n0 = DecodeNormal(triangle.w0), n1 = DecodeNormal(triangle.w1),
             n2 = DecodeNormal(triangle.w2);
    const VU tag = triangle.w3;

    const V3 wo = Load3(s.wo_x + i, s.wo_y + i, s.wo_z + i);
    const V3 wound = Normalize(Load3(s.ng_x + i, s.ng_y + i, s.ng_z + i));
    const MF back = hn::Lt(Dot(wound, wo), hn::Zero(F()));
    const V3 ng = IfThen(back, -wound, wound);

    const VF u = Load(s.u + i), v = Load(s.v + i);
    const VF w = 1.0f - u - v;
    V3 between = n0 * w + n1 * u + n2 * v;
    if constexpr (kInstanced) {
      between = InstanceLanes(tables.instances, s, i, RowsBelow(i, n)).Normal(between);
    }
    const V3 smooth = Normalize(between);
    V3 ns = IfThen(back, -smooth, smooth);
    // Where the smooth normal faces away from the eye (silhouettes of coarse meshes) or is not a
    // number, shading uses the geometric one.
    const MF usable = hn::Gt(Dot(ns, wo), Set(1e-4f));
    const MF flat = hn::RebindMask(F(), hn::TestBit(tag, SetU(kFlatTriangle)));
    ns = IfThen(hn::AndNot(flat, usable), ns, ng);

    // The point comes from the corners and not from the ray, whose length it would lose digits by.
    const auto [p0, p1, p2] = GatherCorners(tables.corners, tables.positions, record);
    V3 hit = p0 * w + p1 * u + p2 * v, a = p1 - p0, b = p2 - p0;
    VF extent = LargestCoordinate(hit);
    if constexpr (kInstanced) {
      const InstanceLanes instance(tables.instances, s, i, RowsBelow(i, n));
      hit = instance.Point(hit);
      const VF scale = instance.Word(SKYWAVE_WORD(InstanceRecord, scale));
      a = a * scale, b = b * scale;
      extent = hn::Max(LargestCoordinate(hit), instance.Word(SKYWAVE_WORD(InstanceRecord, extent)));
    }
    const VF lift = LiftOff(extent, a, b);
    const V3 lifted = hit + ng * lift;

    const VU material = hn::And(tag, SetU(kMaterialMask));
    static_assert(SKYWAVE_WORD(MaterialRecord, color) == 0);
    const Words4 color = GatherWords4(material_words, hn::ShiftLeft<kLogMaterialWords>(material));
    Store3({AsFloat(color.w0), AsFloat(color.w1), AsFloat(color.w2)}, s.color_r + i, s.color_g + i,
           s.color_b + i);
    Store3(ng, s.ng_x + i, s.ng_y + i, s.ng_z + i);
    Store3(ns, s.ns_x + i, s.ns_y + i, s.ns_z + i);
    Store3(lifted, s.org_x + i, s.org_y + i, s.org_z + i);
    Store(lift, s.lift + i);
    const VU side = hn::IfThenElseZero(hn::RebindMask(U(), back), SetU(kBackFace));
    Store(hn::Or(material, side), s.material + i);
  }
}

void PrepareSurfaces(const TriangleTables& triangles, const MaterialRecord* materials,
                     std::uint32_t n, const SurfaceColumns& s) {
  PrepareRows<false>(triangles, materials, n, s);
}
void PrepareInstancedSurfaces(const TriangleTables& triangles, const MaterialRecord* materials,
                              std::uint32_t n, const SurfaceColumns& s) {
  PrepareRows<true>(triangles, materials, n, s);
}

void PrepareTangents(const std::uint32_t* tangents, const InstanceRecord* instances,
                     std::uint32_t n, const SurfaceColumns& s) {
  for (std::uint32_t i = 0; i < n; i += hn::Lanes(F())) {
    const VU triangle = hn::IfThenElseZero(RowsBelow(i, n), Load(s.triangle + i));
    V3 tangent = DecodeNormal(Gather(tangents, triangle));
    if (instances != nullptr) {
      tangent = InstanceLanes(instances, s, i, RowsBelow(i, n)).Direction(tangent);
    }
    const Frame frame = MakeFrame(Load3(s.ns_x + i, s.ns_y + i, s.ns_z + i));
    const VF along = Dot(frame.s, tangent), across = Dot(frame.t, tangent);
    const VF length = hn::Sqrt(along * along + across * across);
    const MF usable = hn::Gt(length, Set(1e-3f));
    const VF inverse = 1.0f / length;
    StoreBelow(IfThen(usable, along * inverse, Set(1.0f)), s.varying_0, i, n);
    StoreBelow(IfThen(usable, across * inverse, hn::Zero(F())), s.varying_1, i, n);
  }
}

void AbsorbInside(const MaterialRecord* materials, std::uint32_t n, const SurfaceColumns& s) {
  const auto* fields = reinterpret_cast<const float*>(materials);
  for (std::uint32_t i = 0; i < n; i += hn::Lanes(F())) {
    const VU material = hn::IfThenElseZero(RowsBelow(i, n), Load(s.material + i));
    const MF back = hn::RebindMask(F(), hn::TestBit(material, SetU(kBackFace)));
    if (hn::AllFalse(F(), back)) continue;
    const VU field = hn::ShiftLeft<kLogMaterialWords>(hn::And(material, SetU(kMaterialMask)));
    const VF distance = hn::IfThenElseZero(back, Load(s.t + i));
    const auto passes = [&](std::uint32_t channel) HWY_ATTR {
      const VU word = field + SetU(std::uint32_t(MaterialField::kAbsorption) + channel);
      return Exp(-(Gather(fields, word) * distance));
    };
    const V3 throughput = Load3(s.throughput_r + i, s.throughput_g + i, s.throughput_b + i);
    Store3(IfThen(back, throughput * V3{passes(0), passes(1), passes(2)}, throughput),
           s.throughput_r + i, s.throughput_g + i, s.throughput_b + i);
  }
}

}  // namespace HWY_NAMESPACE
}  // namespace skywave
HWY_AFTER_NAMESPACE();

#if HWY_ONCE
namespace skywave {

HWY_EXPORT(PrepareSurfaces);
HWY_EXPORT(PrepareInstancedSurfaces);
HWY_EXPORT(PrepareTangents);
HWY_EXPORT(AbsorbInside);

void PrepareSurfaces(const TriangleTables& triangles, const MaterialRecord* materials,
                     std::uint32_t n, const SurfaceColumns& surfaces) {
  if (triangles.instances != nullptr) {
    HWY_DYNAMIC_DISPATCH(PrepareInstancedSurfaces)(triangles, materials, n, surfaces);
  } else {
    HWY_DYNAMIC_DISPATCH(PrepareSurfaces)(triangles, materials, n, surfaces);
  }
}

void PrepareTangents(const std::uint32_t* tangents, const InstanceRecord* instances,
                     std::uint32_t n, const SurfaceColumns& surfaces) {
  HWY_DYNAMIC_DISPATCH(PrepareTangents)(tangents, instances, n, surfaces);
}

void AbsorbInside(const MaterialRecord* materials, std::uint32_t n,
                  const SurfaceColumns& surfaces) {
  HWY_DYNAMIC_DISPATCH(AbsorbInside)(materials, n, surfaces);
}

std::uint32_t EncodeNormal(float x, float y, float z) {
  const float norm = std::fabs(x) + std::fabs(y) + std::fabs(z);
  float px = x / norm, py = y / norm;
  if (z < 0) {
    const float folded_x = std::copysign(1 - std::fabs(py), px);
    py = std::copysign(1 - std::fabs(px), py);
    px = folded_x;
  }
  const auto quantize = [](float value) {
    return static_cast<std::uint32_t>(static_cast<std::int32_t>(std::lround(value * 32767.0f))) &
           0xFFFFu;
  };
  return quantize(px) | quantize(py) << 16;
}

}  // namespace skywave
#endif  // HWY_ONCE
