// The typed parameter list that follows most pbrt directives: "type name" value or [ values ].
//
// Look-ups mark what they return as used; ReportUnused then names everything that nobody asked for,
// so that no parameter is skipped in silence.
#pragma once

#include <cstdint>
#include <glm/glm.hpp>
#include <initializer_list>
#include <optional>
#include <string>
#include <string_view>
#include <unordered_map>
#include <vector>

#include "base/error.h"
#include "scene/pbrt/tokens.h"
#include "scene/warnings.h"

namespace skywave {

struct PbrtParameter {
  std::string type, name;
  InputPosition position;
  std::vector<float> floats;         // all types but the following
  std::vector<std::int32_t> ints;    // integer
  std::vector<std::string> strings;  // string, texture, bool ("true", "false"), spectrum by name
  bool used = false;
};

struct PbrtParameters {
  InputPosition position;  // of the directive
  std::string directive;   // Shape "sphere", for messages
  std::vector<PbrtParameter> list;
};

struct PbrtTexture {
  std::optional<glm::vec3> value;      // what it is everywhere, or the factor of the image
  std::optional<std::uint32_t> image;  // index into Scene::textures
};
// By name; those that are not understood are present without a value.
using PbrtTextures = std::unordered_map<std::string, PbrtTexture>;  // by name

// The search for repeated names is quadratic: no directive has more.
inline constexpr std::size_t kMaxPbrtParameters = 256;

// Reads parameters up to the next directive. Throws InputError on an unknown type, a value that
// does not fit its type, a missing bracket or a name given twice.
PbrtParameters ReadParameters(PbrtSource& source, const InputPosition& position,
                              const std::string& directive);

// The parameter of that name and one of those types, or null.
PbrtParameter* Find(PbrtParameters& parameters, std::initializer_list<std::string_view> types,
                    std::string_view name);

// Single values; nothing if absent. InputError if there is not exactly one.
std::optional<float> FindFloat(PbrtParameters& parameters, std::string_view name);
std::optional<int> FindInt(PbrtParameters& parameters, std::string_view name);
std::optional<bool> FindBool(PbrtParameters& parameters, std::string_view name);
std::optional<std::string> FindString(PbrtParameters& parameters, std::string_view name);

// What a spectrum is turned into a colour for (spectrum.h).
enum class SpectrumUse { kReflectance, kEmission };

// A linear Rec. 709 colour: rgb or color, xyz, a float (grey), a constant texture, a blackbody, or
// a spectrum: pairs of wavelength and value, a file of them, or a standard illuminant by name. What
// is not simple (other names, textures that vary) gives a warning and nothing.
std::optional<glm::vec3> FindColor(PbrtParameters& parameters, std::string_view name,
                                   const PbrtTextures& textures, Warnings& warnings,
                                   SpectrumUse use = SpectrumUse::kReflectance);

// The texture with an image that the parameter names, or nothing if it names none.
std::optional<PbrtTexture> FindImageTexture(PbrtParameters& parameters, std::string_view name,
                                            const PbrtTextures& textures);

// One warning for each parameter that nobody looked up.
void ReportUnused(const PbrtParameters& parameters, Warnings& warnings);

}  // namespace skywave
