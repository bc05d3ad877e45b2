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
#include "kernels/bsdf/bsdf-inl.h"

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
    a = hn::Div(one, hn::Add(one, hn::Mul(Set(kA), roughness)));
    const VF mean = hn::Mul(a, hn::Add(one, hn::Mul(Set(kB), roughness)));
    lost_mean = hn::Max(hn::Sub(one, mean), Set(1e-6f));
    const auto further = [&](VF c) HWY_ATTR {
      const VF series = hn::Sub(one, hn::Mul(c, lost_mean));
      return hn::Div(hn::Mul(hn::Mul(c, c), mean), series);
    };
    multiple = {further(color.x), further(color.y), further(color.z)};
  }

  // Returns the share of the light from or to this cosine that single scattering loses: one minus
  // its albedo.
  HWY_INLINE VF Lost(VF cosine) const {
    const VF one = Set(1.0f);
    const VF c = Clamp(cosine, 1e-4f, 1.0f), sine = SafeSqrt(hn::Sub(one, hn::Mul(c, c)));
    const VF angle = hn::Mul(Set(2 * kPi), Atan2Turn(sine, c));
    const VF sine3 = hn::Mul(hn::Mul(sine, sine), sine);
    const VF tail = hn::Sub(hn::Mul(hn::Div(sine, c), hn::Sub(one, sine3)), sine);
    const VF g =
        hn::Add(hn::Mul(sine, hn::Sub(angle, hn::Mul(sine, c))), hn::Mul(Set(2.0f / 3), tail));
    const VF albedo = hn::Mul(a, hn::Add(one, hn::Mul(hn::Mul(roughness, g), Set(kInvPi))));
    return hn::Sub(one, albedo);
  }

  HWY_INLINE BsdfValue Evaluate(const V3& wo, const V3& wi) const {
    const VF one = Set(1.0f);
    const VF s = hn::Add(hn::Mul(wo.x, wi.x), hn::Mul(wo.y, wi.y));
    const VF t = hn::Max(hn::Max(wo.z, wi.z), Set(1e-6f));
    const VF bent = IfThen(hn::Gt(s, hn::Zero(F())), hn::Div(s, t), s);
    const VF single = hn::Mul(a, hn::Add(one, hn::Mul(roughness, bent)));
    const VF lost = hn::Div(hn::Mul(Lost(wo.z), Lost(wi.z)), lost_mean);
    const VF pdf = hn::Mul(wi.z, Set(kInvPi));
    return {Scale(Add(Scale(color, single), Scale(multiple, lost)), pdf), pdf};
  }
  HWY_INLINE BsdfSample Draw(const V3& wo, VF u, VF v, VF) const {
    const V3 wi = CosineHemisphere(u, v);
    return SampleOf(wi, Evaluate(wo, wi));
  }
  // The mean of Lost(wi) over the cosine is lost_mean.
  HWY_INLINE V3 Diffuse(const V3& wo) const {
    return Scale(Add(Scale(color, a), Scale(multiple, Lost(wo.z))), Set(kInvPi));
  }

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
    .guided = true,
    .parameters = {{"alpha"}},
    .pack = [](const Material& m, MeasuredBrdfs, MaterialRecord& r) {
      PutField(r, HWY_NAMESPACE::OrenNayar::kRoughness, std::clamp(m.alpha, 0.0f, 1.0f));
    }};
SKYWAVE_BSDF_TABLE(OrenNayar)

}  // namespace skywave
#endif  // HWY_ONCE
