// What lies below a coat that has other normals (MaterialView::base_normals).
#if defined(SKYWAVE_KERNELS_TILTED_INL_H_) == defined(HWY_TARGET_TOGGLE)
#ifdef SKYWAVE_KERNELS_TILTED_INL_H_
#undef SKYWAVE_KERNELS_TILTED_INL_H_
#else
#define SKYWAVE_KERNELS_TILTED_INL_H_
#endif

#include "kernels/bsdf/bsdf-inl.h"
#include "kernels/surface/facing-inl.h"

HWY_BEFORE_NAMESPACE();
namespace skywave {
namespace HWY_NAMESPACE {

// The BSDF `Below`, about a normal of its own: ns is that of the coat. Directions are turned by the
// shortest way from one normal to the other.
template <class Below>
struct Tilted {
  HWY_INLINE Tilted(const SurfaceColumns& s, const MaterialView& m, std::uint32_t i,
                    std::uint32_t n)
      : below(s, m, i, n), any(m.base_normals), flux(m.flux) {
    if (!any) return;
    const VU own = hn::IfThenElse(RowsBelow(i, n), Load(s.base_normal + i), SetU(kSameNormal));
    tilted = hn::RebindMask(F(), hn::Ne(own, SetU(kSameNormal)));
    any = !hn::AllFalse(F(), tilted);
    normal = OfTilted(ToLocal(MakeFrame(ShadingNormal(s, i)), DecodeNormal(own)));
    // Where light passes through, ns may have been turned to the other side since (TurnSurfaces).
    if constexpr (kTransmits<Below>) normal = normal * hn::CopySign(Set(1.0f), normal.z);
  }

  // In the other lanes both normals are one.
  HWY_INLINE V3 OfTilted(const V3& w) const {
    return IfThen(tilted, w, V3{hn::Zero(F()), hn::Zero(F()), Set(1.0f)});
  }
  HWY_INLINE V3 Facing(const V3& eye) const { return OfTilted(FacingBentNormal(normal, eye)); }
  // Rodrigues' rotation that takes `from` to +z, and its inverse.
  static HWY_INLINE V3 To(const V3& from, const V3& w) {
    const VF along = Dot(from, w);
    const VF share = (along + w.z) / hn::Max(1.0f + from.z, Set(1e-3f));
    return {w.x - share * from.x, w.y - share * from.y, along};
  }
  static HWY_INLINE V3 From(const V3& from, const V3& w) {
    return To({-from.x, -from.y, from.z}, w);
  }

  static HWY_INLINE VF Height(const V3& w) {
    if constexpr (kTransmits<Below>) return hn::Abs(w.z);
    return w.z;
  }
  // True for directions in the frame of the base that are on the same sides for the coat. What only
  // reflects is asked for directions above the coat.
  static HWY_INLINE MF Meets(const V3& wo, const V3& wi, const V3& coat_wi) {
    if constexpr (kTransmits<Below>) {
      return hn::Gt(hn::Min(wo.z, wi.z * coat_wi.z), hn::Zero(F()));
    }
    return hn::Gt(hn::Min(wo.z, wi.z), hn::Zero(F()));
  }

  // Light that the base and the coat see from different sides meets the coat alone.
  HWY_INLINE BsdfValue EvaluateAbout(const V3& facing, const V3& coat_wo, const V3& coat_wi) const {
    const V3 wo = To(facing, coat_wo), wi = To(facing, coat_wi);
    const BsdfValue all = below.Evaluate(wo, wi);
    const MF meets = Meets(wo, wi, coat_wi);
    const auto kept = [&](VF x) HWY_ATTR { return hn::IfThenElseZero(meets, x); };
    BsdfValue value = {{kept(all.value.x), kept(all.value.y), kept(all.value.z)}, kept(all.pdf)};
    // For flux the cosine is that of wo, as it is for radiance the other way (Veach 1997, 5.3.2).
    if (flux) {
      const VF exchanged = wo.z * Height(coat_wi) / hn::Max(Height(wi) * coat_wo.z, Set(1e-6f));
      value.value = value.value * exchanged;
    }
    return value;
  }
  HWY_INLINE BsdfValue Evaluate(const V3& wo, const V3& wi) const {
    if (!any) return below.Evaluate(wo, wi);
    if (!flux) return EvaluateAbout(Facing(wo), wo, wi);
    // The normal faces the eye, which is at wi, and which drawing did not know.
    V3 eye = wi;
    if constexpr (kTransmits<Below>) eye = IfThen(hn::Lt(wi.z, hn::Zero(F())), -wi, wi);
    return {EvaluateAbout(Facing(eye), wo, wi).value, EvaluateAbout(normal, wo, wi).pdf};
  }
  HWY_INLINE VF Blurred(const V3& wo, const V3& wi, VF radius) const requires kBlurs<Below> {
    if (!any) return below.Blurred(wo, wi, radius);
    const V3 facing = Facing(wo);
    return below.Blurred(To(facing, wo), To(facing, wi), radius);
  }
  HWY_INLINE V3 Direction(const V3& wo, VF u, VF v, VF lobe) const {
    if (!any) return below.Direction(wo, u, v, lobe);
    const V3 facing = flux ? normal : Facing(wo), base_wo = To(facing, wo);
    const V3 wi = below.Direction(base_wo, u, v, lobe);
    // What the base does not scatter to is dead, though it may lie above the coat.
    const VF zero = hn::Zero(F()), one = Set(1.0f);
    return IfThen(hn::Gt(hn::Min(base_wo.z, wi.z), zero), From(facing, wi), V3{zero, zero, -one});
  }
  HWY_INLINE BsdfSample Draw(const V3& wo, VF u, VF v, VF lobe) const {
    if (!any) return below.Draw(wo, u, v, lobe);
    const V3 facing = flux ? normal : Facing(wo), base_wo = To(facing, wo);
    BsdfSample sample = below.Draw(base_wo, u, v, lobe);
    const V3 wi = From(facing, sample.wi);
    sample.pdf = hn::IfThenElseZero(Meets(base_wo, sample.wi, wi), sample.pdf);
    sample.wi = wi;
    return sample;
  }
  HWY_INLINE V3 Diffuse(const V3& wo) const requires kDiffuse<Below> {
    return below.Diffuse(any ? To(Facing(wo), wo) : wo);
  }

  Below below;
  bool any, flux;
  MF tilted;  // this and the next one only if any
  V3 normal;  // that of `below` in the frame of the coat
};

template <class Below>
inline constexpr bool kTransmits<Tilted<Below>> = kTransmits<Below>;
template <class Below>
inline constexpr bool kRefracts<Tilted<Below>> = kRefracts<Below>;
template <class Below>
HWY_INLINE VF RatioOf(const Tilted<Below>& tilted) {
  return RatioOf(tilted.below);
}

}  // namespace HWY_NAMESPACE
}  // namespace skywave
HWY_AFTER_NAMESPACE();

#endif  // per-target include guard
