// The disk that light from infinitely far away comes in by: perpendicular to its direction, as wide
// as the sphere around the scene. A place on it is a point of the unit square (SampleDisc).
#if defined(SKYWAVE_KERNELS_DISK_INL_H_) == defined(HWY_TARGET_TOGGLE)
#ifdef SKYWAVE_KERNELS_DISK_INL_H_
#undef SKYWAVE_KERNELS_DISK_INL_H_
#else
#define SKYWAVE_KERNELS_DISK_INL_H_
#endif

#include "kernels/emission.h"
#include "kernels/sphere-inl.h"

HWY_BEFORE_NAMESPACE();
namespace skywave {
namespace HWY_NAMESPACE {

// Where light that comes from `towards` enters the scene, before the sphere.
HWY_INLINE V3 DiskPoint(const SceneSphere& sphere, const V3& towards, VF u, VF v) {
  VF x, y;
  SampleDisc(u, v, x, y);
  const Frame frame = MakeFrame(towards);
  const V3 from_center = Add(Add(Scale(frame.s, x), Scale(frame.t, y)), towards);
  return Add(Set3(sphere.center), Scale(from_center, Set(sphere.radius)));
}

// Where on the disk the line along `towards` through `point` enters.
HWY_INLINE void DiskPlace(const SceneSphere& sphere, const V3& towards, const V3& point, VF& u,
                          VF& v) {
  const V3 from_center = Sub(point, Set3(sphere.center));
  const Frame frame = MakeFrame(towards);
  const VF inverse = Set(1 / sphere.radius);
  DiscUniforms(hn::Mul(Dot(frame.s, from_center), inverse),
               hn::Mul(Dot(frame.t, from_center), inverse), u, v);
}

}  // namespace HWY_NAMESPACE
}  // namespace skywave
HWY_AFTER_NAMESPACE();

#endif  // per-target include guard
