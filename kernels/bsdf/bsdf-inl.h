// This file says what a BSDF is: a struct for one vector of surfaces, made from its rows and
// parameters, with
//   BsdfValue  Evaluate(wo, wi)              local frame, +z is the shading normal
//   BsdfSample Draw(wo, direction_u, direction_v, lobe_u)
//   BsdfValue  EvaluateWithoutMirrors(wo, wi, lanes)
//                                            the same without lobes that stand for mirrors, in
//                                            these lanes; optional
//   VF         Blurred(wo, wi, radius)       luminance of value, blurred over an angle; optional
//   V3         Diffuse(wo)                   value over the cosine of the part that does not depend
//                                            on wi, or the mean of one that hardly does; optional
//   V3         DiffuseThrough(wo)            the same for light from the other side; optional
//   kOnlyDiffuse                             true where these two are the whole value; optional
//   kTransmits                               true where light passes through; optional
//   kRefracts, VF ratio                      true where it also enters another medium, IndexRatio;
//                                            optional
// bsdf_kernels-inl.h makes its kernels.
#if defined(SKYWAVE_KERNELS_BSDF_INL_H_) == defined(HWY_TARGET_TOGGLE)
#ifdef SKYWAVE_KERNELS_BSDF_INL_H_
#undef SKYWAVE_KERNELS_BSDF_INL_H_
#else
#define SKYWAVE_KERNELS_BSDF_INL_H_
#endif

#include "kernels/bsdf/bsdf.h"
#include "kernels/material_fields-inl.h"
#include "kernels/simd/rows-inl.h"
#include "kernels/simd/sphere-inl.h"

HWY_BEFORE_NAMESPACE();
namespace skywave {
namespace HWY_NAMESPACE {

struct BsdfValue {
  V3 value;  // f |cos|
  VF pdf;    // [1/sr]
};

struct BsdfSample {
  V3 wi;      // local, unit
  V3 weight;  // f |cos| / pdf, or the factor of a delta lobe
  VF pdf;     // [1/sr]; 0: delta
};

HWY_INLINE BsdfSample SampleOf(const V3& wi, const BsdfValue& value) {
  const VF inverse = 1.0f / hn::Max(value.pdf, Set(1e-30f));
  return {wi, value.value * inverse, value.pdf};
}

// One vector of surfaces as every BSDF sees it.
struct ShadingLanes {
  HWY_INLINE ShadingLanes(const SurfaceColumns& s, std::uint32_t i)
      : frame(MakeFrame(ShadingNormal(s, i))),
        ng(GeometricNormal(s, i)),
        wo(ToLocal(frame, Outgoing(s, i))) {}
  Frame frame;
  V3 ng;
  V3 wo;  // local
};

HWY_INLINE V3 ColorOf(const SurfaceColumns& s, std::uint32_t i) {
  return Load3(s.color_r + i, s.color_g + i, s.color_b + i);
}
using enum MaterialField;
// These gather a field of each row's material; MaterialFields returns `fields`.
HWY_INLINE VF Field(const MaterialView& m, VU fields, MaterialField field) {
  return Field(m.records, fields, field);
}
HWY_INLINE VU IndexField(const MaterialView& m, VU fields, MaterialField field) {
  return AsBits(Field(m, fields, field));
}
HWY_INLINE V3 Field3(const MaterialView& m, VU fields, MaterialField field) {
  return {Field(m.records, fields, field, 0), Field(m.records, fields, field, 1),
          Field(m.records, fields, field, 2)};
}

// Returns what Varying::kSecondColor has.
HWY_INLINE V3 VariedColor(const SurfaceColumns& s, std::uint32_t i) {
  const VU pair = AsBits(Load(s.varying_0 + i));
  const auto share = [](VU bits) HWY_ATTR { return ToFloat(bits) * (1.0f / 65535); };
  return {share(hn::And(pair, SetU(65535))), share(hn::ShiftRight<16>(pair)),
          Load(s.varying_1 + i)};
}

template <class Bsdf>
inline constexpr bool kTransmits = requires {
  Bsdf::kTransmits;
};
template <class Bsdf>
inline constexpr bool kRefracts = requires {
  Bsdf::kRefracts;
};
template <class Bsdf>
inline constexpr bool kDiffuse = requires(const Bsdf& bsdf, const V3& wo) {
  bsdf.Diffuse(wo);
};
template <class Bsdf>
inline constexpr bool kBlurs = requires(const Bsdf& bsdf, const V3& wo, VF radius) {
  bsdf.Blurred(wo, wo, radius);
};

// Returns the lanes seen from the side that the normals of the mesh point away from.
HWY_INLINE MF SeenFromBehind(const SurfaceColumns& s, std::uint32_t i) {
  return hn::RebindMask(F(), hn::TestBit(Load(s.material + i), SetU(kBackFace)));
}
// Returns the index of dielectrics on wo's side over that on the other side.
HWY_INLINE VF IndexRatio(const SurfaceColumns& s, const MaterialView& m, VU fields,
                         std::uint32_t i) {
  const VF ior = Field(m, fields, kIor);
  return IfThen(SeenFromBehind(s, i), ior, 1.0f / ior);
}

// Returns the same of a BSDF that refracts.
template <class Bsdf>
HWY_INLINE VF RatioOf(const Bsdf& bsdf) {
  return bsdf.ratio;
}

// Returns the factor that flux gets where radiance gets 1, for a shading normal ns (Veach 1997,
// eq. 5.19). Directions are in world space or local. The factor is exactly 1 if ns is ng.
HWY_INLINE VF ShadingNormalFactor(const V3& ns, const V3& ng, const V3& wo, const V3& wi) {
  const VF over = hn::Abs(Dot(wo, ns)) * hn::Abs(Dot(wi, ng));
  const VF under = hn::Abs(Dot(wo, ng)) * hn::Abs(Dot(wi, ns));
  return over / hn::Max(under, Set(1e-20f));
}

// Returns the lanes where light can come from world direction wi: from above the surface as it is
// and as it is shaded; where light passes through, also from below both.
template <class Bsdf>
HWY_INLINE MF Connects(const ShadingLanes& lanes, const V3& world_wi, const V3& local_wi) {
  const VF height = Dot(lanes.ng, world_wi), zero = hn::Zero(F());
  const MF above = hn::And(hn::Gt(height, zero), hn::Gt(local_wi.z, zero));
  if constexpr (!kTransmits<Bsdf>) return above;
  return hn::Or(above, hn::And(hn::Lt(height, zero), hn::Lt(local_wi.z, zero)));
}

// Moves origins to the side of the surface that `world` points to; the sign of lift records the
// side.
HWY_INLINE void MoveOrigins(const SurfaceColumns& s, const ShadingLanes& lanes, const V3& world,
                            std::uint32_t i, std::uint32_t n) {
  const VF zero = hn::Zero(F()), lift = Load(s.lift + i);
  const VF toward = IfThen(hn::Lt(Dot(lanes.ng, world), zero), -hn::Abs(lift), hn::Abs(lift));
  const V3 moved = Load3(s.org_x + i, s.org_y + i, s.org_z + i) + lanes.ng * (toward - lift);
  StoreBelow(moved.x, s.org_x, i, n);
  StoreBelow(moved.y, s.org_y, i, n);
  StoreBelow(moved.z, s.org_z, i, n);
  StoreBelow(toward, s.lift, i, n);
}

HWY_INLINE VF Luminance(const V3& rgb) { return Dot(rgb, Set3(kLuminance)); }

}  // namespace HWY_NAMESPACE
}  // namespace skywave
HWY_AFTER_NAMESPACE();

#endif  // per-target include guard
