// This rough diffuse BSDF is the energy-preserving Oren-Nayar model (Portsmouth, Kutz and Hill
// 2025, "EON: A Practical Energy-Preserving Rough Diffuse BRDF"): Fujii's form of Oren and Nayar
// 1994 plus a reciprocal lobe for light that meets more than one facet, so a white one is a white
// furnace. The roughness is the material's `alpha` in [0, 1], where 0 is Lambert. It is drawn by
// the cosine.
#include <algorithm>

#include "kernels/bsdf/bsdf.h"
#include "kernels/bsdf/pack.h"

#undef HWY_TARGET_INCLUDE
#define HWY_TARGET_INCLUDE "kernels/bsdf/oren_nayar.cc"
#include "hwy/foreach_target.h"
#include "hwy/highway.h"
#include "kernels/bsdf/bsdf_kernels-inl.h"

HWY_BEFORE_NAMESPACE();
namespace skywave {
namespace HWY_NAMESPACE {

struct OrenNayar {
  static constexpr MaterialField kRoughness = kAlpha;

  HWY_INLINE OrenNayar(const SurfaceColumns& s, const MaterialView& m, std::uint32_t i,
                       std::uint32_t n)
      : color(ColorOf(s, i)), roughness(Field(m, MaterialFields(s, i, n), kRoughness)) {
    constexpr float kA = 0.5f - 2 / (3 * kPi), kB = 2.0f / 3 - 28 / (15 * kPi);
    const VF one = Set(1.0f);
    a = one / (one + kA * roughness);
    const VF mean = a * (one + kB * roughness);
    lost_mean = hn::Max(one - mean, Set(1e-6f));
    const auto further = [&](VF c) HWY_ATTR {
      const VF series = one - c * lost_mean;
      return c * c * mean / series;
    };
    multiple = {further(color.x), further(color.y), further(color.z)};
  }

  // Returns the share of the light from or to this cosine that single scattering loses: one minus
  // its albedo.
  HWY_INLINE VF Lost(VF cosine) const {
    const VF one = Set(1.0f);
    const VF c = Clamp(cosine, 1e-4f, 1.0f), sine = SafeSqrt(one - c * c);
    const VF angle = (2 * kPi) * Atan2Turn(sine, c);
    const VF sine3 = sine * sine * sine;
    const VF tail = sine / c * (one - sine3) - sine;
    const VF g = sine * (angle - sine * c) + (2.0f / 3) * tail;
    const VF albedo = a * (one + roughness * g * kInvPi);
    return one - albedo;
  }

  HWY_INLINE BsdfValue Evaluate(const V3& wo, const V3& wi) const {
    const VF one = Set(1.0f);
    const VF s = wo.x * wi.x + wo.y * wi.y;
    const VF t = hn::Max(hn::Max(wo.z, wi.z), Set(1e-6f));
    const VF bent = IfThen(hn::Gt(s, hn::Zero(F())), s / t, s);
    const VF single = a * (one + roughness * bent);
    const VF lost = Lost(wo.z) * Lost(wi.z) / lost_mean;
    const VF pdf = wi.z * kInvPi;
    return {(color * single + multiple * lost) * pdf, pdf};
  }
  HWY_INLINE BsdfSample Draw(const V3& wo, VF u, VF v, VF) const {
    const V3 wi = CosineHemisphere(u, v);
    return SampleOf(wi, Evaluate(wo, wi));
  }
  // The mean of Lost(wi) over the cosine is lost_mean.
  HWY_INLINE V3 Diffuse(const V3& wo) const { return (color * a + multiple * Lost(wo.z)) * kInvPi; }

  V3 color;
  VF roughness, a, lost_mean;
  V3 multiple;
};

SKYWAVE_BSDF_KERNELS(OrenNayar)

}  // namespace HWY_NAMESPACE
}  // namespace skywave
HWY_AFTER_NAMESPACE();

#if HWY_ONCE
namespace skywave {

inline constexpr BsdfTraits OrenNayarTraits = {
    .name = "oren-nayar",
    .parameters = {{"alpha"}},
    .pack = [](const Material& m, MeasuredBrdfs, MaterialRecord& r) {
      PutField(r, HWY_NAMESPACE::OrenNayar::kRoughness, std::clamp(m.alpha, 0.0f, 1.0f));
    }};
SKYWAVE_BSDF_TABLE(OrenNayar)

}  // namespace skywave
#endif  // HWY_ONCE
