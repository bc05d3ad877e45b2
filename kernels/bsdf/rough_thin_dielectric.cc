// The rough thin dielectric is a frosted pane: one interface of GGX microfacets (Walter et al.
// 2007) that reflect by the dielectric's Fresnel reflectance, or by that of its layers
// (GlassLayers), and let the rest through as if it had been reflected and then mirrored to the
// other side, which is how glTF's KHR_materials_transmission describes surfaces without a volume.
// Facets are drawn by visible normals (Heitz 2018), then reflection with the probability of its
// reflectance.
//
// As reflection and transmission have mirrored lobes, both together lose what white facets lose, so
// lobes of Kulla and Conty 2017 return it: (1 - E(wo)) (1 - E(wi)) / (pi (1 - mean E)), split
// between the sides as the smooth interface splits diffuse light. White panes lose nothing.
//
// It may lie under a clear coat (Coated), whose normals may not be its own (Tilted).
#include "kernels/bsdf/bsdf.h"
#include "kernels/bsdf/dielectric_tables.h"
#include "kernels/bsdf/material.h"
#include "kernels/bsdf/pack.h"

#undef HWY_TARGET_INCLUDE
#define HWY_TARGET_INCLUDE "kernels/bsdf/rough_thin_dielectric.cc"
#include "hwy/foreach_target.h"
#include "hwy/highway.h"
#include "kernels/bsdf/bsdf_kernels-inl.h"
#include "kernels/bsdf/ggx-inl.h"
#include "kernels/bsdf/glass_layers-inl.h"
#include "kernels/bsdf/tilted-inl.h"

HWY_BEFORE_NAMESPACE();
namespace skywave {
namespace HWY_NAMESPACE {

struct RoughThinDielectric {
  static constexpr bool kTransmits = true;
  // The transmittance for diffuse light; 0 where light that scatters between facets is lost.
  static constexpr MaterialField kDiffuseThrough = kDielectricTransmittance;

  HWY_INLINE RoughThinDielectric(const SurfaceColumns& s, const MaterialView& m, std::uint32_t i,
                                 std::uint32_t n)
      : fields(MaterialFields(s, i, n)),
        color(ColorOf(s, i)),
        reflection(GlassReflection(m, fields).Or(color)),
        ggx(m.varied ? VariedGgx(s, i) : Ggx(Field(m, fields, kAlpha))),
        tables(*m.conductor),
        ratio(1.0f / Field(m, fields, kIor)),
        through(Field(m, fields, kDiffuseThrough)),
        layers(s, m, fields, i, n) {}

  // Returns what a facet reflects of light that meets it at that cosine.
  HWY_INLINE GlassLayers::Reflection Reflect(VF cosine) const {
    const VF plain = FresnelDielectric(Clamp(cosine, 0.0f, 1.0f), ratio).reflectance;
    if (!layers.any) return {plain, Splat(Set(1.0f))};
    return layers.Over(plain, cosine);
  }
  // Returns the share of light from w that facets scatter more than once.
  HWY_INLINE VF Lost(const V3& w) const {
    const VF lost = 1.0f - ggx.Table(tables.albedo, hn::Abs(w.z));
    return hn::IfThenElseZero(hn::Gt(through, hn::Zero(F())), lost);
  }

  HWY_INLINE BsdfValue Evaluate(const V3& wo, const V3& wi) const {
    return Evaluate(wo, wi, Lost(wo));
  }
  HWY_INLINE BsdfValue Evaluate(const V3& wo, const V3& wi, VF lost_o) const {
    const VF one = Set(1.0f);
    const MF above = hn::Gt(wi.z, hn::Zero(F()));
    const V3 mirrored = {wi.x, wi.y, hn::Abs(wi.z)};
    const V3 h = Ggx::HalfVector(wo, mirrored);
    const GlassLayers::Reflection facet = Reflect(Dot(wo, h));
    const VF d = Ggx::Distribution(h, ggx.alpha * ggx.alpha);
    const VF lambda_o = ggx.Lambda(wo), lambda_i = ggx.Lambda(mirrored);
    const VF quarter_over_cos = 0.25f / hn::Max(wo.z, Set(1e-6f));
    const VF share = IfThen(above, facet.chance, one - facet.chance);
    const VF lobe = share * (d * quarter_over_cos);
    const VF visible = lobe / (one + lambda_o);

    const VF diffuse = IfThen(above, one - through, through) * (mirrored.z * kInvPi);
    const VF mean_lost = hn::Max(one - ggx.Mean(tables.padded_mean_albedo), Set(1e-6f));
    const VF again = diffuse * (lost_o * Lost(wi) / mean_lost);
    const VF single = lobe / (one + lambda_o + lambda_i);
    const VF pdf = visible + lost_o * (diffuse - visible);
    const V3 tint = IfThen(above, reflection, color);
    if (!layers.any) return {tint * (single + again), pdf};
    return {tint * (IfThen(above, facet.tint, Splat(one)) * single + Splat(again)), pdf};
  }

  HWY_INLINE BsdfSample Draw(const V3& wo, VF u, VF v, VF lobe) const {
    const VF one = Set(1.0f), zero = hn::Zero(F());
    const VF lost = Lost(wo);
    const MF again = hn::Lt(lobe, lost);
    const VF rest = Clamp((lobe - lost) / hn::Max(one - lost, Set(1e-6f)), 0.0f, 0x1.fffffep-1f);
    const V3 h = ggx.VisibleNormal(wo, u, v);
    const VF cosine = Dot(wo, h);
    const V3 up = IfThen(again, CosineHemisphere(u, v), h * (2.0f * cosine) - wo);
    const MF passes = hn::Or(hn::And(again, hn::Lt(lobe, lost * through)),
                             hn::AndNot(again, hn::Ge(rest, Reflect(cosine).chance)));
    const V3 wi = {up.x, up.y, IfThen(passes, -up.z, up.z)};
    BsdfSample sample = SampleOf(wi, Evaluate(wo, wi, lost));
    // A reflection into the surface meets the facets again: the lobes return it.
    sample.pdf = hn::IfThenElseZero(hn::Gt(up.z, zero), sample.pdf);
    return sample;
  }

  VU fields;
  V3 color, reflection;  // of what passes, and of what is reflected
  Ggx ggx;
  const ConductorTables& tables;
  VF ratio;    // index outside over index inside
  VF through;  // of the light that facets scatter more than once: it passes
  GlassLayers layers;
};

using CoatedRoughThinDielectric = Coated<Tilted<RoughThinDielectric>, GlassCoat>;

SKYWAVE_BSDF_KERNELS(RoughThinDielectric)
SKYWAVE_BSDF_KERNELS(CoatedRoughThinDielectric)

}  // namespace HWY_NAMESPACE
}  // namespace skywave
HWY_AFTER_NAMESPACE();

#if HWY_ONCE
namespace skywave {

inline constexpr BsdfTraits RoughThinDielectricTraits =
    WithGlassLayers({.name = "rough-thin-dielectric",
                     .lobed = true,
                     .varying = Varying::kAlpha,
                     .transmits = true,
                     .tables = {.ggx = true},
                     .parameters = {{"alpha"}, {"ior"}, {"reflection"}},
                     .pack = [](const Material& m, MeasuredBrdfs, MaterialRecord& r) {
                       PackAlpha(m, r);
                       PutField(r, MaterialField::kIor, m.ior);
                       PackReflection(m, r);
                       PackGlassLayers(m, r);
                       if (m.energy_compensation) {
                         PutField(r, HWY_NAMESPACE::RoughThinDielectric::kDiffuseThrough,
                                  DiffuseTransmittance(m.ior));
                       }
                     }});
inline constexpr BsdfTraits CoatedRoughThinDielectricTraits =
    UnderCoat(RoughThinDielectricTraits, "coated-rough-thin-dielectric",
              [](const Material& m, MeasuredBrdfs measured, MaterialRecord& r) {
                RoughThinDielectricTraits.pack(m, measured, r);
                PackGlassCoat(m, r);
              });
SKYWAVE_BSDF_TABLE(RoughThinDielectric)
SKYWAVE_BSDF_TABLE(CoatedRoughThinDielectric)

}  // namespace skywave
#endif  // HWY_ONCE
