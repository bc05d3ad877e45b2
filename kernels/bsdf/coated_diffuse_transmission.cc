// A thin sheet under a glossy coat that lets light through diffusely and reflects by its coat
// alone: what glTF's KHR_materials_diffuse_transmission has in the place of the diffuse body.
//
// The coat is GGX of Schlick's Fresnel. Of light from wo, the share 1 - S(wo) that the coat does
// not reflect leaves on the other side, in the reciprocal form of Kelemen and Szirmay-Kalos 2001
// (see metallic_roughness-inl.h): color (1 - S(wo)) (1 - S(wi)) / (pi (1 - mean S)). A white sheet
// is a white furnace. The coat is drawn by visible normals, with the probability of its share of
// the albedo, and the other side by the cosine.
#include "kernels/bsdf/bsdf.h"
#include "kernels/bsdf/pack.h"

#undef HWY_TARGET_INCLUDE
#define HWY_TARGET_INCLUDE "kernels/bsdf/coated_diffuse_transmission.cc"
#include "hwy/foreach_target.h"
#include "hwy/highway.h"
#include "kernels/bsdf/bsdf_kernels-inl.h"
#include "kernels/bsdf/ggx-inl.h"

HWY_BEFORE_NAMESPACE();
namespace skywave {
namespace HWY_NAMESPACE {

struct CoatedDiffuseTransmission {
  static constexpr bool kTransmits = true;

  HWY_INLINE CoatedDiffuseTransmission(const SurfaceColumns& s, const MaterialView& m,
                                       std::uint32_t i, std::uint32_t n)
      : fields(MaterialFields(s, i, n)),
        color(ColorOf(s, i)),
        ggx(m.varied ? VariedGgx(s, i) : Ggx(Field(m, fields, kAlpha))),
        tables(*m.conductor) {
    const VF one = Set(1.0f), ior = Field(m, fields, kIor);
    const VF amplitude = (ior - one) / (ior + one);
    f0 = amplitude * amplitude;
    const VF mean = Mix(ggx.Mean(tables.mean_grazing), ggx.Mean(tables.padded_mean_albedo), f0);
    diffuse = color * (kInvPi / hn::Max(one - mean, Set(1e-6f)));
  }

  // Returns the albedo of the coat.
  HWY_INLINE VF Reflected(VF cosine) const {
    return Mix(ggx.Table(tables.grazing, cosine), ggx.Table(tables.albedo, cosine), f0);
  }
  // Returns the probability of the coat. Each side gets at least a tenth, as colours count by their
  // luminance only.
  HWY_INLINE VF CoatShare(VF reflected) const {
    const VF rest = (1.0f - reflected) * Luminance(color);
    return Clamp(reflected / hn::Max(reflected + rest, Set(1e-6f)), 0.1f, 0.9f);
  }

  HWY_INLINE BsdfValue Evaluate(const V3& wo, const V3& wi) const {
    return Evaluate(wo, wi, Reflected(wo.z));
  }
  HWY_INLINE BsdfValue Evaluate(const V3& wo, const V3& wi, VF reflected) const {
    const VF one = Set(1.0f), share = CoatShare(reflected);
    const V3 h = Ggx::HalfVector(wo, wi);
    const VF lobe =
        Ggx::Distribution(h, ggx.alpha * ggx.alpha) * (0.25f / hn::Max(wo.z, Set(1e-6f)));
    const VF lambda_o = ggx.Lambda(wo), lambda_i = ggx.Lambda(wi);
    const VF fresnel = Mix(Power5(one - Clamp(Dot(wo, h), 0.0f, 1.0f)), one, f0);
    const VF coat = fresnel * (lobe / (one + lambda_o + lambda_i));

    const VF cosine = hn::Abs(wi.z);
    const VF through = (one - reflected) * (one - Reflected(cosine)) * cosine;
    const MF above = hn::Gt(wi.z, hn::Zero(F()));
    return {IfThen(above, Splat(coat), diffuse * through),
            IfThen(above, share * (lobe / (one + lambda_o)), (one - share) * (cosine * kInvPi))};
  }

  HWY_INLINE BsdfSample Draw(const V3& wo, VF u, VF v, VF lobe) const {
    const VF reflected = Reflected(wo.z);
    const MF by_coat = hn::Lt(lobe, CoatShare(reflected));
    const V3 mirrored = ggx.Reflect(wo, u, v);
    const V3 wi = IfThen(by_coat, mirrored, -CosineHemisphere(u, v));
    BsdfSample sample = SampleOf(wi, Evaluate(wo, wi, reflected));
    // The albedo of the coat does not count what its facets reflect into the surface.
    const MF lost = hn::And(by_coat, hn::Le(mirrored.z, hn::Zero(F())));
    sample.pdf = IfThen(lost, hn::Zero(F()), sample.pdf);
    return sample;
  }
  // The mean over wi of what the coat lets through cancels the factor of `diffuse`.
  HWY_INLINE V3 Diffuse(const V3&) const { return Splat(hn::Zero(F())); }
  HWY_INLINE V3 DiffuseThrough(const V3& wo) const {
    return color * ((1.0f - Reflected(wo.z)) * kInvPi);
  }

  VU fields;
  V3 color, diffuse;  // of what passes
  Ggx ggx;
  const ConductorTables& tables;
  VF f0;
};

SKYWAVE_BSDF_KERNELS(CoatedDiffuseTransmission)

}  // namespace HWY_NAMESPACE
}  // namespace skywave
HWY_AFTER_NAMESPACE();

#if HWY_ONCE
namespace skywave {

inline constexpr BsdfTraits CoatedDiffuseTransmissionTraits = {
    .name = "coated-diffuse-transmission",
    .lobed = true,
    .varying = Varying::kAlpha,
    .transmits = true,
    .tables = {.ggx = true},
    .parameters = {{"alpha"}, {"ior"}},
    .pack = [](const Material& m, MeasuredBrdfs, MaterialRecord& r) {
      PackAlpha(m, r);
      PutField(r, MaterialField::kIor, m.ior);
    }};
SKYWAVE_BSDF_TABLE(CoatedDiffuseTransmission)

}  // namespace skywave
#endif  // HWY_ONCE
