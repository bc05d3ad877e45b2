// What a material is, as plain data: readers write it, its BSDF packs it into a MaterialRecord, and
// one visitor names its fields for everything else that needs them (SceneHash, `skywave info`).
#pragma once

#include <cstdint>
#include <glm/vec3.hpp>
#include <optional>
#include <string>
#include <string_view>
#include <type_traits>
#include <vector>

#include "kernels/columns.h"

namespace skywave {

// Two materials, one of which a hit has.
struct Mixture {
  std::uint32_t first, second;  // indices of materials before this one
  float share;                  // share of the second one, in [0, 1]
};

// A BRDF as it was measured (scene/materials/merl.h).
struct MeasuredBrdf {
  std::vector<float> rgb;  // kMeasuredFloats [1/sr], in the order that columns.h gives
  // The lobe by which sampling approximates it: GGX width and probability; the rest is drawn by the
  // cosine.
  float alpha = 1, specular_share = 0;
};

// The parts of a material. Fields of a part that a material does not have are unused.
enum class MaterialPart {
  kBsdf,
  kTextures,
  kMixture,
  kMixtureTexture,
  kOpacity,
  kNormalMap,
  kBaseNormals,
  kAbsorption,
  kCoatMedium,
  kMetalOfColor,
  kSingleScattering,
  kSecondColorTexture,
  kReflection,
  kEmission,
  kSidedness,
  kCatcher,
  kHoldout,
  kLinks,
  kLayers,
  kLayerTextures,
  kReflectionLayers,
  kReflectionLayerTextures
};

struct Material {
  std::string name;
  BsdfKind bsdf = BsdfKind::kLambert;
  // The parameters of the BSDF, of which each reads those that its BsdfTraits list.
  // Lambert: albedo; mirror, conductor: factor of Fresnel; metallic-roughness: base colour. Linear
  // RGB.
  glm::vec3 reflectance{0.5f};
  glm::vec3 eta{0.0f};  // conductors: real part of the index per channel; eta = k = 0: F = 1
  glm::vec3 k{0.0f};    // conductors: imaginary part of the index per channel
  // Conductors: if set, eta and k are derived from the reflectance times its texture: those of the
  // metal with eta = 1 that reflects it at normal incidence.
  bool metal_of_color = false;
  // Width of microfacets in [0.001, 1]; Oren-Nayar: roughness in [0, 1]; Phong, Blinn: the exponent
  // is 2 / alpha^2 - 2.
  float alpha = 0.1f;
  // Anisotropic conductors, rough dielectrics, Ward: the width across the tangent; unset: alpha.
  std::optional<float> alpha_across;
  // Dielectric, glossy-diffuse: index inside (where the normal points away) / outside.
  float ior = 1.5f;
  float metallic = 0;  // metallic-roughness: share of metal
  // Diffuse transmission: the transmitted share; Phong, glossy-diffuse, Fresnel-blend: the gloss.
  glm::vec3 second_color{0.0f};
  // Coated conductor (strength 1; `ior` is the coat's), coated metallic-roughness (index 1.5).
  float coat = 1, coat_alpha = 1e-3f;
  // Coated conductor, coated diffuse: the medium of the coat, which is clear at thickness 0.
  // Optical thickness, share of the light that is scattered there and not lost, and its mean cosine
  // (Henyey and Greenstein 1941).
  float coat_thickness = 0;
  glm::vec3 coat_albedo{0.0f};
  float coat_asymmetry = 0;
  glm::vec3 sheen{0.0f};  // coated metallic-roughness: colour and width
  float sheen_alpha = 0.1f;
  // Layered metallic-roughness and glass: what the dielectric reflects at grazing angles, and the
  // factor of what it reflects at normal incidence besides.
  float specular = 1;
  glm::vec3 specular_color{1.0f};
  // Share in [0, 1] by whose square the width along the grain goes from alpha to 1, and the angle
  // from the tangent to the grain, counter-clockwise [rad].
  float anisotropy = 0, anisotropy_turn = 0;
  // Of both: the share of the surface that has a thin film, its index, and its thickness where the
  // texture is 0 and where it is 1 or there is none [nm].
  float film = 0, film_ior = 1.3f, film_thin = 100, film_thick = 400;
  std::uint32_t measured = 0;  // measured: index of its MeasuredBrdf
  // Dielectrics: factor of what they reflect; the reflectance is then that of what they let
  // through. Unset: the reflectance is the factor of both.
  std::optional<glm::vec3> reflection;
  // BSDFs with an inside: the light lost there, by Beer and Lambert [1/length].
  glm::vec3 absorption{0.0f};
  // All conductors but Beckmann's, and rough dielectrics: if false, the light that facets scatter
  // more than once is lost. Glass of two widths with an image of them has no table, and always
  // loses it.
  bool energy_compensation = true;
  // Textures are indices into the scene's textures. These are factors of the reflectance; of the
  // square roots of alpha (green) and of alpha_across, or of coat_alpha of coated conductors (red),
  // and of metallic (blue).
  std::optional<std::uint32_t> color_texture, roughness_texture;
  std::optional<std::uint32_t> second_color_texture;  // a factor of the second colour (not Phong's)
  // Layered metallic-roughness: factors of the sheen and the specular colour (RGB); of the square
  // roots of sheen_alpha and coat_alpha (green), of specular, film and the place between film_thin
  // and film_thick (green); and of anisotropy (blue), whose red and green channel are 1/2 + 1/2 of
  // the cosine and sine of another turn.
  std::optional<std::uint32_t> sheen_texture, sheen_alpha_texture, coat_alpha_texture;
  std::optional<std::uint32_t> specular_texture, specular_color_texture, anisotropy_texture;
  std::optional<std::uint32_t> film_texture, film_thickness_texture;
  // The share of the surface that exists is this number times the texture. With a cutoff the
  // surface exists where that product reaches it, and nowhere else.
  float opacity = 1;
  std::optional<float> opacity_cutoff;
  std::optional<std::uint32_t> opacity_texture;
  // This texture bends the shading normal. The scale is that of the tilt; for heights it is the
  // height of 1 in the world or, for a height in texels, on the image.
  std::optional<std::uint32_t> normal_texture;
  float normal_scale = 1;
  bool height_in_texels = false;
  // Layered metallic-roughness: what lies below the coat has normals of its own, bent by this
  // texture or by none, and normal_texture bends those of the coat.
  bool own_base_normals = false;
  std::optional<std::uint32_t> base_normal_texture;
  float base_normal_scale = 1;
  // Set: a hit has one of two other materials, and only opacity and emission of this one count.
  std::optional<Mixture> mixture;
  std::optional<std::uint32_t> mixture_texture;  // its first channel, in place of the share
  // The radiance of the surface itself, on the side of its normals or on both; the texture is a
  // factor.
  glm::vec3 emission{0.0f};
  bool emits_on_both_sides = false;
  std::optional<std::uint32_t> emission_texture;
  // Camera rays pass through the back, which is the side from which corners are clockwise. All
  // other rays meet both sides.
  bool one_sided = false;
  // The surface stands for one that a photograph shows already: what is seen of it is how objects
  // change it (wavefront/stages/place.h).
  bool catcher = false;
  // Where the camera sees the surface first, the picture is empty.
  bool holdout = false;

  // Bits of links (wavefront/stages/links.h): their lights do not shine on the surface, or are not
  // shadowed by it.
  std::uint32_t unlit = 0, unshadowed = 0;

  // False: rays may pass through.
  bool opaque() const { return opacity >= 1 && !opacity_texture; }

  // False: the dielectric reflects a share or a colour of its own, or has a film.
  bool reflects_plainly() const {
    return specular == 1 && specular_color == glm::vec3(1) && !specular_texture &&
           !specular_color_texture && !(film > 0);
  }

  bool has(MaterialPart part) const {
    switch (part) {
      case MaterialPart::kBsdf:
      case MaterialPart::kTextures:
        return true;
      case MaterialPart::kMixture:
        return mixture.has_value();
      case MaterialPart::kMixtureTexture:
        return mixture && mixture_texture;
      case MaterialPart::kOpacity:
        return !opaque();
      case MaterialPart::kNormalMap:
        return normal_texture.has_value();
      case MaterialPart::kBaseNormals:
        return own_base_normals;
      case MaterialPart::kAbsorption:
        return absorption != glm::vec3(0);
      case MaterialPart::kCoatMedium:
        return coat_thickness > 0;
      case MaterialPart::kMetalOfColor:
        return metal_of_color;
      case MaterialPart::kSingleScattering:
        return !energy_compensation;
      case MaterialPart::kSecondColorTexture:
        return second_color_texture.has_value();
      case MaterialPart::kLayers:
      case MaterialPart::kLayerTextures:
        return bsdf == BsdfKind::kLayeredMetallicRoughness;
      case MaterialPart::kReflectionLayers:
      case MaterialPart::kReflectionLayerTextures:
        return has(MaterialPart::kLayers) || !reflects_plainly();
      case MaterialPart::kReflection:
        return reflection.has_value();
      case MaterialPart::kEmission:
        return emission != glm::vec3(0);
      case MaterialPart::kSidedness:
        return one_sided;
      case MaterialPart::kCatcher:
        return catcher;
      case MaterialPart::kHoldout:
        return holdout;
      case MaterialPart::kLinks:
        return (unlit | unshadowed) != 0;
    }
    return true;
  }

  // Calls f(name, part, field) for every field but the name, which decides nothing. SceneHash takes
  // the fields in this order.
  template <class Self, class F>
  static void ForEachField(Self& self, F f) {
    // A new member does not compile until it is named here; a test counts that all are visited.
    auto& [name, bsdf, reflectance, eta, k, metal_of_color, alpha, alpha_across, ior, metallic,
           second_color, coat, coat_alpha, coat_thickness, coat_albedo, coat_asymmetry, sheen,
           sheen_alpha, specular, specular_color, anisotropy, anisotropy_turn, film, film_ior,
           film_thin, film_thick, measured, reflection, absorption, energy_compensation,
           color_texture, roughness_texture, second_color_texture, sheen_texture,
           sheen_alpha_texture, coat_alpha_texture, specular_texture, specular_color_texture,
           anisotropy_texture, film_texture, film_thickness_texture, opacity, opacity_cutoff,
           opacity_texture, normal_texture, normal_scale, height_in_texels, own_base_normals,
           base_normal_texture, base_normal_scale, mixture, mixture_texture, emission,
           emits_on_both_sides, emission_texture, one_sided, catcher, holdout, unlit, unshadowed] =
        self;
    using enum MaterialPart;
    f("bsdf", kBsdf, bsdf);
    f("reflectance", kBsdf, reflectance);
    f("eta", kBsdf, eta);
    f("k", kBsdf, k);
    f("alpha", kBsdf, alpha);
    f("ior", kBsdf, ior);
    f("metallic", kBsdf, metallic);
    f("color_texture", kTextures, color_texture);
    f("roughness_texture", kTextures, roughness_texture);
    f("alpha_across", kBsdf, alpha_across);
    f("second_color", kBsdf, second_color);
    f("coat", kBsdf, coat);
    f("coat_alpha", kBsdf, coat_alpha);
    f("coat_thickness", kCoatMedium, coat_thickness);
    f("coat_albedo", kCoatMedium, coat_albedo);
    f("coat_asymmetry", kCoatMedium, coat_asymmetry);
    f("sheen", kBsdf, sheen);
    f("sheen_alpha", kBsdf, sheen_alpha);
    f("measured", kBsdf, measured);
    f("mixture", kMixture, mixture);
    f("mixture_texture", kMixtureTexture, mixture_texture);
    f("opacity", kOpacity, opacity);
    f("opacity_cutoff", kOpacity, opacity_cutoff);
    f("opacity_texture", kOpacity, opacity_texture);
    f("normal_texture", kNormalMap, normal_texture);
    f("normal_scale", kNormalMap, normal_scale);
    f("height_in_texels", kNormalMap, height_in_texels);
    f("own_base_normals", kBaseNormals, own_base_normals);
    f("base_normal_texture", kBaseNormals, base_normal_texture);
    f("base_normal_scale", kBaseNormals, base_normal_scale);
    f("absorption", kAbsorption, absorption);
    f("metal_of_color", kMetalOfColor, metal_of_color);
    f("energy_compensation", kSingleScattering, energy_compensation);
    f("second_color_texture", kSecondColorTexture, second_color_texture);
    f("specular", kReflectionLayers, specular);
    f("specular_color", kReflectionLayers, specular_color);
    f("anisotropy", kLayers, anisotropy);
    f("anisotropy_turn", kLayers, anisotropy_turn);
    f("film", kReflectionLayers, film);
    f("film_ior", kReflectionLayers, film_ior);
    f("film_thin", kReflectionLayers, film_thin);
    f("film_thick", kReflectionLayers, film_thick);
    f("sheen_texture", kLayerTextures, sheen_texture);
    f("sheen_alpha_texture", kLayerTextures, sheen_alpha_texture);
    f("coat_alpha_texture", kLayerTextures, coat_alpha_texture);
    f("specular_texture", kReflectionLayerTextures, specular_texture);
    f("specular_color_texture", kReflectionLayerTextures, specular_color_texture);
    f("anisotropy_texture", kLayerTextures, anisotropy_texture);
    f("film_texture", kReflectionLayerTextures, film_texture);
    f("film_thickness_texture", kReflectionLayerTextures, film_thickness_texture);
    f("reflection", kReflection, reflection);
    f("emission", kEmission, emission);
    f("emits_on_both_sides", kEmission, emits_on_both_sides);
    f("emission_texture", kEmission, emission_texture);
    f("one_sided", kSidedness, one_sided);
    f("catcher", kCatcher, catcher);
    f("holdout", kHoldout, holdout);
    f("unlit", kLinks, unlit);
    f("unshadowed", kLinks, unshadowed);
  }
};

// Calls f(index) for every texture that the material names.
template <class F>
void ForEachTexture(const Material& material, F f) {
  Material::ForEachField(material, [&](std::string_view, MaterialPart, const auto& field) {
    if constexpr (std::is_same_v<decltype(field), const std::optional<std::uint32_t>&>) {
      if (field) f(*field);
    }
  });
}

}  // namespace skywave
