// Metallic-roughness is the material of glTF 2.0 (appendix B): a mix of metal and of a diffuse body
// under a dielectric coat, both of the same roughness. Schlick's Fresnel is linear in F0, so both
// have one specular lobe, of F0 = mix(((ior - 1) / (ior + 1))^2, color, metallic).
//
// glTF's own diffuse term, (1 - F(wo . h)) color / pi, reflects more light than it gets at grazing
// wo. Here the body gets the light that the coat lets through, in the reciprocal form of Kelemen
// and Szirmay-Kalos 2001: (1 - S(wo)) (1 - S(wi)) / (pi (1 - mean S)), where S is the albedo of the
// coat; and the lobe of Kulla and Conty 2017 returns the light that the facets of the metal lose.
// So a white body and a white metal are white furnaces, and so is every mix of them.
//
// The specular lobe is drawn by visible normals, with the probability of its share of the albedo,
// and everything else by the cosine.
#if defined(SKYWAVE_KERNELS_METALLIC_ROUGHNESS_INL_H_) == defined(HWY_TARGET_TOGGLE)
#ifdef SKYWAVE_KERNELS_METALLIC_ROUGHNESS_INL_H_
#undef SKYWAVE_KERNELS_METALLIC_ROUGHNESS_INL_H_
#else
#define SKYWAVE_KERNELS_METALLIC_ROUGHNESS_INL_H_
#endif

#include "kernels/bsdf/ggx-inl.h"

HWY_BEFORE_NAMESPACE();
namespace skywave {
namespace HWY_NAMESPACE {

struct MetallicRoughness {
  HWY_INLINE MetallicRoughness(const SurfaceColumns& s, const MaterialView& m, std::uint32_t i,
                               std::uint32_t n)
      // Rows beyond the end hold anything, hence the clamps.
      : ggx(Clamp(Load(s.varying_0 + i), 1e-3f, 1.0f)),
        color(ColorOf(s, i)),
        tables(*m.conductor),
        metallic(Clamp(Load(s.varying_1 + i), 0.0f, 1.0f)) {
    const VF one = Set(1.0f);
    const VF ior = Field(m, MaterialFields(s, i, n), kIor);
    const VF amplitude = (ior - one) / (ior + one);
    coat = amplitude * amplitude;
    const VF body = one - metallic;
    f0 = color * metallic + Splat(coat * body);

    const VF mean = ggx.Mean(tables.padded_mean_albedo), grazing = ggx.Mean(tables.mean_grazing);
    const VF through = one - Mix(grazing, mean, coat);
    diffuse = color * (body * kInvPi / hn::Max(through, Set(1e-6f)));

    // The mean of Schlick's formula is F0 + (1 - F0) / 21.
    const VF lost = hn::Max(one - mean, Set(1e-6f));
    const V3 f = color * (20.0f / 21) + Splat(Set(1.0f / 21));
    multiscatter = ReflectedAgain(f, lost, metallic * mean * kInvPi / lost);
  }

  // Albedos and Fresnel's factors are linear in F0, hence between their values for 0 and 1.
  // Quantities of one of both directions.
  struct Side {
    VF lost;     // share lost by single scattering between facets that reflect everything
    VF through;  // share that the coat lets through: 1 - S
    VF grazing;  // albedo for F0 = 0
  };
  HWY_INLINE Side SideOf(VF cosine) const {
    const VF one = Set(1.0f);
    const VF all = ggx.Table(tables.albedo, cosine);
    const VF grazing = ggx.Table(tables.grazing, cosine);
    return {one - all, one - Mix(grazing, all, coat), grazing};
  }

  // Returns the probability of the specular lobe.
  HWY_INLINE VF SpecularShare(const Side& o) const {
    const VF one = Set(1.0f);
    const VF specular = Mix(o.grazing, one - o.lost, Luminance(f0));
    const VF body = o.through * ((one - metallic) * Luminance(color));
    const VF rest = body + o.lost * metallic * Luminance(color);
    const VF sum = hn::Max(specular + rest, Set(1e-6f));
    // Each lobe gets at least a tenth, as the shares are of means only.
    return Clamp(specular / sum, 0.1f, 0.9f);
  }

  HWY_INLINE VF Blurred(const V3& wo, const V3& wi, VF radius) const {
    const VF spread = Luminance(diffuse) * SideOf(wo.z).through * wi.z;
    const VF c = Clamp(Dot(wo, Ggx::HalfVector(wo, wi)), 0.0f, 1.0f);
    return spread + Luminance(Fresnel(c)) * ggx.Blurred(wo, wi, radius);
  }

  HWY_INLINE V3 Fresnel(VF cosine) const {
    const VF one = Set(1.0f), away5 = Power5(one - cosine);
    return {Mix(away5, one, f0.x), Mix(away5, one, f0.y), Mix(away5, one, f0.z)};
  }

  HWY_INLINE BsdfValue Evaluate(const V3& wo, const V3& wi) const {
    return Evaluate(wo, wi, SideOf(wo.z));
  }
  HWY_INLINE BsdfValue Evaluate(const V3& wo, const V3& wi, const Side& o) const {
    const VF one = Set(1.0f);
    const V3 h = Ggx::HalfVector(wo, wi);
    const VF d = Ggx::Distribution(h, ggx.alpha * ggx.alpha);
    const VF lambda_o = ggx.Lambda(wo), lambda_i = ggx.Lambda(wi);
    const VF quarter_over_cos = 0.25f / hn::Max(wo.z, Set(1e-6f));
    const VF over_4_cos = d * quarter_over_cos;
    const VF single = over_4_cos / (one + lambda_o + lambda_i);
    const V3 fresnel = Fresnel(Clamp(Dot(wo, h), 0.0f, 1.0f));
    const Side in = SideOf(wi.z);
    const VF body = o.through * in.through * wi.z;
    const VF multiple = o.lost * in.lost * wi.z;
    const V3 value = fresnel * single + (diffuse * body + multiscatter * multiple);
    const VF visible = over_4_cos / (one + lambda_o);
    const VF cosine = wi.z * kInvPi;
    return {value, cosine + SpecularShare(o) * (visible - cosine)};
  }

  HWY_INLINE V3 Direction(const V3& wo, VF u, VF v, VF lobe) const {
    return Direction(wo, u, v, lobe, SideOf(wo.z));
  }
  HWY_INLINE V3 Direction(const V3& wo, VF u, VF v, VF lobe, const Side& o) const {
    const MF specular = hn::Lt(lobe, SpecularShare(o));
    return IfThen(specular, ggx.Reflect(wo, u, v), CosineHemisphere(u, v));
  }
  HWY_INLINE BsdfSample Draw(const V3& wo, VF u, VF v, VF lobe) const {
    const Side o = SideOf(wo.z);
    const V3 wi = Direction(wo, u, v, lobe, o);
    return SampleOf(wi, Evaluate(wo, wi, o));
  }
  // The mean over wi of what the coat lets through cancels the factor of `diffuse`.
  HWY_INLINE V3 Diffuse(const V3& wo) const {
    const VF body = (1.0f - metallic) * SideOf(wo.z).through;
    return color * (body * kInvPi);
  }

  Ggx ggx;
  V3 color;
  const ConductorTables& tables;
  VF metallic, coat;
  V3 f0, diffuse, multiscatter;
};

}  // namespace HWY_NAMESPACE
}  // namespace skywave
HWY_AFTER_NAMESPACE();

#endif  // per-target include guard
