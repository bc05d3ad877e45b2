// A conductor under a dielectric coat (tabled_coat-inl.h). The metal meets the coat and not air:
// its index counts relative to that of the coat, and its lobe is that of the refracted directions.
// What the coat takes away, and what reflections between coat and metal add, are factors of both
// directions that make directional albedos exact.
#include "kernels/bsdf/bsdf.h"
#include "kernels/bsdf/pack.h"

#undef HWY_TARGET_INCLUDE
#define HWY_TARGET_INCLUDE "kernels/bsdf/coated_conductor.cc"
#include "hwy/foreach_target.h"
#include "hwy/highway.h"
#include "kernels/bsdf/bsdf_kernels-inl.h"
#include "kernels/bsdf/tabled_coat-inl.h"

HWY_BEFORE_NAMESPACE();
namespace skywave {
namespace HWY_NAMESPACE {

struct CoveredMetal {
  static constexpr MaterialField kCoatWidth = kCoatAlpha;
  static constexpr bool kMayMirror = true;

  HWY_INLINE CoveredMetal(const SurfaceColumns& s, const MaterialView& m, std::uint32_t i,
                          std::uint32_t n)
      : fields(MaterialFields(s, i, n)),
        color(ColorOf(s, i)),
        ggx(Clamp(Field(m, fields, kAlpha), 1e-3f, 1.0f)),
        ior(hn::Max(Field(m, fields, kIor), Set(1e-3f))),
        eta(Field3(m, fields, kEta)),
        k(Field3(m, fields, kK)) {}

  // Takes the widths of metal and coat, which may have an image in `lanes`, and returns the latter.
  HWY_INLINE VF Vary(const SurfaceColumns& s, std::uint32_t i, MU lanes, CoatLanes& coat) {
    const VF one = Set(1.0f), own = Clamp(Load(s.varying_0 + i), 1e-3f, 1.0f);
    const VF width = Clamp(Load(s.varying_1 + i), 1e-3f, 1.0f);
    coat.coats = coat.Approach(width, lanes, kCoatRows * kCoatWords);
    coat.metals = coat.Approach(own, lanes, kCoatWords);
    coat.over_metals = true;
    // This is WidthUnderCoat.
    const VF tilt = 0.5f * (one - one / ior) * width;
    const VF wider2 = own * own + 2.0f * (tilt * tilt);
    const VF wider = Clamp(hn::Sqrt(wider2), 1e-3f, 1.0f);
    ggx = Ggx(IfThen(hn::RebindMask(F(), lanes), wider, own));
    return width;
  }

  // Refracts a direction into the coat.
  HWY_INLINE V3 Inside(const V3& w) const {
    const VF inverse = 1.0f / ior;
    const VF x = w.x * inverse, y = w.y * inverse;
    const VF sine2 = x * x + y * y;
    return {x, y, SafeSqrt(1.0f - sine2)};
  }
  // Refracts a direction out of the coat; what is reflected totally points into the surface.
  HWY_INLINE V3 Outside(const V3& w) const {
    const VF zero = hn::Zero(F()), one = Set(1.0f);
    const VF x = w.x * ior, y = w.y * ior;
    const VF cosine2 = one - (x * x + y * y);
    const MF leaves = hn::And(hn::Gt(cosine2, zero), hn::Gt(w.z, zero));
    return IfThen(leaves, V3{x, y, SafeSqrt(cosine2)}, V3{zero, zero, Set(-1.0f)});
  }

  HWY_INLINE BsdfValue Evaluate(const CoatLanes& coat, const V3& wo, const V3& wi) const {
    const VF one = Set(1.0f), tiny = Set(1e-6f);
    const V3 o = Inside(wo), i = Inside(wi);
    const V3 h = Ggx::HalfVector(o, i);
    const VF d = Ggx::Distribution(h, ggx.alpha * ggx.alpha);
    const VF lambda_o = ggx.Lambda(o), lambda_i = ggx.Lambda(i);
    // A solid angle in the coat is this part of that outside.
    const VF squeezed = wi.z / (ior * ior * hn::Max(i.z, tiny));
    const VF lobe = d * squeezed * (0.25f / hn::Max(o.z, tiny));
    const VF single = lobe / (one + lambda_o + lambda_i);
    const V3 fresnel = FresnelConductor(hn::Min(hn::Abs(Dot(o, h)), one), eta, k);
    const V3 through = coat.Look3(offsetof(CoatTable, through), CoatLanes::PlaceOf(wo.z)) *
                       coat.Look3(offsetof(CoatTable, through), CoatLanes::PlaceOf(wi.z));
    return {color * fresnel * through * single, lobe / (one + lambda_o)};
  }
  HWY_INLINE V3 Direction(const V3& wo, VF u, VF v, VF) const {
    return Outside(ggx.Reflect(Inside(wo), u, v));
  }
  // Refraction widens the lobe. The Fresnel reflectance is left out: it is nearly the same for all
  // wi that matter.
  HWY_INLINE VF Blurred(const CoatLanes&, const V3& wo, const V3& wi, VF radius) const {
    const Ggx wide(Clamp(ggx.alpha * ior, 1e-3f, 1.0f));
    return Luminance(color) * wide.Blurred(wo, wi, radius);
  }

  VU fields;
  V3 color;
  Ggx ggx;
  VF ior;
  V3 eta, k;
};

using CoatedConductor = UnderCoat<CoveredMetal>;

SKYWAVE_BSDF_KERNELS(CoatedConductor)

}  // namespace HWY_NAMESPACE
}  // namespace skywave
HWY_AFTER_NAMESPACE();

#if HWY_ONCE
namespace skywave {

inline constexpr BsdfTraits CoatedConductorTraits = {
    .name = "coated-conductor",
    .lobed = true,
    .varying = Varying::kCoatWidths,
    .tables = {.coat = true},
    .parameters = {{"alpha"}, {"eta"}, {"k"}, {"coat_alpha"}, {"ior"}},
    .pack = [](const Material& m, MeasuredBrdfs, MaterialRecord& r) {
      PackAlpha(m, r);
      // With an image of the widths, kernels compute this for each surface.
      if (!m.roughness_texture) {
        PutField(r, MaterialField::kAlpha, WidthUnderCoat(m.alpha, m.coat_alpha, m.ior));
      }
      PutField(r, MaterialField::kEta, m.eta / m.ior);
      PutField(r, MaterialField::kK, m.k / m.ior);
      PutField(r, MaterialField::kCoatAlpha, MicrofacetWidth(m.coat_alpha));
      PutField(r, MaterialField::kIor, m.ior);
      PutField(r, MaterialField::kCoatMedium, m.coat_thickness > 0 ? 1.0f : 0.0f);
    }};
SKYWAVE_BSDF_TABLE(CoatedConductor)

}  // namespace skywave
#endif  // HWY_ONCE
