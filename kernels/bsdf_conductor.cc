// Rough conductor: GGX microfacets (Walter et al. 2007), height-correlated Smith masking, visible
// normals (Heitz 2018, as spherical caps after Dupuy and Benyoub 2023), Fresnel of a complex index,
// and the reciprocal multiple-scattering lobe of Kulla and Conty 2017, so that F = 1 loses nothing.
// The lobe is chosen with the probability with which light scatters more than once.
#include "kernels/bsdf.h"
#include "kernels/conductor_tables.h"

#undef HWY_TARGET_INCLUDE
#define HWY_TARGET_INCLUDE "kernels/bsdf_conductor.cc"
#include "hwy/foreach_target.h"
#include "hwy/highway.h"
#include "kernels/bsdf-inl.h"

HWY_BEFORE_NAMESPACE();
namespace skywave {
namespace HWY_NAMESPACE {

struct Conductor {
  HWY_INLINE Conductor(const SurfaceColumns& s, const MaterialView& m, std::uint32_t i,
                       std::uint32_t n)
      : color(ColorOf(s, i)), tables(*m.conductor) {
    const VU fields = MaterialFields(s, i, n);
    alpha = Field(m, fields, 3);
    eta = Field3(m, fields, 4);
    k = Field3(m, fields, 8);
    multiscatter = Field3(m, fields, 12);
    const VF row = hn::Mul(hn::Sqrt(alpha), Set(float(kAlbedoRows - 1)));
    table_row = hn::Min(ToUnsigned(row), SetU(kAlbedoRows - 1));
    row_share = hn::Sub(row, ToFloat(table_row));
  }

  // E(cosine) of the table, bilinear in the square roots.
  HWY_INLINE VF Albedo(VF cosine) const {
    const VF at = hn::Mul(hn::Sqrt(Clamp(cosine, 0.0f, 1.0f)), Set(float(kAlbedoColumns - 1)));
    const VU column = ToUnsigned(at);
    const VF share = hn::Sub(at, ToFloat(column));
    const VU low = hn::Add(hn::Mul(table_row, SetU(kAlbedoColumns + 1)), column);
    const VU high = hn::Add(low, SetU(kAlbedoColumns + 1));
    const auto across = [&](VU from) HWY_ATTR {
      const VF left = Gather(tables.albedo, from);
      const VF right = Gather(tables.albedo, hn::Add(from, SetU(1)));
      return hn::Add(left, hn::Mul(share, hn::Sub(right, left)));
    };
    const VF above = across(low), below = across(high);
    return hn::Add(above, hn::Mul(row_share, hn::Sub(below, above)));
  }

  // Smith's Lambda of GGX (Heitz 2014, eq. 72).
  HWY_INLINE VF Lambda(const V3& w) const {
    const VF z2 = hn::Max(hn::Mul(w.z, w.z), Set(1e-12f));
    const VF tan2 = hn::Div(hn::Sub(Set(1.0f), hn::Min(z2, Set(1.0f))), z2);
    const VF root = hn::Sqrt(hn::Add(Set(1.0f), hn::Mul(hn::Mul(alpha, alpha), tan2)));
    return hn::Mul(Set(0.5f), hn::Sub(root, Set(1.0f)));
  }

  // D(h) of GGX of squared width a2. The sine is taken from x and y: 1 - z^2 has no digits left for
  // narrow lobes.
  static HWY_INLINE VF Distribution(const V3& h, VF a2) {
    const VF s2 = hn::Add(hn::Mul(h.x, h.x), hn::Mul(h.y, h.y));
    const VF d = hn::Add(hn::Mul(a2, hn::Mul(h.z, h.z)), s2);
    return hn::Div(a2, hn::Mul(Set(kPi), hn::Max(hn::Mul(d, d), Set(1e-30f))));
  }

  static HWY_INLINE V3 HalfVector(const V3& wo, const V3& wi) {
    const V3 sum = Add(wo, wi);
    return Scale(sum, hn::Div(Set(1.0f), hn::Sqrt(hn::Max(Dot(sum, sum), Set(1e-20f)))));
  }

  // The half vector turns half as far as wi, so light spread over an angle widens D by half of it.
  // Masking by V-cavities (Cook and Torrance 1982); Fresnel's reflectance is nearly the same for
  // all wi that matter.
  HWY_INLINE VF Blurred(const V3& wo, const V3& wi, VF radius) const {
    const V3 h = HalfVector(wo, wi);
    const VF half = hn::Mul(Set(0.5f), radius);
    const VF d = Distribution(h, hn::Add(hn::Mul(alpha, alpha), hn::Mul(half, half)));
    const VF lower = hn::Min(wo.z, wi.z);
    const VF g = hn::Mul(hn::Mul(Set(2.0f), h.z), hn::Div(lower, hn::Max(Dot(wo, h), Set(1e-6f))));
    const VF quarter_over_cos = hn::Div(Set(0.25f), hn::Max(wo.z, Set(1e-6f)));
    return hn::Mul(hn::Mul(Luminance(color), hn::Min(g, Set(1.0f))), hn::Mul(d, quarter_over_cos));
  }

  HWY_INLINE BsdfValue Evaluate(const V3& wo, const V3& wi) const {
    const V3 h = HalfVector(wo, wi);
    const VF d = Distribution(h, hn::Mul(alpha, alpha));
    const VF lambda_o = Lambda(wo), lambda_i = Lambda(wi);
    const VF one = Set(1.0f);
    const VF quarter_over_cos = hn::Div(Set(0.25f), hn::Max(wo.z, Set(1e-6f)));
    const VF g2 = hn::Div(one, hn::Add(hn::Add(one, lambda_o), lambda_i));
    const VF g1 = hn::Div(one, hn::Add(one, lambda_o));
    const V3 fresnel = FresnelConductor(hn::Min(hn::Abs(Dot(wo, h)), one), eta, k);
    const VF single = hn::Mul(hn::Mul(d, g2), quarter_over_cos);
    const VF lost_o = hn::Sub(one, Albedo(wo.z)), lost_i = hn::Sub(one, Albedo(wi.z));
    const VF multiple = hn::Mul(hn::Mul(lost_o, lost_i), wi.z);
    const V3 value = Mul(color, Add(Scale(fresnel, single), Scale(multiscatter, multiple)));
    const VF visible = hn::Mul(hn::Mul(d, g1), quarter_over_cos);
    const VF diffuse = hn::Mul(wi.z, Set(kInvPi));
    return {value, hn::Add(visible, hn::Mul(lost_o, hn::Sub(diffuse, visible)))};
  }

  HWY_INLINE BsdfSample Draw(const V3& wo, VF u, VF v, VF lobe) const {
    const V3 stretched = Normalize({hn::Mul(wo.x, alpha), hn::Mul(wo.y, alpha), wo.z});
    const VF one = Set(1.0f);
    const VF cap = hn::Sub(one, hn::Mul(v, hn::Add(one, stretched.z)));
    const VF radius = SafeSqrt(hn::Sub(one, hn::Mul(cap, cap)));
    VF s, c;
    SinCosTurn(u, s, c);
    const V3 normal = {hn::Mul(hn::Add(hn::Mul(radius, c), stretched.x), alpha),
                       hn::Mul(hn::Add(hn::Mul(radius, s), stretched.y), alpha),
                       hn::Max(hn::Add(cap, stretched.z), Set(1e-7f))};
    const V3 h = Normalize(normal);
    const V3 reflected = Sub(Scale(h, hn::Mul(Set(2.0f), Dot(wo, h))), wo);
    const MF multiple = hn::Lt(lobe, hn::Sub(one, Albedo(wo.z)));
    const V3 wi = IfThen(multiple, CosineHemisphere(u, v), reflected);
    const BsdfValue value = Evaluate(wo, wi);
    return {wi, Scale(value.value, hn::Div(one, hn::Max(value.pdf, Set(1e-30f)))), value.pdf};
  }

  V3 color;
  const ConductorTables& tables;
  VF alpha, row_share;
  V3 eta, k, multiscatter;
  VU table_row;
};

SKYWAVE_BSDF_KERNELS(Conductor)

}  // namespace HWY_NAMESPACE
}  // namespace skywave
HWY_AFTER_NAMESPACE();

#if HWY_ONCE
namespace skywave {

inline constexpr bool ConductorIsLobed = true;
SKYWAVE_BSDF_TABLE(Conductor, "conductor")

}  // namespace skywave
#endif  // HWY_ONCE
