// The techniques that can sample the same path share it by the power heuristic with exponent 2,
// which is defined here alone.
#if defined(SKYWAVE_KERNELS_HEURISTIC_INL_H_) == defined(HWY_TARGET_TOGGLE)
#ifdef SKYWAVE_KERNELS_HEURISTIC_INL_H_
#undef SKYWAVE_KERNELS_HEURISTIC_INL_H_
#else
#define SKYWAVE_KERNELS_HEURISTIC_INL_H_
#endif

#include "kernels/bsdf/bsdf.h"
#include "kernels/simd/math-inl.h"

HWY_BEFORE_NAMESPACE();
namespace skywave {
namespace HWY_NAMESPACE {

// Combines two ratios of densities into one that weighs as much as both. (The balance heuristic
// would add them.)
HWY_INLINE VF Join(VF a, VF b) { return hn::Sqrt(a * a + b * b); }

// Returns the weight of a technique whose competitors have the density ratios `a` and `b`; 1
// without multiple importance sampling.
HWY_INLINE VF HeuristicWeight(const MisPolicy& mis, VF a, VF b) {
  const VF one = Set(1.0f);
  if (!mis.enabled) return one;
  return one / (one + (a * a + b * b));
}

// Bounds a ratio so that the product of two is finite: infinity times zero would be NaN.
HWY_INLINE VF Bounded(VF ratio) { return hn::Min(ratio, Set(1e18f)); }

}  // namespace HWY_NAMESPACE
}  // namespace skywave
HWY_AFTER_NAMESPACE();

#endif  // per-target include guard
