// What smooth interfaces reflect: Fresnel's formulae for conductors and dielectrics.
#if defined(SKYWAVE_KERNELS_FRESNEL_INL_H_) == defined(HWY_TARGET_TOGGLE)
#ifdef SKYWAVE_KERNELS_FRESNEL_INL_H_
#undef SKYWAVE_KERNELS_FRESNEL_INL_H_
#else
#define SKYWAVE_KERNELS_FRESNEL_INL_H_
#endif

#include "kernels/bsdf/bsdf-inl.h"

HWY_BEFORE_NAMESPACE();
namespace skywave {
namespace HWY_NAMESPACE {

// Returns the unpolarised Fresnel reflectance of a conductor of index eta + i k at cosine c of the
// angle of incidence (Born and Wolf, 14.2); it is 1 for eta = k = 0.
HWY_INLINE VF FresnelConductor(VF c, VF eta, VF k) {
  const VF c2 = c * c, s2 = 1.0f - c2;
  const VF eta2 = eta * eta, k2 = k * k;
  const VF t0 = eta2 - k2 - s2;
  const VF a2_plus_b2 = hn::Sqrt(t0 * t0 + 4.0f * (eta2 * k2));
  const VF t1 = a2_plus_b2 + c2;
  const VF a = SafeSqrt(0.5f * (a2_plus_b2 + t0));
  const VF t2 = 2.0f * a * c;
  const VF rs = (t1 - t2) / (t1 + t2);
  const VF t3 = c2 * a2_plus_b2 + s2 * s2;
  const VF t4 = t2 * s2;
  // At normal incidence on a perfect mirror t3 = t4 = 0.
  const VF tiny = Set(1e-30f);
  const VF rp = rs * ((t3 - t4 + tiny) / (t3 + t4 + tiny));
  return 0.5f * (rs + rp);
}
HWY_INLINE V3 FresnelConductor(VF c, const V3& eta, const V3& k) {
  return {FresnelConductor(c, eta.x, k.x), FresnelConductor(c, eta.y, k.y),
          FresnelConductor(c, eta.z, k.z)};
}

// FresnelDielectric gives the split by a dielectric of unpolarised light that meets it at cosine
// cos_o; `ratio` is the index on the light's side over that on the other one.
struct Refraction {
  VF reflectance;  // by Fresnel; 1 for total reflection
  VF cosine;       // of the refracted ray, by Snell
};
HWY_INLINE Refraction FresnelDielectric(VF cos_o, VF ratio) {
  const VF one = Set(1.0f);
  const VF ratio2 = ratio * ratio;
  const VF sin2_t = ratio2 * (one - cos_o * cos_o);
  const MF total = hn::Ge(sin2_t, one);
  const VF cos_t = SafeSqrt(one - sin2_t);
  // These are the amplitudes for both polarisations, divided by the index on the far side.
  const VF ro = ratio * cos_o, rt = ratio * cos_t;
  const VF parallel = (cos_o - rt) / (cos_o + rt);
  const VF perpendicular = (ro - cos_t) / (ro + cos_t);
  const VF both = 0.5f * (parallel * parallel + perpendicular * perpendicular);
  return {IfThen(total, one, both), cos_t};
}

// The colour of what dielectrics reflect, where they have one of its own.
struct GlassReflection {
  HWY_INLINE GlassReflection(const MaterialView& m, VU fields)
      : color(Field3(m, fields, kReflection)), given(hn::Gt(color.x, hn::Zero(F()))) {}
  HWY_INLINE V3 Or(const V3& reflectance) const { return IfThen(given, color, reflectance); }
  V3 color;
  MF given;
};

}  // namespace HWY_NAMESPACE
}  // namespace skywave
HWY_AFTER_NAMESPACE();

#endif  // per-target include guard
