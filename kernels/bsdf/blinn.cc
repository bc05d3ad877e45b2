// Blinn's microfacets (Blinn 1977) have D = (n + 2) / (2 pi) cos^n of the half vector's angle,
// masking by V-cavities (Torrance and Sparrow 1967) and the Fresnel reflectance of a complex index.
// Half vectors are drawn by D.
#include "kernels/bsdf/bsdf.h"
#include "kernels/bsdf/pack.h"

#undef HWY_TARGET_INCLUDE
#define HWY_TARGET_INCLUDE "kernels/bsdf/blinn.cc"
#include "hwy/foreach_target.h"
#include "hwy/highway.h"
#include "kernels/bsdf/bsdf_kernels-inl.h"
#include "kernels/bsdf/power-inl.h"

HWY_BEFORE_NAMESPACE();
namespace skywave {
namespace HWY_NAMESPACE {

struct Blinn {
  HWY_INLINE Blinn(const SurfaceColumns& s, const MaterialView& m, std::uint32_t i, std::uint32_t n)
      : fields(MaterialFields(s, i, n)),
        color(ColorOf(s, i)),
        exponent(PowerOfWidth(Field(m, fields, kAlpha))),
        eta(Field3(m, fields, kEta)),
        k(Field3(m, fields, kK)) {}

  HWY_INLINE BsdfValue Evaluate(const V3& wo, const V3& wi) const {
    const VF one = Set(1.0f);
    const V3 h = Ggx::HalfVector(wo, wi);
    const VF toward = Clamp(Dot(wo, h), 1e-6f, 1.0f);
    const VF scale = (exponent + 2.0f) * (0.5f * kInvPi);
    const VF d = scale * Pow(h.z, exponent);
    const VF lower = hn::Min(wo.z, wi.z);
    const VF g = hn::Min(2.0f * (h.z * lower) / toward, one);
    const VF quarter_over_cos = 0.25f / hn::Max(wo.z, Set(1e-6f));
    const V3 fresnel = FresnelConductor(toward, eta, k);
    return {color * fresnel * (d * g * quarter_over_cos), d * h.z / (4.0f * toward)};
  }

  HWY_INLINE BsdfSample Draw(const V3& wo, VF u, VF v, VF) const {
    const VF one = Set(1.0f), two = Set(2.0f);
    const V3 h = AboutPole(u, Pow(v, one / (exponent + two)));
    const VF toward = Dot(wo, h);
    const V3 wi = h * (two * toward) - wo;
    BsdfSample sample = SampleOf(wi, Evaluate(wo, wi));
    // A facet that looks away reflects nothing.
    sample.pdf = hn::IfThenElseZero(hn::Gt(toward, hn::Zero(F())), sample.pdf);
    return sample;
  }

  VU fields;
  V3 color;
  VF exponent;
  V3 eta, k;
};

SKYWAVE_BSDF_KERNELS(Blinn)

}  // namespace HWY_NAMESPACE
}  // namespace skywave
HWY_AFTER_NAMESPACE();

#if HWY_ONCE
namespace skywave {

inline constexpr BsdfTraits BlinnTraits = {
    .name = "blinn",
    .parameters = {{"alpha"}, {"eta"}, {"k"}},
    .pack = [](const Material& m, MeasuredBrdfs, MaterialRecord& r) {
      PutField(r, MaterialField::kAlpha, MicrofacetWidth(m.alpha));
      PackConductorIndex(m, r);
    }};
SKYWAVE_BSDF_TABLE(Blinn)

}  // namespace skywave
#endif  // HWY_ONCE
