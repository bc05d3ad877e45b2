// What several of pbrt's materials read in the same way: colours with their images, and roughness.
#pragma once

#include <algorithm>
#include <cmath>
#include <initializer_list>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "scene/pbrt/state.h"

namespace skywave {

// The material that is being read.
struct PbrtMaterialContext {
  PbrtParameters& parameters;
  PbrtReader& reader;
  Warnings& warnings = reader.warnings;
};

void Warn(PbrtMaterialContext& context, std::string_view text);

// Returns a colour that is a fraction of light, clamped to [0, 1] with a warning if that changes
// it.
std::optional<glm::vec3> FindFraction(PbrtMaterialContext& context, std::string_view name);
// Returns the first of several alternative names (v4 and v3) that is given.
glm::vec3 FractionOr(PbrtMaterialContext& context, std::initializer_list<std::string_view> names,
                     const glm::vec3& fallback);
// Returns a float, or a texture of one value.
std::optional<float> FindScalar(PbrtMaterialContext& context, std::string_view name);

// Sets the reflectance to the first of `names` (v4 and v3) that is given times `scale`, with its
// image if it has one, or to what varies in space.
void SetReflectance(PbrtMaterialContext& context, std::initializer_list<std::string_view> names,
                    float fallback, Material& material, float scale = 1);
// The same for the parameter of diffuse bodies.
void SetDiffuse(PbrtMaterialContext& context, float fallback, Material& material, float scale = 1);
// Sets the second colour to the parameter `name` times `scale`, with its image if it has one.
void SetSecondColor(PbrtMaterialContext& context, std::string_view name, float fallback,
                    Material& material, float scale = 1);

// Returns the index of refraction of a dielectric, a number or a glass by name; throws InputError
// unless it is positive.
float DielectricIndex(PbrtMaterialContext& context, std::initializer_list<std::string_view> names);

// pbrt uses the same threshold between rough and specular, and the same least width of a rough
// surface, which may be smooth in one direction.
inline constexpr float kSmoothWidth = 1e-3f, kLeastWidth = 1e-4f;

// GGX widths along and across the direction of increasing u. The names in v4's coatedconductor and
// coateddiffuse begin with "conductor." or "interface.".
struct Widths {
  float along, across;
  // A texture of both (Material::roughness_texture); the widths are 1 then.
  std::optional<std::uint32_t> texture = std::nullopt;
  std::optional<PbrtSolidParameter> solid = std::nullopt;  // likewise if they vary in space
  bool texture_of_two = false;                             // it differs along and across
  bool two() const { return along != across || texture_of_two; }
  bool smooth() const { return std::max(along, across) < kSmoothWidth; }
  float mean() const {
    if (smooth()) return std::sqrt(along * across);
    return std::sqrt(std::max(along, kLeastWidth) * std::max(across, kLeastWidth));
  }
};

Widths FindWidths(PbrtMaterialContext& context, const std::string& prefix, float fallback, bool v4);
// Returns the widths of a material whose roughness may vary.
Widths FindVariedWidths(PbrtMaterialContext& context, float fallback, bool v4);
// Returns one width for materials without an anisotropic kernel.
float OneWidth(PbrtMaterialContext& context, const Widths& widths);

// Returns whether the roughness along u or v, which override that of both, varies.
bool RoughnessVaries(PbrtMaterialContext& context, const std::string& prefix);
// The roughness along u and along v, each a number or a texture.
struct Roughness {
  PbrtTexture along, across;
  bool two() const { return !SamePbrtTexture(along, across); }
};
Roughness FindRoughness(PbrtMaterialContext& context, const std::string& prefix, float fallback);

// Returns widths that vary: `pack` makes a texel of Material::roughness_texture of the alphas of
// `roughness`. Where the textures cannot be combined, the widths are those of `fallback`.
Widths VariedWidths(PbrtMaterialContext& context, const std::vector<PbrtTexture>& roughness,
                    float fallback, bool v4, const PackAlphas& pack);
// Returns the square root of the geometric mean of two alphas.
float RootOfMean(float along, float across);
// Gives a coat the widths of its textures; `rounded` says that they differed along u and v.
void SetVariedWidths(PbrtMaterialContext& context, const Widths& widths, bool rounded,
                     Material& material);

}  // namespace skywave
