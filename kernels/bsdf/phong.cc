// Modified Phong (Lafortune and Willems 1994) is color / pi plus the material's second colour, the
// gloss, times (n + 2) / (2 pi) cos^n of the angle to the mirror direction. It is reciprocal, and
// its albedo is at most 1 where the sum of both colours is. A lobe is drawn by its share of that
// sum.
#include "kernels/bsdf/bsdf.h"
#include "kernels/bsdf/pack.h"

#undef HWY_TARGET_INCLUDE
#define HWY_TARGET_INCLUDE "kernels/bsdf/phong.cc"
#include "hwy/foreach_target.h"
#include "hwy/highway.h"
#include "kernels/bsdf/bsdf_kernels-inl.h"
#include "kernels/bsdf/power-inl.h"

HWY_BEFORE_NAMESPACE();
namespace skywave {
namespace HWY_NAMESPACE {

struct Phong {
  HWY_INLINE Phong(const SurfaceColumns& s, const MaterialView& m, std::uint32_t i, std::uint32_t n)
      : fields(MaterialFields(s, i, n)),
        diffuse(ColorOf(s, i)),
        gloss(Field3(m, fields, kGloss)),
        exponent(PowerOfWidth(Field(m, fields, kAlpha))) {
    const VF sum = MaxComponent(diffuse) + MaxComponent(gloss);
    share = MaxComponent(gloss) / hn::Max(sum, Set(1e-30f));
  }

  HWY_INLINE BsdfValue Evaluate(const V3& wo, const V3& wi) const {
    const V3 mirrored = {-wo.x, -wo.y, wo.z};
    const VF power = Pow(Clamp(Dot(mirrored, wi), 0.0f, 1.0f), exponent);
    const VF lobe = (exponent + 2.0f) * (0.5f * kInvPi) * power;
    const VF density = (exponent + 1.0f) * (0.5f * kInvPi) * power;
    const VF cosine = wi.z * kInvPi;
    return {diffuse * cosine + gloss * (lobe * wi.z), cosine + share * (density - cosine)};
  }

  HWY_INLINE BsdfSample Draw(const V3& wo, VF u, VF v, VF lobe) const {
    const VF one = Set(1.0f);
    const V3 mirrored = {-wo.x, -wo.y, wo.z};
    const V3 about = AboutPole(u, Pow(v, one / (exponent + one)));
    const V3 glossy = ToWorld(MakeFrame(mirrored), about);
    const V3 wi = IfThen(hn::Lt(lobe, share), glossy, CosineHemisphere(u, v));
    return SampleOf(wi, Evaluate(wo, wi));
  }
  HWY_INLINE V3 Diffuse(const V3&) const { return diffuse * kInvPi; }

  VU fields;
  V3 diffuse, gloss;
  VF exponent, share;
};

SKYWAVE_BSDF_KERNELS(Phong)

}  // namespace HWY_NAMESPACE
}  // namespace skywave
HWY_AFTER_NAMESPACE();

#if HWY_ONCE
namespace skywave {

inline constexpr BsdfTraits PhongTraits = {
    .name = "phong",
    .lobed = true,
    .parameters = {{"alpha"}, {"second_color", "gloss"}},
    .pack = [](const Material& m, MeasuredBrdfs, MaterialRecord& r) {
      PutField(r, MaterialField::kAlpha, MicrofacetWidth(m.alpha));
      PutField(r, MaterialField::kGloss, m.second_color);
    }};
SKYWAVE_BSDF_TABLE(Phong)

}  // namespace skywave
#endif  // HWY_ONCE
