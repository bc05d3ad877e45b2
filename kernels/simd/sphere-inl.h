// These functions draw directions and points from simple densities, on vectors.
#if defined(SKYWAVE_KERNELS_SPHERE_INL_H_) == defined(HWY_TARGET_TOGGLE)
#ifdef SKYWAVE_KERNELS_SPHERE_INL_H_
#undef SKYWAVE_KERNELS_SPHERE_INL_H_
#else
#define SKYWAVE_KERNELS_SPHERE_INL_H_
#endif

#include "kernels/simd/math-inl.h"

HWY_BEFORE_NAMESPACE();
namespace skywave {
namespace HWY_NAMESPACE {

// Draws a direction uniformly over the sphere, with density 1 / 4 pi.
HWY_INLINE V3 UniformSphere(VF u, VF v) {
  const VF z = hn::Sub(Set(1.0f), hn::Mul(Set(2.0f), v));
  // 1 - z^2 = 4 v (1 - v), which does not cancel at the poles.
  const VF sine = hn::Mul(Set(2.0f), SafeSqrt(hn::Mul(v, hn::Sub(Set(1.0f), v))));
  VF s, c;
  SinCosTurn(u, s, c);
  return {hn::Mul(sine, c), hn::Mul(sine, s), z};
}

// Draws a direction in the hemisphere of +z with density cos / pi (P 3-6): a uniform point of the
// unit disk, lifted.
HWY_INLINE V3 CosineHemisphere(VF u, VF v) {
  const VF radius = hn::Sqrt(v);
  VF s, c;
  SinCosTurn(u, s, c);
  return {hn::Mul(radius, c), hn::Mul(radius, s), hn::Sqrt(hn::Sub(Set(1.0f), v))};
}

// Maps (u, v) to a uniform point of the unit disk, rings of squares to rings of the disk (Shirley
// and Chiu 1997).
HWY_INLINE void SampleDisc(VF u, VF v, VF& x, VF& y) {
  const VF a = hn::Sub(hn::Add(u, u), Set(1.0f)), b = hn::Sub(hn::Add(v, v), Set(1.0f));
  const MF steep = hn::Gt(hn::Abs(b), hn::Abs(a));
  const VF major = IfThen(steep, b, a), minor = IfThen(steep, a, b);
  const MF centre = hn::Eq(major, hn::Zero(F()));
  const VF slope = hn::Div(minor, IfThen(centre, Set(1.0f), major));
  VF sine, cosine;
  SinCosTurn(hn::Mul(hn::Abs(slope), Set(0.125f)), sine, cosine);
  const VF along = hn::Mul(major, cosine), across = hn::Mul(major, hn::CopySign(sine, slope));
  x = IfThen(steep, across, along);
  y = IfThen(steep, along, across);
}

// Inverts SampleDisc: finds u and v of a point of the unit disk.
HWY_INLINE void DiscUniforms(VF x, VF y, VF& u, VF& v) {
  const VF radius = hn::Sqrt(hn::Add(hn::Mul(x, x), hn::Mul(y, y)));
  const MF steep = hn::Gt(hn::Abs(y), hn::Abs(x));
  const VF along = IfThen(steep, y, x), across = IfThen(steep, x, y);
  const VF major = hn::CopySign(radius, along);
  const VF slope = hn::Mul(Atan2Turn(across, hn::Abs(along)), Set(8.0f));
  const VF minor = hn::Mul(radius, slope);
  const VF half = Set(0.5f);
  u = hn::Add(hn::Mul(IfThen(steep, minor, major), half), half);
  v = hn::Add(hn::Mul(IfThen(steep, major, minor), half), half);
}

}  // namespace HWY_NAMESPACE
}  // namespace skywave
HWY_AFTER_NAMESPACE();

#endif  // per-target include guard
