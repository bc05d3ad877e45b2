// What the pbrt reader keeps between directives; internal to scene/pbrt_*.cc.
#pragma once

#include <cstdint>
#include <glm/glm.hpp>
#include <map>
#include <memory>
#include <optional>
#include <string>
#include <tuple>
#include <vector>

#include "scene/materials/texture_files.h"
#include "scene/pbrt/parameters.h"
#include "scene/pbrt/tokens.h"
#include "scene/read_options.h"
#include "scene/scene.h"
#include "scene/warnings.h"

namespace skywave {

// What AreaLightSource makes of the shapes that follow.
struct PbrtAreaLight {
  std::uint32_t number;  // of the directive: shapes of one share their material
  glm::vec3 radiance;    // or, with `power`, what that is a factor of
  bool two_sided;
  std::optional<float> power;  // of each shape
};
// Parameters that Attribute gives to all later directives of a kind ("shape", "material",
// "texture"). Shared between scopes, replaced as a whole.
using PbrtAttributeMap = std::map<std::string, std::vector<PbrtParameter>, std::less<>>;
using PbrtAttributes = std::shared_ptr<const PbrtAttributeMap>;

// What AttributeBegin saves and AttributeEnd restores.
struct PbrtGraphicsState {
  glm::dmat4 to_world{1.0};               // the current transformation matrix
  std::optional<std::uint32_t> material;  // nothing: shapes are invisible
  bool reverse_orientation = false;
  std::optional<PbrtAreaLight> area_light;
  bool transform_active = true;  // false: transforms are those of the end of a motion
  PbrtAttributes attributes;
};

struct PbrtScope {
  std::string begin;       // the directive that opened it
  InputPosition position;  // and where
  PbrtGraphicsState saved;
};

struct PbrtReader {
  ReadOptions options;
  Scene scene;
  Warnings warnings;
  PbrtGraphicsState state;
  std::vector<PbrtScope> scopes;
  std::vector<std::unique_ptr<PbrtSource>> sources;  // the main file and the includes that are open
  std::map<std::string, glm::dmat4> coordinate_systems;
  std::map<std::string, std::optional<std::uint32_t>> named_materials;
  // Textures of floats and those of colours have names of their own.
  PbrtTextures float_textures, color_textures;
  TextureFiles texture_files{&scene};
  // By material, opacity and its texture: the copy of the material for shapes with such an alpha.
  std::map<std::tuple<std::uint32_t, float, std::uint32_t>, std::uint32_t> materials_with_alpha;
  std::uint32_t area_lights = 0;
  // By material and area light: the material that shines.
  std::map<std::pair<std::uint32_t, std::uint32_t>, std::uint32_t> shining_materials;
  std::map<std::string, std::vector<Mesh>> objects;
  std::vector<Mesh>* object = nullptr;  // the one being defined
  bool in_world = false;
  bool ended = false;         // by WorldEnd
  std::size_t triangles = 0;  // of all meshes, objects included
  int includes = 0;
  std::optional<std::uint32_t> checker_image;  // index into Scene::images
  std::size_t baked_texels = 0;
};

// The parameters that follow a directive, and those that Attribute gives to its kind unless it has
// parameters of that name itself.
PbrtParameters ReadParametersAndAttributes(const PbrtReader& reader, PbrtSource& source,
                                           const InputPosition& position, std::string_view kind,
                                           const std::string& directive);

// The path of a file that the scene names: absolute, or beside the file that is being read, or (as
// pbrt has it) beside the main one. Throws InputError at `position` if there is none.
std::string ResolvePbrtPath(const PbrtReader& reader, const std::string& name,
                            const InputPosition& position);

// A directive's work; `word` is the directive itself, already taken from `source`.
using PbrtHandler = void (*)(PbrtReader& reader, PbrtSource& source, const PbrtToken& word);

// The directive Texture (pbrt_textures.cc).
void ReadPbrtTexture(PbrtReader& reader, PbrtSource& source, const PbrtToken& word);

// The directives LightSource and AreaLightSource, and the material of a shape in the world: the one
// it has otherwise, shining if there is an area light (pbrt_lights.cc).
void ReadPbrtLightSource(PbrtReader& reader, PbrtSource& source, const PbrtToken& word);
void ReadPbrtAreaLight(PbrtReader& reader, PbrtSource& source, const PbrtToken& word);
std::uint32_t ShiningPbrtMaterial(PbrtReader& reader, std::uint32_t plain, const Mesh& mesh,
                                  const InputPosition& position);

// The handler of a directive, by file: null for words that are not its.
PbrtHandler FindPbrtTransformDirective(std::string_view word);  // pbrt_transforms.cc
PbrtHandler FindPbrtOptionDirective(std::string_view word);     // pbrt_options.cc
PbrtHandler FindPbrtWorldDirective(std::string_view word);      // pbrt_world.cc

}  // namespace skywave
