// Packed radiance becomes vectors of floats here.
#if defined(SKYWAVE_KERNELS_PACKED_RADIANCE_INL_H_) == defined(HWY_TARGET_TOGGLE)
#ifdef SKYWAVE_KERNELS_PACKED_RADIANCE_INL_H_
#undef SKYWAVE_KERNELS_PACKED_RADIANCE_INL_H_
#else
#define SKYWAVE_KERNELS_PACKED_RADIANCE_INL_H_
#endif

#include "kernels/packed_radiance.h"
#include "kernels/simd/simd-inl.h"

HWY_BEFORE_NAMESPACE();
namespace skywave {
namespace HWY_NAMESPACE {

// Returns 2^(exponent - kMaxExponent) of packed radiance, assembled in the exponent field of a
// float.
HWY_INLINE VF PowerOf(VU packed) {
  static_assert(3 * kMantissaBits == 27 && kMaxExponent == 31);
  const VU exponent = hn::And(hn::ShiftRight<4>(packed), SetU(kMaxExponent << 23));
  return AsFloat(hn::Or(exponent, SetU((127 - kMaxExponent) << 23)));
}
HWY_INLINE V3 UnpackRadiance(VU packed, float unit) {
  const VU mantissa = SetU((1u << kMantissaBits) - 1);
  const VF scale = PowerOf(packed) * unit;
  const V3 mantissas = {ToFloat(hn::And(packed, mantissa)),
                        ToFloat(hn::And(hn::ShiftRight<kMantissaBits>(packed), mantissa)),
                        ToFloat(hn::And(hn::ShiftRight<2 * kMantissaBits>(packed), mantissa))};
  return mantissas * scale;
}

}  // namespace HWY_NAMESPACE
}  // namespace skywave
HWY_AFTER_NAMESPACE();

#endif  // per-target include guard
