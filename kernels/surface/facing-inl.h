// Bent shading normals are turned here until they face the eye.
#if defined(SKYWAVE_KERNELS_FACING_INL_H_) == defined(HWY_TARGET_TOGGLE)
#ifdef SKYWAVE_KERNELS_FACING_INL_H_
#undef SKYWAVE_KERNELS_FACING_INL_H_
#else
#define SKYWAVE_KERNELS_FACING_INL_H_
#endif

#include "kernels/simd/simd-inl.h"

HWY_BEFORE_NAMESPACE();
namespace skywave {
namespace HWY_NAMESPACE {

// A bent normal that looks at the eye stays as it is; others end at about this cosine.
inline constexpr float kGrazing = 0x1p-7f;
HWY_INLINE V3 FacingBentNormal(const V3& ns, const V3& wo) {
  const VF missing = kGrazing - Dot(ns, wo);
  return Normalize(ns + wo * hn::Max(missing, hn::Zero(F())));
}

}  // namespace HWY_NAMESPACE
}  // namespace skywave
HWY_AFTER_NAMESPACE();

#endif  // per-target include guard
