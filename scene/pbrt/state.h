// The state that the pbrt reader keeps between directives; internal to scene/pbrt/.
#pragma once

#include <compare>
#include <cstdint>
#include <functional>
#include <glm/glm.hpp>
#include <map>
#include <memory>
#include <optional>
#include <span>
#include <string>
#include <tuple>
#include <vector>

#include "scene/lens_system.h"
#include "scene/materials/texture_baking.h"
#include "scene/materials/texture_files.h"
#include "scene/pbrt/parameters.h"
#include "scene/pbrt/tokens.h"
#include "scene/read_options.h"
#include "scene/scene.h"
#include "scene/warnings.h"

namespace skywave {

// The light that AreaLightSource gives to the shapes that follow.
struct PbrtAreaLight {
  std::uint32_t number;  // number of the directive; its shapes share their material
  glm::vec3 radiance;    // radiance, or with `power` its relative colour
  bool two_sided;
  std::optional<float> power;  // of each face of a mesh, or of a round shape
  // Index into the scene's textures: a factor of the radiance, over (u, v) of the shape.
  std::optional<std::uint32_t> image;
};
// Parameters that Attribute gives to all later directives of a kind ("shape", "light",
// "material", "texture"). The map is shared between scopes and replaced as a whole.
using PbrtAttributeMap = std::map<std::string, std::vector<PbrtParameter>, std::less<>>;
using PbrtAttributes = std::shared_ptr<const PbrtAttributeMap>;

// A parameter that varies in space: of a material, the factor of the reflectance, the square root
// of alpha, the height of the surface, or the share of the second of two materials; of a shape, the
// opacity.
enum class PbrtSolidUse { kReflectance, kRoughness, kHeight, kShare, kOpacity };
struct PbrtSolidParameter {
  PbrtSolidUse use;
  std::shared_ptr<const PbrtSolid> value;
  float fallback = 0;  // what shapes get on which it cannot be: for roughness all alphas
};

// The lens of a realistic camera, which is focused once the size of the film is known.
struct PbrtLens {
  LensDesign design;
  double focus_distance = 10;  // from the film
  InputPosition position;      // of the camera
};

// The image of a light in all directions (LightMapping::kSphere).
struct PbrtSphereImage {
  std::uint32_t image;  // index into Scene::images
  double mean;          // of all channels
};

// Why nothing can be placed by a transform, and the directive that made it so.
struct PbrtTransformFlaw {
  std::string what;        // "singular" or "projective"
  std::string directive;   // its first word
  InputPosition position;  // its place
};

// The state that AttributeBegin saves and AttributeEnd restores.
struct PbrtGraphicsState {
  glm::dmat4 to_world{1.0};               // the current transformation matrix
  std::optional<PbrtTransformFlaw> flaw;  // of that matrix
  std::optional<std::uint32_t> material;  // nothing: shapes are invisible
  bool reverse_orientation = false;
  std::optional<PbrtAreaLight> area_light;
  bool transform_active = true;  // false: transforms describe the end of a motion
  PbrtAttributes attributes;
  std::optional<RgbConversion> color_space;  // nothing: linear Rec. 709
};

// What tells a round shape from others, besides its place.
struct PbrtRoundShape {
  std::string type;
  std::vector<std::optional<float>> numbers;  // FindRoundNumbers
  std::uint32_t material;
  bool needs_uvs, flipped;
  auto operator<=>(const PbrtRoundShape&) const = default;  // NOLINT(modernize-use-nullptr)
};

struct PbrtRoundObject {
  std::uint32_t object;  // index into Scene::objects
  float extent;          // largest coordinate
};

struct PbrtScope {
  std::string begin;       // the directive that opened it; Import does, too
  InputPosition position;  // its position
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
  // Textures of floats and textures of colours have separate names.
  PbrtTextures float_textures, color_textures;
  TextureFiles texture_files{&scene};
  // The images of textures of floats, by file, encoding and whether they are without a filter.
  std::map<std::tuple<std::string, Encoding, bool>, std::uint32_t> float_images;
  // The copy of a material for shapes with alpha, by material, opacity and opacity texture.
  std::map<std::tuple<std::uint32_t, float, std::uint32_t>, std::uint32_t> materials_with_alpha;
  std::vector<PbrtSolidParameter> solids;  // of the material that is being read
  // By material; a mixture of such materials is among them, even if it has none itself.
  std::map<std::uint32_t, std::vector<PbrtSolidParameter>> solid_materials;
  std::uint32_t area_lights = 0;
  // The emitting copy of a material, by material and area light.
  std::map<std::pair<std::uint32_t, std::uint32_t>, std::uint32_t> shining_materials;
  std::map<std::string, std::uint32_t> objects;  // index into Scene::objects, by name
  // Round shapes that are alike but for their place, as objects likewise.
  std::map<PbrtRoundShape, PbrtRoundObject> round_shapes;
  std::optional<std::uint32_t> clear_material;  // what light passes through, unbent
  bool in_object = false;                       // the last of Scene::objects is being defined
  // The factor of all light is their product: the speed of the film, and how long it is exposed.
  float film_gain = 1, exposure_time = 1;
  float film_diagonal = 35;      // [mm]
  std::optional<PbrtLens> lens;  // of the camera, if it is realistic
  bool v3 = false;               // the main file has a WorldEnd
  bool in_world = false;
  bool ended = false;         // WorldEnd has been read
  std::size_t triangles = 0;  // total of all meshes, those of each object once
  int includes = 0;
  // Textures whose values are clamped, by texture and factor.
  std::map<std::tuple<std::uint32_t, float, float, float>, std::uint32_t> clamped_textures;
  UnfilteredImages unfiltered_images{.name = "\"point\""};
  std::optional<std::uint32_t> checker_image;  // index into Scene::images
  std::size_t baked_texels = 0;
  // The images of the scene that textures in space look up, by index.
  std::map<std::uint32_t, std::shared_ptr<const CompactImage>> images_in_space;
  // The images of lights in all directions, by the file's image and whether it is pbrt-v4's.
  std::map<std::pair<std::uint32_t, bool>, PbrtSphereImage> sphere_images;
};

// Returns a place of the file's world as one of the scene (Scene::origin).
inline glm::vec3 ScenePlace(const PbrtReader& reader, const glm::dvec3& in_world) {
  return in_world - reader.options.origin;
}
// Returns the current transform to where shapes and instances stand: in the scene, or for shapes of
// an object in its own space, which is the file's world.
inline glm::dmat4 PlacementOf(const PbrtReader& reader) {
  glm::dmat4 placement = reader.state.to_world;
  if (!reader.in_object) placement[3] -= glm::dvec4(reader.options.origin, 0);
  return placement;
}

// Returns the parameters that follow a directive, and those that Attribute gives to its kind unless
// the directive overrides them.
PbrtParameters ReadParametersAndAttributes(PbrtReader& reader, PbrtSource& source,
                                           const InputPosition& position, std::string_view kind,
                                           const std::string& directive);

// Returns the path of a file that the scene names: absolute, relative to the file being read, or
// (as in pbrt) relative to the main one. Throws InputError at `position` if there is none.
std::string ResolvePbrtPath(const PbrtReader& reader, const std::string& name,
                            const InputPosition& position);

// Adds a warning at the directive that the parameters belong to.
void Warn(PbrtReader& reader, const PbrtParameters& parameters, const std::string& text);

// Handles a directive; `word` is the directive itself, already taken from `source`.
using PbrtHandler = void (*)(PbrtReader& reader, PbrtSource& source, const PbrtToken& word);
struct PbrtDirective {
  std::string_view word;
  PbrtHandler handler;
};
// Returns the handler of the directive `word`, or null if it is none of `directives`.
PbrtHandler FindPbrtDirective(std::span<const PbrtDirective> directives, std::string_view word);

// Returns the texture with every value at most 1, as reflectances are in pbrt: the image is copied
// if any of its texels exceeds that (textures.cc).
PbrtTexture ClampedPbrtTexture(PbrtReader& reader, const PbrtTexture& texture);

// Returns the index of a texture whose channels are all the mean of those of `texture`, between 0
// and 1, or 1 less that if `inverted` (textures.cc).
std::uint32_t PbrtShareTexture(PbrtReader& reader, const PbrtTexture& texture, bool inverted);

// Returns a texture of Material::roughness_texture for facets of an alpha of 1, an image or in
// space: `pack` makes a texel of the alphas of `roughness`, which are `alpha_of` of the means of
// each texture's channels. It has no value, with a warning, where the textures cannot be combined
// (textures.cc).
using PackAlphas = std::function<glm::vec3(std::span<const float>)>;
PbrtTexture PbrtAlphaTexture(PbrtReader& reader, const PbrtParameters& parameters,
                             const std::vector<PbrtTexture>& roughness,
                             const std::function<float(float)>& alpha_of, const PackAlphas& pack);

// Returns whether things can be placed by the current transform; otherwise warns that `what` at
// `position` is left out, and why (transforms.cc).
bool CanPlace(PbrtReader& reader, const InputPosition& position, std::string_view what);

// Open a scope at `word`, and close the innermost one, which `begin` must have opened, and return
// the state saved there (world.cc). Version 3 has one stack for attributes and objects: either ends
// what the other began, with a warning, and where none is open the directive has no effect.
void OpenPbrtScope(PbrtReader& reader, const PbrtSource& source, const PbrtToken& word);
PbrtGraphicsState ClosePbrtScope(PbrtReader& reader, const PbrtSource& source,
                                 const PbrtToken& word, std::string_view begin);

// Handles the directive Texture (textures.cc).
void ReadPbrtTexture(PbrtReader& reader, PbrtSource& source, const PbrtToken& word);

// Handle the directives LightSource and AreaLightSource, and return the material of a shape in the
// world: its own, or an emitting copy if there is an area light, whose power each of `faces` faces
// has (lights.cc).
void ReadPbrtLightSource(PbrtReader& reader, PbrtSource& source, const PbrtToken& word);
void ReadPbrtAreaLight(PbrtReader& reader, PbrtSource& source, const PbrtToken& word);
std::uint32_t ShiningPbrtMaterial(PbrtReader& reader, std::uint32_t plain, const Mesh& mesh,
                                  std::size_t faces, const InputPosition& position);

// Reads the arguments of `Directive "type" parameters` before WorldBegin (options.cc).
struct PbrtImplementation {
  std::string type;
  PbrtParameters parameters;
};
PbrtImplementation ReadPbrtImplementation(PbrtReader& reader, PbrtSource& source,
                                          const PbrtToken& word);

// Handles the directive Camera, and at the end gives it its lens, if it has one (cameras.cc).
void ReadPbrtCamera(PbrtReader& reader, PbrtSource& source, const PbrtToken& word);
void PlacePbrtLens(PbrtReader& reader);

// Return the handler of a directive, or null for words that the file does not handle.
PbrtHandler FindPbrtTransformDirective(std::string_view word);  // transforms.cc
PbrtHandler FindPbrtOptionDirective(std::string_view word);     // options.cc
PbrtHandler FindPbrtWorldDirective(std::string_view word);      // world.cc

}  // namespace skywave
