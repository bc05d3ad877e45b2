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
  const VF z = 1.0f - 2.0f * v;
  // 1 - z^2 = 4 v (1 - v), which does not cancel at the poles.
  const VF sine = 2.0f * SafeSqrt(v * (1.0f - v));
  VF s, c;
  SinCosTurn(u, s, c);
  return {sine * c, sine * s, z};
}

// Draws a direction uniformly over the cone about +z in which 1 - z is at most `widest`.
HWY_INLINE V3 InCone(VF u, VF v, VF widest) {
  // `below` is 1 - cosine, which is more precise than the cosine in narrow cones.
  const VF below = v * widest;
  const VF cosine = 1.0f - below;
  const VF sine = SafeSqrt(below * (2.0f - below));
  VF s, c;
  SinCosTurn(u, s, c);
  return {sine * c, sine * s, cosine};
}

// Maps the square [-1, 1]^2 to the sphere so that equal areas stay equal (Clarberg 2008). The
// middle is +z and the corners are -z; x grows with a, y with b.
HWY_INLINE V3 DirectionOnEqualAreaSquare(VF a, VF b) {
  const VF one = Set(1.0f);
  // r is the distance from the middle in the norm whose ball is the inner diamond; beyond the
  // diamond lies the lower hemisphere.
  const VF inside = one - (hn::Abs(a) + hn::Abs(b));
  const VF r = one - hn::Abs(inside);
  const VF r2 = r * r;
  const MF pole = hn::Eq(r, hn::Zero(F()));
  const VF along = (hn::Abs(b) - hn::Abs(a)) / IfThen(pole, one, r);
  VF sine, cosine;
  SinCosTurn(Clamp(along + one, 0.0f, 2.0f) * 0.125f, sine, cosine);
  const VF height = hn::CopySign(one - r2, inside);
  const VF side = r * SafeSqrt(2.0f - r2);
  return {side * hn::CopySign(cosine, a), side * hn::CopySign(sine, b), height};
}

// Inverts DirectionOnEqualAreaSquare for unit vectors.
HWY_INLINE void PlaceOnEqualAreaSquare(const V3& d, VF& a, VF& b) {
  const VF one = Set(1.0f), half = Set(0.5f);
  // This is the root of 1 - |z|, which would cancel near the poles.
  const VF side2 = d.x * d.x + d.y * d.y;
  const VF r = hn::Sqrt(side2 / (one + hn::Abs(d.z)));
  const VF along = 8.0f * Atan2Turn(hn::Abs(d.y), hn::Abs(d.x)) - one;
  const VF sum = one - hn::CopySign(one - r, d.z);
  const VF difference = along * r;
  a = hn::CopySign(half * (sum - difference), d.x);
  b = hn::CopySign(half * (sum + difference), d.y);
}

// Draws a direction in the hemisphere of +z with density cos / pi (P 3-6): a uniform point of the
// unit disk, lifted.
HWY_INLINE V3 CosineHemisphere(VF u, VF v) {
  const VF radius = hn::Sqrt(v);
  VF s, c;
  SinCosTurn(u, s, c);
  return {radius * c, radius * s, hn::Sqrt(1.0f - v)};
}

// Maps (u, v) to a uniform point of the unit disk, rings of squares to rings of the disk (Shirley
// and Chiu 1997).
HWY_INLINE void SampleDisc(VF u, VF v, VF& x, VF& y) {
  const VF a = u + u - 1.0f, b = v + v - 1.0f;
  const MF steep = hn::Gt(hn::Abs(b), hn::Abs(a));
  const VF major = IfThen(steep, b, a), minor = IfThen(steep, a, b);
  const MF centre = hn::Eq(major, hn::Zero(F()));
  const VF slope = minor / IfThen(centre, Set(1.0f), major);
  VF sine, cosine;
  SinCosTurn(hn::Abs(slope) * 0.125f, sine, cosine);
  const VF along = major * cosine, across = major * hn::CopySign(sine, slope);
  x = IfThen(steep, across, along);
  y = IfThen(steep, along, across);
}

// Inverts SampleDisc: finds u and v of a point of the unit disk.
HWY_INLINE void DiscUniforms(VF x, VF y, VF& u, VF& v) {
  const VF radius = hn::Sqrt(x * x + y * y);
  const MF steep = hn::Gt(hn::Abs(y), hn::Abs(x));
  const VF along = IfThen(steep, y, x), across = IfThen(steep, x, y);
  const VF major = hn::CopySign(radius, along);
  const VF slope = Atan2Turn(across, hn::Abs(along)) * 8.0f;
  const VF minor = radius * slope;
  const VF half = Set(0.5f);
  u = IfThen(steep, minor, major) * half + half;
  v = IfThen(steep, major, minor) * half + half;
}

}  // namespace HWY_NAMESPACE
}  // namespace skywave
HWY_AFTER_NAMESPACE();

#endif  // per-target include guard
