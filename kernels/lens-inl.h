// Follows rays through the interfaces of a lens, in camera space: x right, y up, z from the film to
// the scene.
#if defined(SKYWAVE_KERNELS_LENS_INL_H_) == defined(HWY_TARGET_TOGGLE)
#ifdef SKYWAVE_KERNELS_LENS_INL_H_
#undef SKYWAVE_KERNELS_LENS_INL_H_
#else
#define SKYWAVE_KERNELS_LENS_INL_H_
#endif  // per-target include guard

#include "kernels/lens.h"
#include "kernels/simd/records-inl.h"

HWY_BEFORE_NAMESPACE();
namespace skywave {
namespace HWY_NAMESPACE {

struct LensRay {
  V3 origin, dir;  // unit
  MF passes;
};

HWY_INLINE MF IsInside(const V3& at, float aperture2) {
  return hn::Le(at.x * at.x + at.y * at.y, Set(aperture2));
}

// A stop is a hole in the plane at `vertex`.
HWY_INLINE void PassStop(float vertex, float aperture2, LensRay& ray) {
  ray.origin = ray.origin + ray.dir * ((vertex - ray.origin.z) / ray.dir.z);
  ray.passes = hn::And(ray.passes, IsInside(ray.origin, aperture2));
}

// Refracts a ray where it meets a sphere: o + t d - (0, 0, vertex) = p has p^2 + 2 radius p.z = 0,
// and of the two places on the axis it is the one at the vertex.
HWY_INLINE void PassSphere(float vertex, float radius, float aperture2, float eta, LensRay& ray) {
  const VF zero = hn::Zero(F()), one = Set(1.0f);
  const V3 from = {ray.origin.x, ray.origin.y, ray.origin.z - vertex};
  const VF b = Dot(from, ray.dir) + radius * ray.dir.z;
  const VF c = Dot(from, from) + (2 * radius) * from.z;
  const VF discriminant = b * b - c, root = SafeSqrt(discriminant);
  const VF t = -c / (radius > 0 ? b + root : b - root);
  const V3 at = from + ray.dir * t;
  const V3 normal = V3{-at.x, -at.y, -radius - at.z} * (1 / radius);  // against the ray
  const VF cosine = -Dot(ray.dir, normal);
  const VF sine2 = (eta * eta) * (one - cosine * cosine);  // of the refracted ray
  ray.passes =
      hn::And(hn::And(ray.passes, hn::Ge(discriminant, zero)),
              hn::And(IsInside(at, aperture2), hn::And(hn::Ge(t, zero), hn::Lt(sine2, one))));
  ray.origin = {at.x, at.y, at.z + vertex};
  ray.dir = ray.dir * eta + normal * (eta * cosine - SafeSqrt(one - sine2));
}

HWY_INLINE void PassLens(const LensView& lens, LensRay& ray) {
  for (std::uint32_t i = 0; i < lens.interfaces; ++i) {
    if (lens.radius[i] == 0) {
      PassStop(lens.vertex[i], lens.aperture2[i], ray);
    } else {
      PassSphere(lens.vertex[i], lens.radius[i], lens.aperture2[i], lens.eta[i], ray);
    }
  }
}

// Returns the ray from the point (x, y) of the film to a point of the box around its exit pupil,
// uniform over its area, and its throughput: the fourth power of its cosine by the box's weight.
HWY_INLINE LensRay ToPupil(const LensView& lens, VF x, VF y, VF u, VF v, VF& throughput) {
  const VF zero = hn::Zero(F()), one = Set(1.0f);
  const VF distance = hn::Sqrt(x * x + y * y);
  const VF step = distance * (float(kPupils) / lens.half_diagonal);
  const VU box = ToUnsigned(hn::Min(step, Set(float(kPupils - 1))));
  // The boxes are those of points on the x axis.
  const MF middle = hn::Eq(distance, zero);
  const VF inverse = one / IfThen(middle, one, distance);
  const VF cos_turn = IfThen(middle, one, x * inverse), sin_turn = y * inverse;
  const VF px = Gather(lens.pupil_x, box) + u * Gather(lens.pupil_width, box);
  const VF py = Gather(lens.pupil_y, box) + v * Gather(lens.pupil_height, box);
  const V3 rear = {cos_turn * px - sin_turn * py, sin_turn * px + cos_turn * py,
                   Set(lens.vertex[0])};
  const V3 film = {x, y, zero};
  const V3 dir = Normalize(rear - film);
  const VF cos2 = dir.z * dir.z;
  throughput = cos2 * cos2 * Gather(lens.pupil_weight, box);
  return {film, dir, hn::Ge(throughput, zero)};
}

}  // namespace HWY_NAMESPACE
}  // namespace skywave
HWY_AFTER_NAMESPACE();

#endif  // per-target include guard
