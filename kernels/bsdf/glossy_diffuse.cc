// Glossy-diffuse is a Lambertian body and the facets of a dielectric beside each other: light is
// not taken from the body where the facets reflect it (Pharr, Jakob and Humphreys 2016, 9.2, the
// plastic and the uber material of pbrt-v3). So its albedo may exceed 1 if the sum of its colours
// does, and f = color / pi + gloss F D G / (4 cos_o cos_i), of GGX facets with height-correlated
// masking and the Fresnel reflectance of `ior`. An index below 1 reflects all light at grazing
// angles; pbrt's plastic has 1 / 1.5.
//
// The facets are drawn by visible normals, with the probability of their share of the albedo, and
// the body by the cosine.
#include "kernels/bsdf/bsdf.h"
#include "kernels/bsdf/pack.h"

#undef HWY_TARGET_INCLUDE
#define HWY_TARGET_INCLUDE "kernels/bsdf/glossy_diffuse.cc"
#include "hwy/foreach_target.h"
#include "hwy/highway.h"
#include "kernels/bsdf/body_and_gloss-inl.h"
#include "kernels/bsdf/bsdf_kernels-inl.h"

HWY_BEFORE_NAMESPACE();
namespace skywave {
namespace HWY_NAMESPACE {

struct GlossyDiffuse : BodyAndGloss {
  HWY_INLINE GlossyDiffuse(const SurfaceColumns& s, const MaterialView& m, std::uint32_t i,
                           std::uint32_t n)
      : BodyAndGloss(s, m, i, n), ratio(IndexRatio(s, m, fields, i)) {}

  HWY_INLINE VF Fresnel(VF cosine) const { return FresnelDielectric(cosine, ratio).reflectance; }
  // Facets that lean away by their width may reflect far more than a flat surface.
  HWY_INLINE VF GlossShare(const V3& wo) const {
    const VF leaning = Fresnel(hn::Max(wo.z - ggx.alpha, hn::Zero(F())));
    const VF albedo = 0.5f * (Fresnel(wo.z) + leaning);
    return ShareOf(Luminance(gloss) * albedo, Luminance(body));
  }

  HWY_INLINE BsdfValue Evaluate(const V3& wo, const V3& wi) const {
    return Evaluate(wo, wi, GlossShare(wo));
  }
  HWY_INLINE BsdfValue Evaluate(const V3& wo, const V3& wi, VF share) const {
    const VF one = Set(1.0f);
    const V3 h = Ggx::HalfVector(wo, wi);
    const VF d = Ggx::Distribution(h, ggx.alpha * ggx.alpha);
    const VF lambda_o = ggx.Lambda(wo), lambda_i = ggx.Lambda(wi);
    const VF over_4_cos = d * 0.25f / hn::Max(wo.z, Set(1e-6f));
    const VF lobe = over_4_cos / (one + lambda_o + lambda_i);
    const VF fresnel = Fresnel(Clamp(Dot(wo, h), 0.0f, 1.0f));
    const VF cosine = wi.z * kInvPi, visible = over_4_cos / (one + lambda_o);
    return {body * cosine + gloss * (fresnel * lobe), cosine + share * (visible - cosine)};
  }
  HWY_INLINE BsdfSample Draw(const V3& wo, VF u, VF v, VF lobe) const {
    const VF share = GlossShare(wo);
    const V3 wi = Direction(wo, u, v, hn::Lt(lobe, share));
    return SampleOf(wi, Evaluate(wo, wi, share));
  }
  HWY_INLINE VF Blurred(const V3& wo, const V3& wi, VF radius) const {
    const VF c = Clamp(Dot(wo, Ggx::HalfVector(wo, wi)), 0.0f, 1.0f);
    const VF facets = Luminance(gloss) * Fresnel(c) * ggx.Blurred(wo, wi, radius);
    return Luminance(body) * (wi.z * kInvPi) + facets;
  }
  HWY_INLINE V3 Diffuse(const V3&) const { return body * kInvPi; }

  VF ratio;  // of the index on wo's side to that on the other
};

SKYWAVE_BSDF_KERNELS(GlossyDiffuse)

}  // namespace HWY_NAMESPACE
}  // namespace skywave
HWY_AFTER_NAMESPACE();

#if HWY_ONCE
namespace skywave {

inline constexpr BsdfTraits GlossyDiffuseTraits = {
    .name = "glossy-diffuse",
    .lobed = true,
    .varying = Varying::kSecondColor,
    .parameters = {{"alpha"}, {"second_color", "gloss"}, {"ior"}},
    .pack = [](const Material& m, MeasuredBrdfs, MaterialRecord& r) {
      PackBodyAndGloss(m, r);
      PutField(r, MaterialField::kIor, m.ior);
    }};
SKYWAVE_BSDF_TABLE(GlossyDiffuse)

}  // namespace skywave
#endif  // HWY_ONCE
