// Light from infinitely far away enters through a disk that is perpendicular to its direction and
// as wide as the sphere around the scene. A place on it is a point of the unit square (SampleDisc).
#if defined(SKYWAVE_KERNELS_EMISSION_INL_H_) == defined(HWY_TARGET_TOGGLE)
#ifdef SKYWAVE_KERNELS_EMISSION_INL_H_
#undef SKYWAVE_KERNELS_EMISSION_INL_H_
#else
#define SKYWAVE_KERNELS_EMISSION_INL_H_
#endif

#include "kernels/light_paths/emission.h"
#include "kernels/simd/sphere-inl.h"

HWY_BEFORE_NAMESPACE();
namespace skywave {
namespace HWY_NAMESPACE {

// Returns the point at (u, v) of the disk for light that comes from `towards`; it lies in front of
// the sphere.
HWY_INLINE V3 DiskPoint(const SceneSphere& sphere, const V3& towards, VF u, VF v) {
  VF x, y;
  SampleDisc(u, v, x, y);
  const Frame frame = MakeFrame(towards);
  const V3 from_center = frame.s * x + frame.t * y + towards;
  return Set3(sphere.center) + from_center * sphere.radius;
}

// Finds the place (u, v) where the line along `towards` through `point` crosses the disk.
HWY_INLINE void DiskPlace(const SceneSphere& sphere, const V3& towards, const V3& point, VF& u,
                          VF& v) {
  const V3 from_center = point - Set3(sphere.center);
  const Frame frame = MakeFrame(towards);
  const VF inverse = Set(1 / sphere.radius);
  DiscUniforms(Dot(frame.s, from_center) * inverse, Dot(frame.t, from_center) * inverse, u, v);
}

// Moves the origin of a ray that begins in front of the sphere to where the ray enters the box: the
// shorter the ray, the more exact u and v of its hit.
HWY_INLINE V3 EnterBox(const SceneSphere& sphere, const V3& org, const V3& dir) {
  const auto entry = [](VF from, VF along, float low, float high) HWY_ATTR {
    const VF speed = hn::CopySign(hn::Max(hn::Abs(along), Set(1e-20f)), along);
    const VF inverse = 1.0f / speed;
    return hn::Min((low - from) * inverse, (high - from) * inverse);
  };
  const V3 t = {entry(org.x, dir.x, sphere.low[0], sphere.high[0]),
                entry(org.y, dir.y, sphere.low[1], sphere.high[1]),
                entry(org.z, dir.z, sphere.low[2], sphere.high[2])};
  // Rays that miss the box may begin anywhere along their line.
  return org + dir * Clamp(MaxComponent(t), 0.0f, 2 * sphere.radius);
}

// Returns where light that comes from `towards` enters the scene: a point of the disk, moved to the
// box.
HWY_INLINE V3 EnterScene(const SceneSphere& sphere, const V3& towards, VF u, VF v) {
  return EnterBox(sphere, DiskPoint(sphere, towards, u, v), -towards);
}

}  // namespace HWY_NAMESPACE
}  // namespace skywave
HWY_AFTER_NAMESPACE();

#endif  // per-target include guard
