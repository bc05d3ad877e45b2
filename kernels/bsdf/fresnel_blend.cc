// Fresnel-blend is the model of Ashikhmin and Shirley 2000 with GGX facets, as the substrate of
// pbrt-v3 has it: with R_d the colour of the body, R_s that of the gloss, and p(c) = (1 - c)^5,
//   f = 28 / (23 pi) R_d (1 - R_s) (1 - p(cos_o / 2)) (1 - p(cos_i / 2))
//     + (R_s + (1 - R_s) p(wo . h)) D(h) / (4 (wo . h) max(cos_o, cos_i)).
// It is reciprocal. The facets are drawn by visible normals, with the probability of their share of
// the albedo as if they were flat, and the body by the cosine.
#include "kernels/bsdf/bsdf.h"
#include "kernels/bsdf/pack.h"

#undef HWY_TARGET_INCLUDE
#define HWY_TARGET_INCLUDE "kernels/bsdf/fresnel_blend.cc"
#include "hwy/foreach_target.h"
#include "hwy/highway.h"
#include "kernels/bsdf/body_and_gloss-inl.h"
#include "kernels/bsdf/bsdf_kernels-inl.h"

HWY_BEFORE_NAMESPACE();
namespace skywave {
namespace HWY_NAMESPACE {

struct FresnelBlend : BodyAndGloss {
  HWY_INLINE FresnelBlend(const SurfaceColumns& s, const MaterialView& m, std::uint32_t i,
                          std::uint32_t n)
      : BodyAndGloss(s, m, i, n) {
    const VF one = Set(1.0f);
    body = body * V3{one - gloss.x, one - gloss.y, one - gloss.z};
  }

  static HWY_INLINE VF FifthPower(VF x) {
    const VF x2 = x * x;
    return x2 * x2 * x;
  }
  // Returns the share of the light from w that enters the body.
  static HWY_INLINE VF Entering(VF cosine) { return 1.0f - FifthPower(1.0f - 0.5f * cosine); }
  HWY_INLINE V3 Fresnel(VF cosine) const {
    const VF one = Set(1.0f), p = FifthPower(one - cosine);
    return {gloss.x + p * (one - gloss.x), gloss.y + p * (one - gloss.y),
            gloss.z + p * (one - gloss.z)};
  }
  HWY_INLINE VF GlossShare(const V3& wo) const {
    return ShareOf(Luminance(Fresnel(Clamp(wo.z, 0.0f, 1.0f))), Luminance(Diffuse(wo)) * kPi);
  }

  HWY_INLINE BsdfValue Evaluate(const V3& wo, const V3& wi) const {
    return Evaluate(wo, wi, GlossShare(wo));
  }
  HWY_INLINE BsdfValue Evaluate(const V3& wo, const V3& wi, VF share) const {
    const V3 h = Ggx::HalfVector(wo, wi);
    const VF d = Ggx::Distribution(h, ggx.alpha * ggx.alpha);
    const VF toward = Clamp(Dot(wo, h), 1e-6f, 1.0f);
    const VF higher = hn::Max(hn::Max(wo.z, wi.z), Set(1e-6f));
    const VF facets = 0.25f * d * wi.z / (toward * higher);
    const VF cosine = wi.z * kInvPi;
    const VF visible = 0.25f * d / (hn::Max(wo.z, Set(1e-6f)) * (1.0f + ggx.Lambda(wo)));
    return {Diffuse(wo) * (28.0f / 23 * wi.z * Entering(wi.z)) + Fresnel(toward) * facets,
            cosine + share * (visible - cosine)};
  }
  HWY_INLINE BsdfSample Draw(const V3& wo, VF u, VF v, VF lobe) const {
    const VF share = GlossShare(wo);
    const V3 wi = Direction(wo, u, v, hn::Lt(lobe, share));
    return SampleOf(wi, Evaluate(wo, wi, share));
  }
  HWY_INLINE VF Blurred(const V3& wo, const V3& wi, VF radius) const {
    const VF c = Clamp(Dot(wo, Ggx::HalfVector(wo, wi)), 0.0f, 1.0f);
    const VF facets = Luminance(Fresnel(c)) * ggx.Blurred(wo, wi, radius);
    return Luminance(Diffuse(wo)) * wi.z + facets;
  }
  // The mean of Entering over wi by the cosine is 23 / 28.
  HWY_INLINE V3 Diffuse(const V3& wo) const { return body * (kInvPi * Entering(wo.z)); }
};

SKYWAVE_BSDF_KERNELS(FresnelBlend)

}  // namespace HWY_NAMESPACE
}  // namespace skywave
HWY_AFTER_NAMESPACE();

#if HWY_ONCE
namespace skywave {

inline constexpr BsdfTraits FresnelBlendTraits = {
    .name = "fresnel-blend",
    .lobed = true,
    .varying = Varying::kSecondColor,
    .parameters = {{"alpha"}, {"second_color", "gloss"}},
    .pack = [](const Material& m, MeasuredBrdfs, MaterialRecord& r) { PackBodyAndGloss(m, r); }};
SKYWAVE_BSDF_TABLE(FresnelBlend)

}  // namespace skywave
#endif  // HWY_ONCE
