// The heuristic by which ways to sample the same path share it, in one place: power, exponent 2.
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

// One ratio of densities that counts as much as both. (The balance heuristic would add them.)
HWY_INLINE VF Join(VF a, VF b) { return hn::Sqrt(hn::Add(hn::Mul(a, a), hn::Mul(b, b))); }

// The weight of a way to which others have the ratios `a` and `b`; 1 without multiple importance
// sampling.
HWY_INLINE VF HeuristicWeight(const MisPolicy& mis, VF a, VF b) {
  const VF one = Set(1.0f);
  if (!mis.enabled) return one;
  return hn::Div(one, hn::Add(one, hn::Add(hn::Mul(a, a), hn::Mul(b, b))));
}

// Keeps ratios where a product of two of them is finite: infinity times zero would be no number.
HWY_INLINE VF Bounded(VF ratio) { return hn::Min(ratio, Set(1e18f)); }

}  // namespace HWY_NAMESPACE
}  // namespace skywave
HWY_AFTER_NAMESPACE();

#endif  // per-target include guard
