// The cosine-power lobes share these functions. Their exponent comes from the width of the Beckmann
// facets that they resemble (Walter et al. 2007, section 5.2).
#if defined(SKYWAVE_KERNELS_POWER_INL_H_) == defined(HWY_TARGET_TOGGLE)
#ifdef SKYWAVE_KERNELS_POWER_INL_H_
#undef SKYWAVE_KERNELS_POWER_INL_H_
#else
#define SKYWAVE_KERNELS_POWER_INL_H_
#endif

#include "kernels/bsdf/ggx-inl.h"
#include "kernels/simd/exp-inl.h"

HWY_BEFORE_NAMESPACE();
namespace skywave {
namespace HWY_NAMESPACE {

// Returns 2 / alpha^2 - 2 for alpha of at least 0.02: a float's cosine has no digits for narrower
// lobes.
HWY_INLINE VF PowerOfWidth(VF alpha) {
  const VF width = hn::Max(alpha, Set(0.02f));
  return hn::Max(2.0f / (width * width) - 2.0f, hn::Zero(F()));
}

// Returns the unit vector with that cosine to +z, `u` turns about it.
HWY_INLINE V3 AboutPole(VF u, VF cosine) {
  const VF one = Set(1.0f);
  const VF sine = SafeSqrt((one - cosine) * (one + cosine));
  VF s, c;
  SinCosTurn(u, s, c);
  return {sine * c, sine * s, cosine};
}

}  // namespace HWY_NAMESPACE
}  // namespace skywave
HWY_AFTER_NAMESPACE();

#endif  // per-target include guard
