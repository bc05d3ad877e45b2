// Lambert has f = color / pi (L 2-6) and reflects on both sides. It is drawn by the cosine.
#include "kernels/bsdf/bsdf.h"

#undef HWY_TARGET_INCLUDE
#define HWY_TARGET_INCLUDE "kernels/bsdf/lambert.cc"
#include "hwy/foreach_target.h"
#include "hwy/highway.h"
#include "kernels/bsdf/bsdf_kernels-inl.h"

HWY_BEFORE_NAMESPACE();
namespace skywave {
namespace HWY_NAMESPACE {

struct Lambert {
  static constexpr bool kOnlyDiffuse = true;

  HWY_INLINE Lambert(const SurfaceColumns& s, const MaterialView&, std::uint32_t i, std::uint32_t)
      : color(ColorOf(s, i)) {}

  HWY_INLINE BsdfValue Evaluate(const V3&, const V3& wi) const {
    const VF pdf = wi.z * kInvPi;
    return {color * pdf, pdf};
  }
  HWY_INLINE BsdfSample Draw(const V3&, VF u, VF v, VF) const {
    const V3 wi = CosineHemisphere(u, v);
    return {wi, color, wi.z * kInvPi};
  }
  HWY_INLINE V3 Diffuse(const V3&) const { return color * kInvPi; }

  V3 color;
};

SKYWAVE_BSDF_KERNELS(Lambert)

}  // namespace HWY_NAMESPACE
}  // namespace skywave
HWY_AFTER_NAMESPACE();

#if HWY_ONCE
namespace skywave {

inline constexpr BsdfTraits LambertTraits = {.name = "lambert"};
SKYWAVE_BSDF_TABLE(Lambert)

}  // namespace skywave
#endif  // HWY_ONCE
