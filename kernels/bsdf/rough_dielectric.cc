// The rough dielectric has GGX microfacets, of one or two widths, that reflect and refract (Walter
// et al. 2007), visible normals (Heitz 2018), and masking and shadowing 1 / (1 + Lambda(wo) +
// Lambda(wi)) on both sides; refraction scales radiance by the squared index ratio, as smooth glass
// does. Lobes of both sides return the light that scatters between facets (dielectric_tables.h), so
// that white glass loses nothing. They are drawn with the probability that light scatters more than
// once; otherwise a facet is drawn, then reflection with the probability of its reflectance, which
// is Fresnel's or that of its layers (GlassLayers). The lobes know nothing of layers.
//
// It may lie under a clear coat (Coated), whose normals may not be its own (Tilted).
#include "kernels/bsdf/bsdf.h"
#include "kernels/bsdf/dielectric_tables.h"
#include "kernels/bsdf/material.h"
#include "kernels/bsdf/pack.h"

#undef HWY_TARGET_INCLUDE
#define HWY_TARGET_INCLUDE "kernels/bsdf/rough_dielectric.cc"
#include "hwy/foreach_target.h"
#include "hwy/highway.h"
#include "kernels/bsdf/bsdf_kernels-inl.h"
#include "kernels/bsdf/glass_layers-inl.h"
#include "kernels/bsdf/microfacet-inl.h"
#include "kernels/bsdf/tilted-inl.h"

HWY_BEFORE_NAMESPACE();
namespace skywave {
namespace HWY_NAMESPACE {

// The lobes of the light that scatters more than once, for one vector of surfaces. Lanes whose
// material leaves them out (kDielectricTable is 0) lose nothing.
struct InterfaceLosses {
  HWY_INLINE InterfaceLosses(const MaterialView& m, VU fields, std::uint32_t i, std::uint32_t n)
      : words(reinterpret_cast<const float*>(m.dielectrics)) {
    // Rows beyond the end have another material.
    const VU table = hn::IfThenElseZero(RowsBelow(i, n), IndexField(m, fields, kDielectricTable));
    lanes = hn::RebindMask(F(), hn::Ne(table, hn::Zero(U())));
    any = !hn::AllFalse(F(), lanes);
    first = (table - SetU(1)) * SetU(kDielectricWords);
    if (any) transmittance = Field(m, fields, kDielectricTransmittance);
  }

  // Reads a value of a row, linearly between rows.
  HWY_INLINE VF Between(const TablePlace& at, VU word) const {
    const VU row = first + at.low * SetU(kDielectricRowWords);
    const VU low = hn::IfThenElseZero(hn::RebindMask(U(), lanes), row + word);
    const VF above = Gather(words, low);
    const VF below = Gather(words, low + SetU(kDielectricRowWords));
    return above + at.share * (below - above);
  }
  // Returns the share that light from a direction on that side loses.
  HWY_INLINE VF Lost(const TablePlace& row, VF cosine, MF inside) const {
    const VF at = hn::Sqrt(Clamp(cosine, 0.0f, 1.0f)) * float(kAlbedoColumns - 1);
    const VU column = ToUnsigned(at);
    const VF share = at - ToFloat(column);
    const VU word = column + Side(inside, std::uint32_t(SKYWAVE_WORD(DielectricRow, lost[1])));
    const VF left = Between(row, word), right = Between(row, word + SetU(1));
    return hn::IfThenElseZero(lanes, left + share * (right - left));
  }
  static HWY_INLINE VU Side(MF inside, std::uint32_t word) {
    return hn::IfThenElseZero(hn::RebindMask(U(), inside), SetU(word));
  }

  const float* words;
  VU first;
  MF lanes;
  bool any;
  VF transmittance;  // of diffuse light from outside
};

struct RoughDielectric {
  static constexpr bool kTransmits = true, kRefracts = true;

  HWY_INLINE RoughDielectric(const SurfaceColumns& s, const MaterialView& m, std::uint32_t i,
                             std::uint32_t n)
      : fields(MaterialFields(s, i, n)),
        color(ColorOf(s, i)),
        reflection(GlassReflection(m, fields).Or(color)),
        ggx(Field(m, fields, kAlpha)),
        losses(m, fields, i, n),
        layers(s, m, fields, i, n) {
    if (m.varied || m.two_widths) ggx = VariedGgx(s, i);
    if (m.two_widths) SplitWidths(s, i, n);
    ratio = IndexRatio(s, m, fields, i);
    if (losses.any) MakeLobes(SeenFromBehind(s, i));
  }
  HWY_INLINE void SplitWidths(const SurfaceColumns& s, std::uint32_t i, std::uint32_t n) {
    const FacetTurn turn = FacetTurnOf(s, i);
    two_widths = hn::And(hn::RebindMask(F(), RowsBelow(i, n)), hn::Gt(turn.across, hn::Zero(F())));
    any_two_widths = !hn::AllFalse(F(), two_widths);
    if (!any_two_widths) return;
    facets = {ggx.alpha, Clamp(turn.across, 1e-3f, 1.0f)};
    tangent = {IfThen(two_widths, turn.cosine, Set(1.0f)),
               hn::IfThenElseZero(two_widths, turn.sine)};
  }

  HWY_INLINE V3 ColorTo(MF above) const { return IfThen(above, reflection, color); }
  HWY_INLINE V3 ToTangent(const V3& w) const { return any_two_widths ? tangent.To(w) : w; }
  HWY_INLINE VF Lambda(const V3& w) const {
    const VF round = ggx.Lambda(w);
    return any_two_widths ? IfThen(two_widths, facets.Lambda(w), round) : round;
  }
  HWY_INLINE VF Density(const V3& h) const {
    const VF round = Ggx::Distribution(h, ggx.alpha * ggx.alpha);
    return any_two_widths ? IfThen(two_widths, facets.Density(h), round) : round;
  }
  HWY_INLINE V3 VisibleNormal(const V3& wo, VF u, VF v) const {
    if (!any_two_widths) return ggx.VisibleNormal(wo, u, v);
    return VisibleGgxNormal(wo, IfThen(two_widths, facets.x, ggx.alpha),
                            IfThen(two_widths, facets.y, ggx.alpha), u, v);
  }
  // Returns what light from w loses, in the tangent frame.
  HWY_INLINE VF Lost(const V3& w, MF on_inside) const {
    TablePlace row = {ggx.table_row, ggx.row_share};
    if (any_two_widths) {  // The rows of their tables are azimuths.
      const TablePlace azimuth = PlaceOf(AzimuthShare(w), kAlbedoRows);
      row.low = hn::IfThenElse(hn::RebindMask(U(), two_widths), azimuth.low, row.low);
      row.share = IfThen(two_widths, azimuth.share, row.share);
    }
    return losses.Lost(row, hn::Abs(w.z), on_inside);
  }
  // Splits what facets lose on wo's side between both sides.
  HWY_INLINE void MakeLobes(MF back) {
    inside = back;
    const VF one = Set(1.0f), tiny = Set(1e-6f);
    const auto mean = [&](MF side) HWY_ATTR {
      const VU word =
          SetU(std::uint32_t(SKYWAVE_WORD(DielectricRow, mean))) + InterfaceLosses::Side(side, 1);
      return hn::Max(losses.Between({ggx.table_row, ggx.row_share}, word), tiny);
    };
    const VF own = mean(inside), other = mean(hn::Not(inside));
    const VF larger = hn::Max(own, other);
    // Of diffuse light on wo's side, the smooth interface lets through t, or t / n^2 from inside.
    const VF diffuse = IfThen(inside, losses.transmittance / (ratio * ratio), losses.transmittance);
    through_share = diffuse * other / larger;
    through = kInvPi * diffuse / larger;
    back_again = kInvPi * (one - through_share) / own;
  }
  // Adds the lobes of light that scatters more than once to the value of single scattering.
  HWY_INLINE BsdfValue WithLobes(VF lost_o, const V3& wi, const BsdfValue& single) const {
    const VF zero = hn::Zero(F()), one = Set(1.0f);
    const MF above = hn::Gt(wi.z, zero);
    const VF cosine = hn::Abs(wi.z);
    const VF lost_i = Lost(wi, hn::Xor(inside, hn::Not(above)));
    const VF lobe = IfThen(above, back_again, through * (ratio * ratio));
    const VF multiple = lost_o * lost_i * (lobe * cosine);
    const VF share = IfThen(above, one - through_share, through_share);
    const VF diffuse = share * cosine * kInvPi;
    return {single.value + ColorTo(above) * multiple, single.pdf + lost_o * (diffuse - single.pdf)};
  }

  HWY_INLINE BsdfValue Evaluate(const V3& wo, const V3& wi) const {
    const V3 eye = ToTangent(wo);
    return InTangentFrame(eye, ToTangent(wi), LostFrom(eye));
  }
  // Takes what light from wo loses too, which a draw has looked up already.
  HWY_INLINE BsdfValue InTangentFrame(const V3& wo, const V3& wi, VF lost_o) const {
    const BsdfValue single = Single(wo, wi);
    return losses.any ? WithLobes(lost_o, wi, single) : single;
  }
  HWY_INLINE VF LostFrom(const V3& wo) const {
    return losses.any ? Lost(wo, inside) : hn::Zero(F());
  }
  HWY_INLINE BsdfValue Single(const V3& wo, const V3& wi) const {
    const VF zero = hn::Zero(F()), one = Set(1.0f);
    const MF above = hn::Gt(wi.z, zero);
    // With refraction h is along -(n_o wo + n_i wi), on wo's side whatever the indices are.
    V3 h = wo * IfThen(above, one, ratio) + wi;
    h = h * (one / hn::Sqrt(hn::Max(Dot(h, h), Set(1e-20f))));
    h = h * hn::CopySign(one, h.z);
    const VF cos_o = Dot(wo, h), cos_i = Dot(wi, h);
    const GlassLayers::Reflection facet = Reflect(Clamp(cos_o, 0.0f, 1.0f));

    const VF lambda_o = Lambda(wo), lambda_i = Lambda(wi);
    const VF d = Density(h);
    const VF over_cos = d / hn::Max(wo.z, Set(1e-6f));
    // The Jacobian makes the density of wi from that of h (eqs. 14 and 17), with the |wo . h| of
    // the visible normals.
    const VF root = ratio * cos_o + cos_i;
    const VF root2 = hn::Max(root * root, Set(1e-20f));
    const VF refracts = hn::Abs(cos_i) * hn::Abs(cos_o) / root2;
    const VF jacobian = IfThen(above, Set(0.25f), refracts);
    const VF share = IfThen(above, facet.chance, one - facet.chance);
    const VF lobe = over_cos * jacobian * share;
    // Both directions see a facet from its own side.
    const MF seen = hn::And(hn::Gt(cos_o, zero), hn::Gt(cos_i * wi.z, zero));
    const VF visible = hn::IfThenElseZero(seen, lobe);
    const VF g2 = one / (one + lambda_o + lambda_i);
    const VF scale = IfThen(above, one, ratio * ratio);
    V3 tint = ColorTo(above);
    if (layers.any) tint = IfThen(above, tint * facet.tint, tint);
    return {tint * (visible * g2 * scale), visible / (one + lambda_o)};
  }
  // Returns what a facet reflects of light that meets it at that cosine.
  HWY_INLINE GlassLayers::Reflection Reflect(VF cosine) const {
    return Reflect(FresnelDielectric(cosine, ratio), cosine);
  }
  HWY_INLINE GlassLayers::Reflection Reflect(const Refraction& refraction, VF cosine) const {
    if (!layers.any) return {refraction.reflectance, Splat(Set(1.0f))};
    return layers.Over(refraction.reflectance, layers.Outside(refraction, cosine));
  }

  HWY_INLINE BsdfSample Draw(const V3& eye, VF u, VF v, VF lobe) const {
    const V3 wo = ToTangent(eye);
    const VF zero = hn::Zero(F()), one = Set(1.0f);
    MF again = hn::Lt(one, zero);
    V3 diffuse = {zero, zero, one};
    const VF lost = LostFrom(wo);
    if (losses.any) {
      again = hn::Lt(lobe, lost);
      diffuse = CosineHemisphere(u, v);
      const MF passes = hn::Lt(lobe, lost * through_share);
      diffuse.z = IfThen(passes, -diffuse.z, diffuse.z);
      const VF rest = (lobe - lost) / hn::Max(one - lost, Set(1e-6f));
      lobe = Clamp(rest, 0.0f, 0x1.fffffep-1f);
    }
    const V3 h = VisibleNormal(wo, u, v);
    const VF cosine = Clamp(Dot(wo, h), 0.0f, 1.0f);
    const Refraction refraction = FresnelDielectric(cosine, ratio);
    const V3 reflected = h * (2.0f * cosine) - wo;
    const V3 refracted = Normalize(h * (ratio * cosine - refraction.cosine) - wo * ratio);
    const MF reflects = hn::Lt(lobe, Reflect(refraction, cosine).chance);
    const V3 wi = IfThen(again, diffuse, IfThen(reflects, reflected, refracted));
    BsdfSample sample = SampleOf(wi, InTangentFrame(wo, wi, lost));
    if (any_two_widths) sample.wi = tangent.From(wi);
    // A reflection below the surface, or a refraction above it, meets the facets again: the lobes
    // return it.
    const MF stays = hn::Gt(wi.z, zero);
    const MF alive = hn::Or(again, hn::Not(hn::Xor(stays, reflects)));
    sample.pdf = hn::IfThenElseZero(alive, sample.pdf);
    return sample;
  }

  VU fields;
  V3 color, reflection;  // of what passes, and of what is reflected
  Ggx ggx;
  InterfaceLosses losses;
  GlassLayers layers;
  bool any_two_widths = false;
  // These exist where some lanes have two widths.
  MF two_widths;
  AnisotropicGgx facets;
  TangentTurn tangent;
  VF ratio;  // index on wo's side over index on the other
  // These exist where `losses` are any.
  MF inside;               // wo is there
  VF through_share;        // of the light that is lost on wo's side: it passes
  VF through, back_again;  // factors of lost(wo) lost(wi) cos [1/sr]
};

using CoatedRoughDielectric = Coated<Tilted<RoughDielectric>, GlassCoat>;

SKYWAVE_BSDF_KERNELS(RoughDielectric)
SKYWAVE_BSDF_KERNELS(CoatedRoughDielectric)

}  // namespace HWY_NAMESPACE
}  // namespace skywave
HWY_AFTER_NAMESPACE();

#if HWY_ONCE
namespace skywave {

inline constexpr BsdfTraits RoughDielectricTraits = WithGlassLayers(
    {.name = "rough-dielectric",
     .lobed = true,
     .varying = Varying::kAlpha,
     .transmits = true,
     .refracts = true,
     .two_widths = true,
     .across = MaterialField::kDielectricAcross,
     .inside = true,
     .tables = {.dielectric = true},
     .parameters = {{"alpha"}, {"alpha_across"}, {"ior"}, {"reflection"}},
     .pack = [](const Material& m, MeasuredBrdfs, MaterialRecord& r) {
       PackAlpha(m, r);
       PutField(r, MaterialField::kIor, m.ior);
       PackReflection(m, r);
       PackGlassLayers(m, r);
       if (m.alpha_across) {
         PutField(r, MaterialField::kDielectricAcross, MicrofacetWidth(*m.alpha_across));
       }
       if (!m.energy_compensation) return;
       PutField(r, MaterialField::kDielectricTransmittance, DiffuseTransmittance(m.ior));
     }});
inline constexpr BsdfTraits CoatedRoughDielectricTraits =
    UnderCoat(RoughDielectricTraits, "coated-rough-dielectric",
              [](const Material& m, MeasuredBrdfs measured, MaterialRecord& r) {
                RoughDielectricTraits.pack(m, measured, r);
                PackGlassCoat(m, r);
              });
SKYWAVE_BSDF_TABLE(RoughDielectric)
SKYWAVE_BSDF_TABLE(CoatedRoughDielectric)

}  // namespace skywave
#endif  // HWY_ONCE
