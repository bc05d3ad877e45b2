// The BSDFs that are made of GGX microfacets share their distribution, masking, visible normals,
// and the albedo of the single-scattering lobe from its tables. Directions are in local frames.
#if defined(SKYWAVE_KERNELS_GGX_INL_H_) == defined(HWY_TARGET_TOGGLE)
#ifdef SKYWAVE_KERNELS_GGX_INL_H_
#undef SKYWAVE_KERNELS_GGX_INL_H_
#else
#define SKYWAVE_KERNELS_GGX_INL_H_
#endif

#include "kernels/bsdf/conductor_tables.h"
#include "kernels/bsdf/fresnel-inl.h"

HWY_BEFORE_NAMESPACE();
namespace skywave {
namespace HWY_NAMESPACE {

// Draws a visible normal of widths x and y (Heitz 2018, as spherical caps after Dupuy and Benyoub
// 2023).
HWY_INLINE V3 VisibleGgxNormal(const V3& wo, VF x, VF y, VF u, VF v) {
  const V3 stretched = Normalize({wo.x * x, wo.y * y, wo.z});
  const VF one = Set(1.0f);
  const VF cap = one - v * (one + stretched.z);
  const VF radius = SafeSqrt(one - cap * cap);
  VF s, c;
  SinCosTurn(u, s, c);
  return Normalize({(radius * c + stretched.x) * x, (radius * s + stretched.y) * y,
                    hn::Max(cap + stretched.z, Set(1e-7f))});
}

// One vector of widths and their rows in the tables.
struct Ggx {
  HWY_INLINE explicit Ggx(VF width) : alpha(width) {
    const VF row = hn::Sqrt(alpha) * float(kAlbedoRows - 1);
    table_row = hn::Min(ToUnsigned(row), SetU(kAlbedoRows - 1));
    row_share = row - ToFloat(table_row);
  }

  // Looks up a table of the cosine, bilinearly in the square roots.
  HWY_INLINE VF Table(const float* table, VF cosine) const {
    const VF at = hn::Sqrt(Clamp(cosine, 0.0f, 1.0f)) * float(kAlbedoColumns - 1);
    const VU column = ToUnsigned(at);
    const VF share = at - ToFloat(column);
    const VU low = table_row * SetU(kAlbedoColumns + 1) + column;
    const VU high = low + SetU(kAlbedoColumns + 1);
    const auto across = [&](VU from) HWY_ATTR {
      const VF left = Gather(table, from);
      const VF right = Gather(table, from + SetU(1));
      return left + share * (right - left);
    };
    const VF above = across(low), below = across(high);
    return above + row_share * (below - above);
  }
  // Looks up a padded table of means.
  HWY_INLINE VF Mean(const float* table) const {
    const VF above = Gather(table, table_row), below = Gather(table, table_row + SetU(1));
    return above + row_share * (below - above);
  }

  // Returns Smith's Lambda of GGX (Heitz 2014, eq. 72).
  HWY_INLINE VF Lambda(const V3& w) const {
    const VF z2 = hn::Max(w.z * w.z, Set(1e-12f));
    const VF tan2 = (1.0f - hn::Min(z2, Set(1.0f))) / z2;
    const VF root = hn::Sqrt(1.0f + alpha * alpha * tan2);
    return 0.5f * (root - 1.0f);
  }

  // Returns D(h) of GGX of squared width a2. The sine is taken from x and y, because 1 - z^2 has no
  // digits left for narrow lobes.
  static HWY_INLINE VF Distribution(const V3& h, VF a2) {
    const VF s2 = h.x * h.x + h.y * h.y;
    const VF d = a2 * (h.z * h.z) + s2;
    return a2 / (kPi * hn::Max(d * d, Set(1e-30f)));
  }

  static HWY_INLINE V3 HalfVector(const V3& wo, const V3& wi) {
    const V3 sum = wo + wi;
    return sum * (1.0f / hn::Sqrt(hn::Max(Dot(sum, sum), Set(1e-20f))));
  }

  // Returns the blurred lobe with Fresnel reflectance 1: the half vector turns half as far as wi,
  // so light spread over an angle widens D by half of it. Masking is that of V-cavities (Cook and
  // Torrance 1982).
  HWY_INLINE VF Blurred(const V3& wo, const V3& wi, VF radius) const {
    const V3 h = HalfVector(wo, wi);
    const VF half = 0.5f * radius;
    const VF d = Distribution(h, alpha * alpha + half * half);
    const VF lower = hn::Min(wo.z, wi.z);
    const VF g = 2.0f * h.z * (lower / hn::Max(Dot(wo, h), Set(1e-6f)));
    const VF quarter_over_cos = 0.25f / hn::Max(wo.z, Set(1e-6f));
    return hn::Min(g, Set(1.0f)) * (d * quarter_over_cos);
  }

  HWY_INLINE V3 VisibleNormal(const V3& wo, VF u, VF v) const {
    return VisibleGgxNormal(wo, alpha, alpha, u, v);
  }
  HWY_INLINE V3 Reflect(const V3& wo, VF u, VF v) const {
    const V3 h = VisibleNormal(wo, u, v);
    return h * (2.0f * Dot(wo, h)) - wo;
  }

  VF alpha, row_share;
  VU table_row;
};

// Returns the widths of Varying::kAlpha. Rows beyond the end hold anything, hence the clamp.
HWY_INLINE Ggx VariedGgx(const SurfaceColumns& s, std::uint32_t i) {
  return Ggx(Clamp(Load(s.varying_0 + i), 1e-3f, 1.0f));
}

// Gives metals of their colour (PackConductorIndex) their index; their colour is 1 then. As in
// pbrt-v4, eta is 1 and k follows from the reflectance.
HWY_INLINE void MetalOfColor(V3& color, V3& eta, V3& k) {
  const VF one = Set(1.0f), two = Set(2.0f);
  const MF lanes = hn::Lt(eta.x, hn::Zero(F()));
  const auto index = [&](VF reflectance) HWY_ATTR {
    const VF r = Clamp(reflectance, 0.0f, 0.9999f);
    return two * hn::Sqrt(r / (one - r));
  };
  k = IfThen(lanes, {index(color.x), index(color.y), index(color.z)}, k);
  eta = IfThen(lanes, {one, one, one}, eta);
  color = IfThen(lanes, {one, one, one}, color);
}

// Returns `factor` times the series of further reflections between facets, of which each reflects
// `f` on average and sends the share `lost` to another one (ConductorMultiscatter).
HWY_INLINE V3 ReflectedAgain(const V3& f, VF lost, VF factor) {
  const VF one = Set(1.0f);
  const auto further = [&](VF c) HWY_ATTR { return factor * (c * c / (one - c * lost)); };
  return {further(f.x), further(f.y), further(f.z)};
}

// Returns the factor of ConductorMultiscatter (conductor_tables.h) for facets whose single
// scattering has the albedo `mean`. The mean Fresnel reflectance is summed at four points of Gauss
// and Legendre, for cosines from 0 to 1.
HWY_INLINE V3 Multiscatter(VF mean, const V3& eta, const V3& k) {
  constexpr float kAt[] = {0.06943184f, 0.33000948f, 0.66999052f, 0.93056816f};
  constexpr float kWeight[] = {0.17392742f, 0.32607258f, 0.32607258f, 0.17392742f};
  V3 f = {hn::Zero(F()), hn::Zero(F()), hn::Zero(F())};
  for (int i = 0; i < 4; ++i) {
    f = f + FresnelConductor(Set(kAt[i]), eta, k) * (2 * kAt[i] * kWeight[i]);
  }
  const VF one = Set(1.0f);
  const VF lost = hn::Max(one - mean, Set(1e-6f));
  return ReflectedAgain(f, lost, mean * kInvPi / lost);
}

// Returns the lanes whose material returns what its facets reflect more than once: the first factor
// of its kMultiscatter is not 0 (PackMultiscatter).
HWY_INLINE MF Compensates(const V3& multiscatter) { return hn::Gt(multiscatter.x, hn::Zero(F())); }

}  // namespace HWY_NAMESPACE
}  // namespace skywave
HWY_AFTER_NAMESPACE();

#endif  // per-target include guard
