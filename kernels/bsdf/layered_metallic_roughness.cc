// The material of glTF with all of its layers, each of which may have textures: metallic-roughness
// (metallic_roughness-inl.h) whose dielectric reflects a colour of its own
// (KHR_materials_specular), whose facets have two widths (KHR_materials_anisotropy) and lie under a
// thin film (KHR_materials_iridescence), under sheen, under a clear coat (KHR_materials_sheen,
// clearcoat), whose normals may not be those of what lies below it.
//
// Where it is metallic-roughness, without the new layers, it has its value.
#include <cmath>

#include "kernels/bsdf/bsdf.h"
#include "kernels/bsdf/pack.h"

#undef HWY_TARGET_INCLUDE
#define HWY_TARGET_INCLUDE "kernels/bsdf/layered_metallic_roughness.cc"
#include "hwy/foreach_target.h"
#include "hwy/highway.h"
#include "kernels/bsdf/bsdf_kernels-inl.h"
#include "kernels/bsdf/gltf_layers-inl.h"
#include "kernels/bsdf/microfacet-inl.h"
#include "kernels/bsdf/thin_film-inl.h"
#include "kernels/bsdf/tilted-inl.h"
#include "kernels/surface/layers-inl.h"

HWY_BEFORE_NAMESPACE();
namespace skywave {
namespace HWY_NAMESPACE {

// Facets of a grain: of width x along it and y across it, as far as they have two widths.
struct GrainedFacets {
  HWY_INLINE GrainedFacets(const SurfaceColumns& s, const MaterialView& m, VU fields, VF alpha,
                           std::uint32_t i, std::uint32_t n) {
    const VF x = Field(m.records, fields, kGrain, 0), y = Field(m.records, fields, kGrain, 1);
    const VF column = Load(s.varying_3 + i);
    const VF strength = hn::Min(hn::Sqrt(x * x + y * y) * Share<2>(column), Set(1.0f));
    grained = hn::And(hn::Gt(strength, hn::Zero(F())), hn::RebindMask(F(), RowsBelow(i, n)));
    any_grained = m.anisotropic != nullptr && !hn::AllFalse(F(), grained);
    facets = {Mix(alpha, Set(1.0f), strength * strength), alpha};
    FacetTurn packed = TurnOfLayers(Load(s.varying_1 + i), column);
    packed.sine = IfThen(SeenFromBehind(s, i), -packed.sine, packed.sine);
    turn = TangentTurn(IfThen(grained, packed.cosine, Set(1.0f)),
                       hn::IfThenElseZero(grained, packed.sine));
  }
  AnisotropicGgx facets;
  TangentTurn turn;
  MF grained;
  bool any_grained;
};

struct LayeredBase {
  HWY_INLINE LayeredBase(const SurfaceColumns& s, const MaterialView& m, std::uint32_t i,
                         std::uint32_t n)
      : fields(MaterialFields(s, i, n)),
        color(ColorOf(s, i)),
        metallic(Clamp(Field(m, fields, kMetallic) * Share<1>(Load(s.varying_0 + i)), 0.0f, 1.0f)),
        grain(s, m, fields, WidthOf(s, m, i), i, n),
        ggx(hn::Sqrt(grain.facets.x * grain.facets.y)),
        tables(*m.conductor),
        film(Field(m, fields, kFilm) * Share<0>(Load(s.varying_3 + i))),
        any_film(!hn::AllFalse(
            F(), hn::And(hn::Gt(film, hn::Zero(F())), hn::RebindMask(F(), RowsBelow(i, n))))) {
    const VF one = Set(1.0f), body = one - metallic;
    const VF ior = Field(m, fields, kIor), amplitude = (ior - one) / (ior + one);
    const VF specular = Field(m, fields, kSpecular) * Share<3>(Load(s.varying_2 + i));
    const V3 tint = Field3(m, fields, kSpecularColor) * ColorOfRoots(Load(s.varying_2 + i));
    const V3 coat = DielectricF0(amplitude * amplitude, tint, specular);
    coat_f0 = MaxComponent(coat), coat_f90 = specular;
    f0 = color * metallic + coat * body;
    f90 = metallic + specular * body;

    if (any_film) {
      layer = ThinFilm(Field(m, fields, kFilmIor), Thickness(s, m, i));
      filmed_coat = FilmedSurface(layer, coat), filmed_metal = FilmedSurface(layer, color);
    }
    if (grain.any_grained) {
      albedo = AnisotropicAlbedo(m.anisotropic, grain.facets.x, grain.facets.y);
    }
    VF mean = ggx.Mean(tables.padded_mean_albedo);
    const VF grazing = ggx.Mean(tables.mean_grazing);
    if (grain.any_grained) mean = IfThen(grain.grained, albedo.Mean(), mean);
    VF mirrored = coat_f0 * (mean - grazing) + coat_f90 * grazing;  // by the coat, on average
    V3 f = color * (20.0f / 21) + Splat(Set(1.0f / 21));            // by the metal, without shadows
    if (any_film) {
      // Gauss's three points for the weight 2 x, cosines of diffuse light.
      constexpr float kAt[] = {0.21234054f, 0.59053314f, 0.91141204f};
      constexpr float kWeight[] = {0.13965396f, 0.45848221f, 0.40186383f};
      VF coat_mean = hn::Zero(F());
      V3 metal_mean = Splat(hn::Zero(F()));
      for (int k = 0; k < 3; ++k) {
        const ThinFilm::Crossing at = layer.At(Set(kAt[k]));
        const VF all = ggx.Table(tables.albedo, Set(kAt[k]));
        coat_mean = coat_mean + MaxComponent(filmed_coat.Reflectance(at)) * all * kWeight[k];
        metal_mean = metal_mean + filmed_metal.Reflectance(at) * kWeight[k];
      }
      mirrored = Mix(mirrored, coat_mean, film);
      f = Mix(f, metal_mean, film);
    }
    diffuse = color * (body * kInvPi / hn::Max(one - mirrored, Set(1e-6f)));

    const VF lost = hn::Max(one - mean, Set(1e-6f));
    multiscatter = ReflectedAgain(f, lost, metallic * mean * kInvPi / lost);
  }

  HWY_INLINE VF WidthOf(const SurfaceColumns& s, const MaterialView& m, std::uint32_t i) const {
    const VF roughness = Share<0>(Load(s.varying_0 + i));
    return Clamp(Field(m, fields, kAlpha) * (roughness * roughness), 1e-3f, 1.0f);
  }
  HWY_INLINE VF Thickness(const SurfaceColumns& s, const MaterialView& m, std::uint32_t i) const {
    return Mix(Field(m, fields, kFilmThin), Field(m, fields, kFilmThick),
               Share<1>(Load(s.varying_3 + i)));
  }

  // Quantities of one of both directions.
  struct Side {
    VF lost;      // share lost by single scattering between facets that reflect everything
    VF through;   // share that the coat and the film let through to the body
    VF specular;  // luminance of what single scattering reflects
  };
  // Directions are in the frame of the tangent from here on, unless they are said to be outside.
  HWY_INLINE Side SideOf(const V3& w) const {
    const VF one = Set(1.0f);
    VF all = ggx.Table(tables.albedo, w.z);
    if (grain.any_grained) all = IfThen(grain.grained, albedo.Of(w), all);
    const VF grazing = hn::Min(ggx.Table(tables.grazing, w.z), all);
    VF mirrored = coat_f0 * (all - grazing) + coat_f90 * grazing;
    VF specular = Luminance(f0) * (all - grazing) + f90 * grazing;
    if (any_film) {
      const ThinFilm::Crossing at = layer.At(Clamp(w.z, 0.0f, 1.0f));
      const V3 coat = filmed_coat.Reflectance(at);
      const V3 both = Mix(coat, filmed_metal.Reflectance(at), metallic);
      mirrored = Mix(mirrored, MaxComponent(coat) * all, film);
      specular = Mix(specular, Luminance(both) * all, film);
    }
    return {one - all, one - mirrored, specular};
  }

  // Returns the probability of the specular lobe.
  HWY_INLINE VF SpecularShare(const Side& o) const {
    const VF body = o.through * ((1.0f - metallic) * Luminance(color));
    const VF rest = body + o.lost * metallic * Luminance(color);
    const VF sum = hn::Max(o.specular + rest, Set(1e-6f));
    // Each lobe gets at least a tenth, as the shares are of means only.
    return Clamp(o.specular / sum, 0.1f, 0.9f);
  }

  HWY_INLINE V3 Fresnel(VF cosine) const {
    const VF away5 = Power5(1.0f - cosine);
    const V3 plain = f0 * (1.0f - away5) + Splat(f90 * away5);
    if (!any_film) return plain;
    const ThinFilm::Crossing at = layer.At(cosine);
    const V3 of_film = Mix(filmed_coat.Reflectance(at), filmed_metal.Reflectance(at), metallic);
    return Mix(plain, of_film, film);
  }

  HWY_INLINE VF Blurred(const V3& wo, const V3& wi, VF radius) const {
    const VF spread = Luminance(diffuse) * SideOf(grain.turn.To(wo)).through * wi.z;
    const VF c = Clamp(Dot(wo, Ggx::HalfVector(wo, wi)), 0.0f, 1.0f);
    return spread + Luminance(Fresnel(c)) * ggx.Blurred(wo, wi, radius);
  }

  HWY_INLINE BsdfValue Evaluate(const V3& outside_wo, const V3& outside_wi) const {
    const V3 wo = grain.turn.To(outside_wo);
    return Evaluate(wo, grain.turn.To(outside_wi), SideOf(wo));
  }
  HWY_INLINE BsdfValue Evaluate(const V3& wo, const V3& wi, const Side& o) const {
    const VF one = Set(1.0f);
    const V3 h = Ggx::HalfVector(wo, wi);
    const AnisotropicGgx& facets = grain.facets;
    const VF over_4_cos = facets.Density(h) * (0.25f / hn::Max(wo.z, Set(1e-6f)));
    const VF lambda_o = facets.Lambda(wo), lambda_i = facets.Lambda(wi);
    const VF single = over_4_cos / (one + lambda_o + lambda_i);
    const V3 fresnel = Fresnel(Clamp(Dot(wo, h), 0.0f, 1.0f));
    const Side in = SideOf(wi);
    const VF body = o.through * in.through * wi.z, multiple = o.lost * in.lost * wi.z;
    const V3 value = fresnel * single + (diffuse * body + multiscatter * multiple);
    const VF visible = over_4_cos / (one + lambda_o), cosine = wi.z * kInvPi;
    return {value, cosine + SpecularShare(o) * (visible - cosine)};
  }

  HWY_INLINE V3 Direction(const V3& outside_wo, VF u, VF v, VF lobe) const {
    const V3 wo = grain.turn.To(outside_wo);
    const V3 h = grain.facets.VisibleNormal(wo, u, v);
    const V3 mirrored = h * (2.0f * Dot(wo, h)) - wo;
    const MF specular = hn::Lt(lobe, SpecularShare(SideOf(wo)));
    return grain.turn.From(IfThen(specular, mirrored, CosineHemisphere(u, v)));
  }
  // The mean over wi of what is let through cancels the factor of `diffuse`.
  HWY_INLINE V3 Diffuse(const V3& outside_wo) const {
    const VF body = (1.0f - metallic) * SideOf(grain.turn.To(outside_wo)).through;
    return color * (body * kInvPi);
  }

  VU fields;
  V3 color;
  VF metallic;
  GrainedFacets grain;
  Ggx ggx;                   // of the mean width of facets of two
  AnisotropicAlbedo albedo;  // only if grain.any_grained
  const ConductorTables& tables;
  VF film;  // share of the surface that has one
  bool any_film;
  ThinFilm layer;  // this and the next ones only if any_film
  FilmedSurface filmed_coat, filmed_metal;
  V3 f0;
  VF f90, coat_f0, coat_f90;  // of facets, and of the coat over the body in its brightest channel
  V3 diffuse, multiscatter;
};

struct TexturedSheen : ClothSheen {
  HWY_INLINE TexturedSheen(const SurfaceColumns& s, const MaterialView& m, std::uint32_t i,
                           std::uint32_t n)
      : ClothSheen(m, MaterialFields(s, i, n), ColorOfRoots(Load(s.varying_1 + i)),
                   Share<3>(Load(s.varying_0 + i))) {}
};

struct TexturedCoat : ClearCoat {
  HWY_INLINE TexturedCoat(const SurfaceColumns& s, const MaterialView& m, std::uint32_t i,
                          std::uint32_t n)
      : ClearCoat(m, MaterialFields(s, i, n), Share<2>(Load(s.varying_0 + i))) {}
};

using LayeredMetallicRoughness = Coated<Tilted<Sheened<LayeredBase, TexturedSheen>>, TexturedCoat>;

SKYWAVE_BSDF_KERNELS(LayeredMetallicRoughness)

}  // namespace HWY_NAMESPACE
}  // namespace skywave
HWY_AFTER_NAMESPACE();

#if HWY_ONCE
namespace skywave {
namespace {

void PackLayers(const Material& m, MeasuredBrdfs, MaterialRecord& r) {
  using enum MaterialField;
  PackCoatAndSheen(m, r);
  r.grain[0] = m.anisotropy * std::cos(m.anisotropy_turn);
  r.grain[1] = m.anisotropy * std::sin(m.anisotropy_turn);
  PackReflectionLayers(m, kFilmThin, kFilmThick, r);
  PutTexture(r, kSheenTexture, m.sheen_texture);
  PutTexture(r, kSheenAlphaTexture, m.sheen_alpha_texture);
  PutTexture(r, kCoatAlphaTexture, m.coat_alpha_texture);
  PutTexture(r, kAnisotropyTexture, m.anisotropy_texture);
}

}  // namespace

inline constexpr BsdfTraits LayeredMetallicRoughnessTraits = {
    .name = "layered-metallic-roughness",
    .lobed = true,
    .varying = Varying::kLayers,
    .tables = {.ggx = true, .sheen = true, .anisotropic = true},
    .parameters = {{"alpha"},
                   {"metallic"},
                   {"ior"},
                   {"coat"},
                   {"coat_alpha"},
                   {"sheen"},
                   {"sheen_alpha"},
                   {"specular"},
                   {"specular_color"},
                   {"anisotropy"},
                   {"anisotropy_turn"},
                   {"film"},
                   {"film_ior"},
                   {"film_thin"},
                   {"film_thick"}},
    .pack = PackLayers};
SKYWAVE_BSDF_TABLE(LayeredMetallicRoughness)

}  // namespace skywave
#endif  // HWY_ONCE
