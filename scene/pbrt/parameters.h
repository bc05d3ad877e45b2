// Parses the typed parameters that follow most pbrt directives: "type name" value or [ values ].
//
// Look-ups mark their results as used; ReportUnused then names every parameter that was not looked
// up, so that none is skipped silently.
#pragma once

#include <cstdint>
#include <functional>
#include <glm/glm.hpp>
#include <initializer_list>
#include <memory>
#include <optional>
#include <string>
#include <string_view>
#include <unordered_map>
#include <vector>

#include "base/error.h"
#include "scene/materials/spectrum.h"
#include "scene/pbrt/tokens.h"
#include "scene/warnings.h"

namespace skywave {

struct PbrtParameter {
  std::string type, name;
  InputPosition position;
  std::vector<float> floats;         // all types except the following
  std::vector<std::int32_t> ints;    // integer
  std::vector<std::string> strings;  // string, texture, bool ("true", "false"), spectrum by name
  bool used = false;
};

struct PbrtParameters {
  InputPosition position;  // position of the directive
  std::string directive;   // Shape "sphere", for messages
  std::vector<PbrtParameter> list;
  std::optional<RgbConversion> color_space;  // of colours given as rgb; nothing: linear Rec. 709
};

// A point of a shape: its place and unit normal in world space, and the (u, v) of the shape itself.
struct PbrtPoint {
  glm::dvec3 place, normal;
  glm::dvec2 uv;
};
// A colour, or a number in all of its channels, at a point.
using PbrtSolid = std::function<glm::vec3(const PbrtPoint& point)>;

struct PbrtTexture {
  std::optional<glm::vec3> value;      // its constant value, or the factor of the image
  std::optional<std::uint32_t> image;  // index into Scene::textures
  std::shared_ptr<const PbrtSolid> solid = nullptr;
  int evaluations = 0;  // of functions, that of `solid` takes
};
inline bool SamePbrtTexture(const PbrtTexture& a, const PbrtTexture& b) {
  return a.value == b.value && a.image == b.image && a.solid == b.solid;
}
// The most that a texture may take. It also bounds how deeply textures are nested.
inline constexpr int kMaxPbrtEvaluations = 256;
// Textures by name; unsupported ones are present without a value.
using PbrtTextures = std::unordered_map<std::string, PbrtTexture>;

// No directive has more parameters; the search for repeated names is quadratic.
inline constexpr std::size_t kMaxPbrtParameters = 256;

// Reads parameters up to the next directive, which may come after the end of an included file.
// Throws InputError on an unknown type, a value that does not fit its type, or a missing bracket.
// As in pbrt, the last of several parameters of a name and type counts; that is a warning.
PbrtParameters ReadParameters(PbrtSource& source, const InputPosition& position,
                              const std::string& directive, Warnings& warnings);

// Returns the parameter with that name and one of those types, or null.
PbrtParameter* Find(PbrtParameters& parameters, std::initializer_list<std::string_view> types,
                    std::string_view name);

// Return a single value, or nothing if it is absent. Throw InputError unless there is exactly one
// value.
std::optional<float> FindFloat(PbrtParameters& parameters, std::string_view name);
std::optional<int> FindInt(PbrtParameters& parameters, std::string_view name);
std::optional<bool> FindBool(PbrtParameters& parameters, std::string_view name);
std::optional<std::string> FindString(PbrtParameters& parameters, std::string_view name);

// Returns the pairs (wavelength [nm], value) of a spectrum that is not given by name, at least one.
// Throws InputError unless the wavelengths ascend.
std::vector<glm::vec2> PairsOf(const PbrtParameter& parameter);

// Selects how a spectrum is converted to a colour (spectrum.h). The luminance of light is that of
// its spectrum in pbrt-v3 (kEmission), and 1 in pbrt-v4 (kUnitEmission).
enum class SpectrumUse { kReflectance, kEmission, kUnitEmission };

// Returns a linear Rec. 709 colour: rgb or color in the space of the parameters, xyz, a float
// (grey), a constant texture, a blackbody, or a spectrum: pairs of wavelength and value, a file of
// them, or a standard illuminant by name. Colours outside of Rec. 709 are clamped at 0, with a
// warning. For other names, for unknown textures and for those that vary, adds a
// warning and returns nothing.
std::optional<glm::vec3> FindColor(PbrtParameters& parameters, std::string_view name,
                                   const PbrtTextures& textures, Warnings& warnings,
                                   SpectrumUse use = SpectrumUse::kReflectance);

// Returns the texture with an image that the parameter names, or nothing if it names none.
std::optional<PbrtTexture> FindImageTexture(PbrtParameters& parameters, std::string_view name,
                                            const PbrtTextures& textures);

// Returns the texture in space that the parameter names, or nothing if it names none.
std::optional<PbrtTexture> FindSolidTexture(PbrtParameters& parameters, std::string_view name,
                                            const PbrtTextures& textures);

// Takes all parameters for looked up: those of what is not supported have nothing more to say.
void UseAll(PbrtParameters& parameters);
// Adds one warning for each parameter that was never looked up.
void ReportUnused(const PbrtParameters& parameters, Warnings& warnings);

}  // namespace skywave
