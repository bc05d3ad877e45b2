// How far the origin of a ray has to be lifted off the triangle that it leaves.
#if defined(SKYWAVE_KERNELS_LIFT_INL_H_) == defined(HWY_TARGET_TOGGLE)
#ifdef SKYWAVE_KERNELS_LIFT_INL_H_
#undef SKYWAVE_KERNELS_LIFT_INL_H_
#else
#define SKYWAVE_KERNELS_LIFT_INL_H_
#endif

#include "kernels/simd/simd-inl.h"

HWY_BEFORE_NAMESPACE();
namespace skywave {
namespace HWY_NAMESPACE {

HWY_INLINE VF LargestCoordinate(const V3& p) {
  return MaxComponent({hn::Abs(p.x), hn::Abs(p.y), hn::Abs(p.z)});
}

// Returns the distance to lift a point of a triangle with the edges a and b, a few times the sum of
// two errors, with u = 2^-24:
// - The point, a mean of the corners, is rounded to a few u of `extent`, its largest coordinate
//   (Pharr et al. 2023, 6.8.6).
// - Embree measures how far an origin is from the plane of the triangle as dot(Ng, corner - origin)
//   and cannot know it better than to a few u of that distance, which is as long as the edges,
//   times the error of Ng = cross(a, b), which is u / sin(angle between a and b).
// The length of the ray that found the point does not matter. A sliver of less than 1/256 of its
// length counts as one of that width: it may hide some rays from itself.
HWY_INLINE VF LiftOff(VF extent, const V3& a, const V3& b) {
  const VF longest2 = hn::Max(Dot(a, a), Dot(b, b));
  const V3 normal = Cross(a, b);
  const VF slimness = hn::Min(longest2 / hn::Sqrt(Dot(normal, normal)), Set(256.0f));
  return extent * 0x1p-20f + hn::Sqrt(longest2) * slimness * 0x1p-21f;
}

}  // namespace HWY_NAMESPACE
}  // namespace skywave
HWY_AFTER_NAMESPACE();

#endif  // per-target include guard
