#include "kernels/surface/normal_map.h"

#include <algorithm>
#include <cmath>

#undef HWY_TARGET_INCLUDE
#define HWY_TARGET_INCLUDE "kernels/surface/normal_map.cc"
#include "hwy/foreach_target.h"
#include "hwy/highway.h"
#include "kernels/surface/facing-inl.h"
#include "kernels/surface/texture-inl.h"

HWY_BEFORE_NAMESPACE();
namespace skywave {
namespace HWY_NAMESPACE {

HWY_INLINE V3 UnpackNormalTexel(VU packed) {
  const auto field = [](VU bits, float half) HWY_ATTR { return ToFloat(bits) * (1 / half) - 1.0f; };
  return {field(hn::And(packed, SetU(0x7FFu)), 1023),
          field(hn::And(hn::ShiftRight<11>(packed), SetU(0x7FFu)), 1023),
          field(hn::ShiftRight<22>(packed), 511)};
}

// Normals of a vector of rows, on wo's side of the surface: those in `lanes` are bent.
struct BentNormals {
  V3 normal;
  MF lanes;
};
template <class Textured>
HWY_INLINE BentNormals Bend(const TextureView& view, const NormalMapView& maps, float pixel_angle,
                            const Textured& textured, const SurfaceColumns& s, std::uint32_t i,
                            std::uint32_t n) {
  const auto* records = reinterpret_cast<const std::uint32_t*>(maps.records);
  const auto* tangents = reinterpret_cast<const std::uint32_t*>(maps.tangents);
  const auto* slopes = reinterpret_cast<const float*>(maps.slopes);
  V3 seen = LookUp(view, textured, pixel_angle, s, i, UnpackNormalTexel);
  if (slopes != nullptr) {
    const VU slope = hn::ShiftLeft<kLogSlopeWords>(textured.triangle);
    const auto factor = [&](std::uint32_t word)
                            HWY_ATTR { return Gather(slopes, slope + SetU(word)); };
    seen.y = factor(SKYWAVE_WORD(TriangleSlopes, across)) * seen.y +
             factor(SKYWAVE_WORD(TriangleSlopes, shear)) * seen.x;
    seen.x = factor(SKYWAVE_WORD(TriangleSlopes, along)) * seen.x;
  }
  const VU record = hn::ShiftLeft<kLogNormalMapWords>(textured.material);
  VF scale = AsFloat(Gather(records, record + SetU(SKYWAVE_WORD(NormalMapRecord, scale))));
  const VU per_texel = Gather(records, record + SetU(SKYWAVE_WORD(NormalMapRecord, per_texel)));
  const TextureLanes map(view, textured.texture);
  const VF texels = TexelsALength(view, textured, map, UvsOf(view, map, textured.triangle), s, i);
  const MF of_lengths = hn::RebindMask(F(), hn::Ne(per_texel, hn::Zero(U())));
  scale = Clamp(IfThen(of_lengths, scale * texels, scale), -1e6f, 1e6f);

  // The frame of the map lies on the outer side, about the shading normal.
  const VU at = hn::ShiftLeft<kLogTangentWords>(textured.triangle);
  const VF b1 = Load(s.u + i), b2 = Load(s.v + i);
  const VF b0 = 1.0f - b1 - b2;
  const V3 t0 = DecodeNormal(Gather(tangents, at));
  const V3 t1 = DecodeNormal(Gather(tangents, at + SetU(1)));
  const V3 t2 = DecodeNormal(Gather(tangents, at + SetU(2)));
  const VF side = AsFloat(Gather(tangents, at + SetU(SKYWAVE_WORD(TriangleTangents, side))));
  const V3 ns = Load3(s.ns_x + i, s.ns_y + i, s.ns_z + i);
  const MF back = hn::RebindMask(F(), hn::TestBit(Load(s.material + i), SetU(kBackFace)));
  const V3 outer = IfThen(back, -ns, ns);
  V3 along = t0 * b0 + t1 * b1 + t2 * b2;
  if (view.instances != nullptr) {
    along = InstanceLanes(view.instances, s, i, RowsBelow(i, n)).Direction(along);
  }
  const V3 tangent = along - outer * Dot(outer, along);
  const VF length = hn::Sqrt(Dot(tangent, tangent));
  const MF usable = hn::And(hn::Gt(length, Set(1e-4f)), hn::Ne(side, hn::Zero(F())));
  const V3 x = tangent * (1.0f / hn::Max(length, Set(1e-4f)));
  const V3 y = Cross(outer, x) * side;
  const V3 bent =
      Normalize(x * (seen.x * scale) + y * (seen.y * scale) + outer * hn::Max(seen.z, Set(1e-3f)));

  return {IfThen(back, -bent, bent), hn::And(textured.lanes, usable)};
}

using MappedLanes = TexturedLanes<kLogNormalMapWords>;

void BendNormals(const TextureView& view, const NormalMapView& maps, float pixel_angle,
                 std::uint32_t n, const SurfaceColumns& s) {
  for (std::uint32_t i = 0; i < n; i += hn::Lanes(F())) {
    const MappedLanes mapped(maps.records, SKYWAVE_WORD(NormalMapRecord, texture), s, i, n);
    if (!mapped.any) continue;
    const BentNormals bent = Bend(view, maps, pixel_angle, mapped, s, i, n);
    const V3 wo = Load3(s.wo_x + i, s.wo_y + i, s.wo_z + i);
    const V3 ns = Load3(s.ns_x + i, s.ns_y + i, s.ns_z + i);
    Store3(IfThen(bent.lanes, FacingBentNormal(bent.normal, wo), ns), s.ns_x + i, s.ns_y + i,
           s.ns_z + i);
  }
}

void WriteBaseNormals(const TextureView& view, const NormalMapView& bases, float pixel_angle,
                      std::uint32_t n, const SurfaceColumns& s) {
  const auto* records = reinterpret_cast<const std::uint32_t*>(bases.records);
  for (std::uint32_t i = 0; i < n; i += hn::Lanes(F())) {
    const MappedLanes mapped(bases.records, SKYWAVE_WORD(NormalMapRecord, texture), s, i, n);
    const VU record = hn::ShiftLeft<kLogNormalMapWords>(mapped.material);
    const VU own = Gather(records, record + SetU(SKYWAVE_WORD(NormalMapRecord, of_base)));
    V3 normal = Load3(s.ns_x + i, s.ns_y + i, s.ns_z + i);
    if (mapped.any) {
      const BentNormals bent = Bend(view, bases, pixel_angle, mapped, s, i, n);
      normal = IfThen(bent.lanes, bent.normal, normal);
    }
    const MU has_own = hn::Ne(own, hn::Zero(U()));
    Store(hn::IfThenElse(has_own, EncodeNormal(normal), SetU(kSameNormal)), s.base_normal + i);
  }
}

}  // namespace HWY_NAMESPACE
}  // namespace skywave
HWY_AFTER_NAMESPACE();

#if HWY_ONCE
namespace skywave {

HWY_EXPORT(BendNormals);
HWY_EXPORT(WriteBaseNormals);

void BendNormals(const TextureView& textures, const NormalMapView& maps, float pixel_angle,
                 std::uint32_t n, const SurfaceColumns& surfaces) {
  HWY_DYNAMIC_DISPATCH(BendNormals)(textures, maps, pixel_angle, n, surfaces);
}

void WriteBaseNormals(const TextureView& textures, const NormalMapView& bases, float pixel_angle,
                      std::uint32_t n, const SurfaceColumns& surfaces) {
  HWY_DYNAMIC_DISPATCH(WriteBaseNormals)(textures, bases, pixel_angle, n, surfaces);
}

std::uint32_t PackNormalTexel(const float* xyz) {
  const double x = xyz[0], y = xyz[1], z = xyz[2];
  const double length = std::sqrt(x * x + y * y + z * z);
  const auto field = [&](double value, double half) {
    const double unit = length > 0 ? value / length : 0;
    return std::uint32_t(std::lround((unit + 1) * half));
  };
  return field(x, 1023) | field(y, 1023) << 11 | field(z, 511) << 22;
}

}  // namespace skywave
#endif  // HWY_ONCE
