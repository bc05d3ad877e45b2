// The rough conductor has GGX microfacets (Walter et al. 2007), height-correlated Smith masking,
// visible normals (Heitz 2018, as spherical caps after Dupuy and Benyoub 2023), the Fresnel
// reflectance of a complex index, and the reciprocal multiple-scattering lobe of Kulla and Conty
// 2017, so that F = 1 loses nothing. That lobe is drawn with the probability that light scatters
// more than once.
#if defined(SKYWAVE_KERNELS_CONDUCTOR_INL_H_) == defined(HWY_TARGET_TOGGLE)
#ifdef SKYWAVE_KERNELS_CONDUCTOR_INL_H_
#undef SKYWAVE_KERNELS_CONDUCTOR_INL_H_
#else
#define SKYWAVE_KERNELS_CONDUCTOR_INL_H_
#endif

#include "kernels/bsdf/ggx-inl.h"

HWY_BEFORE_NAMESPACE();
namespace skywave {
namespace HWY_NAMESPACE {

struct Conductor {
  HWY_INLINE Conductor(const SurfaceColumns& s, const MaterialView& m, std::uint32_t i,
                       std::uint32_t n)
      : fields(MaterialFields(s, i, n)),
        color(ColorOf(s, i)),
        tables(*m.conductor),
        ggx(Field(m, fields, kAlpha)),
        eta(Field3(m, fields, kEta)),
        k(Field3(m, fields, kK)),
        multiscatter(Field3(m, fields, kMultiscatter)) {
    if (!m.varied) return;
    ggx = VariedGgx(s, i);
    MetalOfColor(color, eta, k);
    const V3 varied = Multiscatter(ggx.Mean(tables.padded_mean_albedo), eta, k);
    multiscatter = IfThen(Compensates(multiscatter), varied, multiscatter);
  }

  HWY_INLINE VF Albedo(VF cosine) const { return ggx.Table(tables.albedo, cosine); }

  // The Fresnel reflectance is left out: it is nearly the same for all wi that matter.
  HWY_INLINE VF Blurred(const V3& wo, const V3& wi, VF radius) const {
    return Luminance(color) * ggx.Blurred(wo, wi, radius);
  }

  HWY_INLINE BsdfValue Evaluate(const V3& wo, const V3& wi) const {
    const V3 h = Ggx::HalfVector(wo, wi);
    const VF d = Ggx::Distribution(h, ggx.alpha * ggx.alpha);
    const VF lambda_o = ggx.Lambda(wo), lambda_i = ggx.Lambda(wi);
    const VF one = Set(1.0f);
    const VF quarter_over_cos = 0.25f / hn::Max(wo.z, Set(1e-6f));
    const VF g2 = one / (one + lambda_o + lambda_i);
    const VF g1 = one / (one + lambda_o);
    const V3 fresnel = FresnelConductor(hn::Min(hn::Abs(Dot(wo, h)), one), eta, k);
    const VF single = d * g2 * quarter_over_cos;
    const VF lost_o = one - Albedo(wo.z), lost_i = one - Albedo(wi.z);
    const VF multiple = lost_o * lost_i * wi.z;
    const V3 value = color * (fresnel * single + multiscatter * multiple);
    const VF visible = d * g1 * quarter_over_cos;
    const VF diffuse = wi.z * kInvPi;
    return {value, visible + lost_o * (diffuse - visible)};
  }

  HWY_INLINE V3 Direction(const V3& wo, VF u, VF v, VF lobe) const {
    const MF multiple = hn::Lt(lobe, 1.0f - Albedo(wo.z));
    return IfThen(multiple, CosineHemisphere(u, v), ggx.Reflect(wo, u, v));
  }
  HWY_INLINE BsdfSample Draw(const V3& wo, VF u, VF v, VF lobe) const {
    const V3 wi = Direction(wo, u, v, lobe);
    return SampleOf(wi, Evaluate(wo, wi));
  }

  VU fields;
  V3 color;
  const ConductorTables& tables;
  Ggx ggx;
  V3 eta, k, multiscatter;
};

}  // namespace HWY_NAMESPACE
}  // namespace skywave
HWY_AFTER_NAMESPACE();

#endif  // per-target include guard
