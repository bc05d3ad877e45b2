// The rough dielectric has GGX microfacets that reflect and refract (Walter et al. 2007), visible
// normals (Heitz 2018), and masking and shadowing 1 / (1 + Lambda(wo) + Lambda(wi)) on both sides;
// refraction scales radiance by the squared index ratio, as smooth glass does. A facet is drawn,
// then reflection with the probability of its Fresnel reflectance. Scattering between facets is
// left out: at alpha 1 up to a third of the light is lost.
#include "kernels/bsdf/bsdf.h"
#include "kernels/bsdf/pack.h"

#undef HWY_TARGET_INCLUDE
#define HWY_TARGET_INCLUDE "kernels/bsdf/rough_dielectric.cc"
#include "hwy/foreach_target.h"
#include "hwy/highway.h"
#include "kernels/bsdf/ggx-inl.h"

HWY_BEFORE_NAMESPACE();
namespace skywave {
namespace HWY_NAMESPACE {

struct RoughDielectric {
  static constexpr bool kTransmits = true, kRefracts = true;

  HWY_INLINE RoughDielectric(const SurfaceColumns& s, const MaterialView& m, std::uint32_t i,
                             std::uint32_t n)
      : fields(MaterialFields(s, i, n)), color(ColorOf(s, i)), ggx(Field(m, fields, kAlpha)) {
    if (m.varied) ggx = VariedGgx(s, i);
    ratio = IndexRatio(s, m, fields, i);
  }

  HWY_INLINE BsdfValue Evaluate(const V3& wo, const V3& wi) const {
    const VF zero = hn::Zero(F()), one = Set(1.0f);
    const MF above = hn::Gt(wi.z, zero);
    // With refraction h is along -(n_o wo + n_i wi), on wo's side whatever the indices are.
    V3 h = Add(Scale(wo, IfThen(above, one, ratio)), wi);
    h = Scale(h, hn::Div(one, hn::Sqrt(hn::Max(Dot(h, h), Set(1e-20f)))));
    h = Scale(h, hn::CopySign(one, h.z));
    const VF cos_o = Dot(wo, h), cos_i = Dot(wi, h);
    const VF fresnel = FresnelDielectric(Clamp(cos_o, 0.0f, 1.0f), ratio).reflectance;

    const VF lambda_o = ggx.Lambda(wo), lambda_i = ggx.Lambda(wi);
    const VF d = Ggx::Distribution(h, hn::Mul(ggx.alpha, ggx.alpha));
    const VF over_cos = hn::Div(d, hn::Max(wo.z, Set(1e-6f)));
    // The Jacobian makes the density of wi from that of h (eqs. 14 and 17), with the |wo . h| of
    // the visible normals.
    const VF root = hn::Add(hn::Mul(ratio, cos_o), cos_i);
    const VF root2 = hn::Max(hn::Mul(root, root), Set(1e-20f));
    const VF refracts = hn::Div(hn::Mul(hn::Abs(cos_i), hn::Abs(cos_o)), root2);
    const VF jacobian = IfThen(above, Set(0.25f), refracts);
    const VF share = IfThen(above, fresnel, hn::Sub(one, fresnel));
    const VF lobe = hn::Mul(hn::Mul(over_cos, jacobian), share);
    // Both directions see a facet from its own side.
    const MF seen = hn::And(hn::Gt(cos_o, zero), hn::Gt(hn::Mul(cos_i, wi.z), zero));
    const VF visible = hn::IfThenElseZero(seen, lobe);
    const VF g2 = hn::Div(one, hn::Add(hn::Add(one, lambda_o), lambda_i));
    const VF scale = IfThen(above, one, hn::Mul(ratio, ratio));
    return {Scale(color, hn::Mul(hn::Mul(visible, g2), scale)),
            hn::Div(visible, hn::Add(one, lambda_o))};
  }

  HWY_INLINE BsdfSample Draw(const V3& wo, VF u, VF v, VF lobe) const {
    const V3 h = ggx.VisibleNormal(wo, u, v);
    const VF cosine = Clamp(Dot(wo, h), 0.0f, 1.0f);
    const Refraction refraction = FresnelDielectric(cosine, ratio);
    const V3 reflected = Sub(Scale(h, hn::Mul(Set(2.0f), cosine)), wo);
    const V3 refracted = Normalize(
        Sub(Scale(h, hn::Sub(hn::Mul(ratio, cosine), refraction.cosine)), Scale(wo, ratio)));
    const MF reflects = hn::Lt(lobe, refraction.reflectance);
    const V3 wi = IfThen(reflects, reflected, refracted);
    BsdfSample sample = SampleOf(wi, Evaluate(wo, wi));
    // A reflection below the surface, or a refraction above it, meets the facets again and is lost.
    const MF stays = hn::Gt(wi.z, hn::Zero(F()));
    sample.pdf = hn::IfThenElseZero(hn::Not(hn::Xor(stays, reflects)), sample.pdf);
    return sample;
  }

  VU fields;
  V3 color;
  Ggx ggx;
  VF ratio;  // index on wo's side over index on the other
};

SKYWAVE_BSDF_KERNELS(RoughDielectric)

}  // namespace HWY_NAMESPACE
}  // namespace skywave
HWY_AFTER_NAMESPACE();

#if HWY_ONCE
namespace skywave {

inline constexpr BsdfTraits RoughDielectricTraits = {
    .name = "rough-dielectric",
    .lobed = true,
    .varying = Varying::kAlpha,
    .transmits = true,
    .refracts = true,
    .inside = true,
    .parameters = {{"alpha"}, {"ior"}},
    .pack = [](const Material& m, MeasuredBrdfs, MaterialRecord& r) {
      PackAlpha(m, r);
      PutField(r, MaterialField::kIor, m.ior);
    }};
SKYWAVE_BSDF_TABLE(RoughDielectric)

}  // namespace skywave
#endif  // HWY_ONCE
