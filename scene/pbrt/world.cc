// Handles pbrt's directives that describe the world: scopes, materials, shapes, objects, lights.
#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <glm/gtc/matrix_transform.hpp>
#include <set>
#include <utility>
#include <vector>

#include "base/error.h"
#include "kernels/bsdf/bsdf.h"
#include "scene/instances.h"
#include "scene/pbrt/materials.h"
#include "scene/pbrt/reader.h"
#include "scene/pbrt/round_shapes.h"
#include "scene/pbrt/shapes.h"
#include "scene/pbrt/solid_baking.h"
#include "scene/pbrt/state.h"
#include "scene/pbrt/surface_maps.h"
#include "scene/shapes/mesh.h"

namespace skywave {
namespace {

void WorldBegin(PbrtReader& reader, PbrtSource& source, const PbrtToken& word) {
  if (reader.in_world) throw InputError(PositionOf(source, word), "a second WorldBegin");
  if (!reader.scopes.empty()) {
    throw InputError(PositionOf(source, word),
                     fmt::format("WorldBegin inside the {} of {}", reader.scopes.back().begin,
                                 ToString(reader.scopes.back().position)));
  }
  reader.in_world = true;
  reader.state.to_world = glm::dmat4(1);
  reader.state.flaw.reset();
  reader.state.transform_active = true;
  reader.coordinate_systems["world"] = glm::dmat4(1);
}

void WorldEnd(PbrtReader& reader, PbrtSource& source, const PbrtToken& word) {
  if (!reader.in_world) throw InputError(PositionOf(source, word), "WorldEnd without WorldBegin");
  reader.ended = true;
}

void AttributeBegin(PbrtReader& reader, PbrtSource& source, const PbrtToken& word) {
  OpenPbrtScope(reader, source, word);
}
void AttributeEnd(PbrtReader& reader, PbrtSource& source, const PbrtToken& word) {
  reader.state = ClosePbrtScope(reader, source, word, "AttributeBegin");
}
void TransformBegin(PbrtReader& reader, PbrtSource& source, const PbrtToken& word) {
  OpenPbrtScope(reader, source, word);
}
void TransformEnd(PbrtReader& reader, PbrtSource& source, const PbrtToken& word) {
  const PbrtGraphicsState saved = ClosePbrtScope(reader, source, word, "TransformBegin");
  if (!reader.v3) {
    reader.state = saved;
    return;
  }
  reader.state.to_world = saved.to_world;
  reader.state.flaw = saved.flaw;
  reader.state.transform_active = saved.transform_active;
}

void ObjectBegin(PbrtReader& reader, PbrtSource& source, const PbrtToken& word) {
  const std::string name = ExpectString(source, "the name of an object");
  if (reader.in_object) {
    throw InputError(PositionOf(source, word), "ObjectBegin inside another object");
  }
  const auto index = std::uint32_t(reader.scene.objects.size());
  if (!reader.objects.insert_or_assign(name, index).second) {
    AddWarning(reader.warnings, PositionOf(source, word),
               fmt::format("a second object \"{}\": instances that follow show this one", name));
  }
  OpenPbrtScope(reader, source, word);
  reader.scene.objects.push_back({.name = name, .meshes = {}});
  reader.in_object = true;
}

void ObjectEnd(PbrtReader& reader, PbrtSource& source, const PbrtToken& word) {
  if (reader.v3 && !reader.in_object) {
    AddWarning(reader.warnings, PositionOf(source, word), "ObjectEnd without ObjectBegin: ignored");
    return;
  }
  reader.state = ClosePbrtScope(reader, source, word, "ObjectBegin");
  reader.in_object = false;
}

// Counts a mesh in the world, and refuses what no table of triangles can hold.
void CheckMesh(PbrtReader& reader, const InputPosition& position, const Mesh& mesh) {
  reader.triangles += mesh.triangles.size();
  if (reader.triangles > reader.options.max_triangles) {
    throw InputError(position,
                     fmt::format("the scene has more than {} triangles from here on (`max-"
                                 "triangles`)",
                                 reader.options.max_triangles));
  }
  const std::size_t bad = FirstNonFinite(mesh.positions);
  if (bad < mesh.positions.size()) {
    throw InputError(position, fmt::format("vertex {} is not finite after its transform", bad));
  }
}

void AddInstance(PbrtReader& reader, const InputPosition& position, std::uint32_t object,
                 const glm::dmat4& world_from_object) {
  const std::size_t most = reader.options.max_instances;
  if (reader.scene.instances.size() == most) {
    throw InputError(position, fmt::format("the scene has more than {} instances", most));
  }
  reader.scene.instances.push_back({.object = object,
                                    .world_from_object = glm::dmat4x3(world_from_object),
                                    .meshes_before = std::uint32_t(reader.scene.meshes.size())});
}

void ObjectInstance(PbrtReader& reader, PbrtSource& source, const PbrtToken& word) {
  const std::string name = ExpectString(source, "the name of an object");
  const InputPosition position = PositionOf(source, word);
  const auto object = reader.objects.find(name);
  if (object == reader.objects.end()) {
    throw InputError(position, fmt::format("there is no object \"{}\"", name));
  }
  if (reader.in_object) throw InputError(position, "ObjectInstance inside an object");
  if (!CanPlace(reader, position, "an ObjectInstance")) return;
  AddInstance(reader, position, object->second, PlacementOf(reader));
}

// Returns true if the material, or one that it is mixed of, depends on (u, v): it has a texture, or
// a tangent. `seen` has those that were asked before, without one.
bool UsesUvs(const Scene& scene, std::uint32_t index, std::set<std::uint32_t>& seen) {
  if (!seen.insert(index).second) return false;
  const Material& material = scene.materials[index];
  bool uses = HasTangent(material);
  ForEachTexture(material, [&](std::uint32_t) { uses = true; });
  if (const auto& mixture = material.mixture) {
    uses = uses || UsesUvs(scene, mixture->first, seen) || UsesUvs(scene, mixture->second, seen);
  }
  return uses;
}

// Returns whether pbrt's normals of a shape point to the side opposite to the expected one: those
// of a loopsubdiv, which are computed against its winding, and those of a round shape that its
// transform mirrors, because they are turned over before the transform and not after it. Round
// lamps stay as they are: pbrt's light samples see them so, and its hits do not.
bool TurnsPbrtShape(std::string_view type, const PbrtGraphicsState& state) {
  return type == "loopsubdiv" || (IsRoundPbrtShape(type) && !state.area_light &&
                                  glm::determinant(glm::dmat3(state.to_world)) < 0);
}

// Returns the material of what light passes through, unbent.
std::uint32_t ClearPbrtMaterial(PbrtReader& reader) {
  if (!reader.clear_material) {
    reader.clear_material = std::uint32_t(reader.scene.materials.size());
    reader.scene.materials.push_back(
        {.name = "none", .bsdf = BsdfKind::kDielectric, .reflectance = glm::vec3(1), .ior = 1});
  }
  return *reader.clear_material;
}

// Adds an instance of a round shape, whose triangles shapes of the same form and material share.
void PlaceRoundShape(PbrtReader& reader, PbrtParameters& parameters, const std::string& type,
                     std::uint32_t material, const PbrtShapeOptions& options, bool flipped) {
  auto [numbers, scale] = FindRoundNumbers(type, parameters);
  const PbrtRoundShape form = {type, std::move(numbers), material, options.needs_uvs, flipped};
  auto found = reader.round_shapes.find(form);
  if (found == reader.round_shapes.end()) {
    std::optional<PbrtShape> shape = MakePbrtShape(type, parameters, {}, options, reader.warnings);
    CheckMesh(reader, parameters.position, shape->mesh);
    if (flipped) FlipOrientation(shape->mesh);
    shape->mesh.material = material;
    shape->mesh.name = fmt::format("{} ({})", type, ToString(parameters.position));
    float extent = 0;
    for (const glm::vec3& p : shape->mesh.positions) {
      extent = std::max({extent, std::abs(p.x), std::abs(p.y), std::abs(p.z)});
    }
    const auto object = std::uint32_t(reader.scene.objects.size());
    reader.scene.objects.push_back({.name = shape->mesh.name, .meshes = {std::move(shape->mesh)}});
    found = reader.round_shapes.emplace(form, PbrtRoundObject{object, extent}).first;
  } else {
    ReportUnused(parameters, reader.warnings);
  }
  if (!CanPlace(reader, parameters.position, parameters.directive)) return;
  const auto [object, extent] = found->second;
  const glm::dmat4 to_world = glm::scale(PlacementOf(reader), glm::dvec3(double(scale)));
  for (int axis = 0; axis < 3; ++axis) {
    const double reach =
        (std::abs(to_world[0][axis]) + std::abs(to_world[1][axis]) + std::abs(to_world[2][axis])) *
        double(extent);
    if (std::isfinite(float(reach + std::abs(to_world[3][axis])))) continue;
    throw InputError(parameters.position, "the shape is not finite after its transform");
  }
  AddInstance(reader, parameters.position, object, to_world);
}

void ReadShape(PbrtReader& reader, PbrtSource& source, const PbrtToken& word) {
  const InputPosition position = PositionOf(source, word);
  const std::string type = ExpectString(source, "the type of Shape");
  PbrtParameters parameters = ReadParametersAndAttributes(reader, source, position, "shape",
                                                          fmt::format("Shape \"{}\"", type));
  const auto resolve = [&](const std::string& name) {
    return ResolvePbrtPath(reader, name, position);
  };
  std::optional<std::uint32_t> material = reader.state.material;
  const std::optional<std::uint32_t> named = material;
  const auto alpha = FindSolidTexture(parameters, "alpha", reader.float_textures);
  const bool varies = named && (alpha || reader.solid_materials.contains(*named));
  if (material && !alpha) material = MaterialWithPbrtAlpha(reader, parameters, *material);
  const auto& lamp = reader.state.area_light;
  std::set<std::uint32_t> seen;
  const bool fixed_uvs =
      material && (UsesUvs(reader.scene, *material, seen) || (lamp && lamp->image));
  const bool uses_uvs = fixed_uvs || varies;
  const PbrtShapeOptions options = {.needs_uvs = uses_uvs || !reader.scene.textures.empty(),
                                    .corner_uvs = uses_uvs,
                                    .max_triangles = reader.options.max_triangles};
  // The lamps of version 3 shine without a material, and let light pass.
  if (!material && reader.v3 && lamp) material = ClearPbrtMaterial(reader);
  const bool flipped = reader.state.reverse_orientation != TurnsPbrtShape(type, reader.state);
  if (IsRoundPbrtShape(type) && material && !varies && !lamp && !reader.in_object) {
    PlaceRoundShape(reader, parameters, type, *material, options, flipped);
    return;
  }
  std::optional<PbrtShape> shape =
      MakePbrtShape(type, parameters, resolve, options, reader.warnings);
  if (!shape) return;
  Mesh& mesh = shape->mesh;
  if (!material) {
    AddWarning(reader.warnings, position,
               "a shape that only bounds a medium is not supported: left out");
    return;
  }
  if (!CanPlace(reader, position, parameters.directive)) return;
  TransformMesh(PlacementOf(reader), mesh);
  CheckMesh(reader, position, mesh);
  if (flipped) FlipOrientation(mesh);
  if (varies && !mesh.triangles.empty()) {
    material =
        MaterialWithSolids(reader, *named, *material,
                           {type, position, fixed_uvs, alpha ? alpha->solid : nullptr}, mesh);
  }
  mesh.material = ShiningPbrtMaterial(reader, *material, mesh, shape->faces, position);
  mesh.name = fmt::format("{} ({})", type, ToString(position));
  Scene& scene = reader.scene;
  (reader.in_object ? scene.objects.back().meshes : scene.meshes).push_back(std::move(mesh));
}

std::optional<std::uint32_t> AddMaterial(PbrtReader& reader, const std::string& type,
                                         const std::string& name, PbrtParameters& parameters) {
  if (IsInvisiblePbrtMaterial(type)) {
    ReportUnused(parameters, reader.warnings);
    return std::nullopt;
  }
  reader.solids.clear();
  Material relief;
  if (type != "mix") ReadPbrtRelief(reader, parameters, relief);
  const std::size_t before = reader.scene.materials.size();
  Material material = MakePbrtMaterial(type, parameters, reader);
  material.name = name;
  // A sum has parts, which were added.
  std::vector<Material>& materials = reader.scene.materials;
  const auto set_relief = [&](Material& bumpy) {
    bumpy.normal_texture = relief.normal_texture;
    bumpy.normal_scale = relief.normal_scale;
  };
  std::for_each(materials.begin() + std::ptrdiff_t(before), materials.end(), set_relief);
  set_relief(material);
  const auto& mixture = material.mixture;
  const bool varies =
      !reader.solids.empty() || (mixture && (reader.solid_materials.contains(mixture->first) ||
                                             reader.solid_materials.contains(mixture->second)));
  reader.scene.materials.push_back(std::move(material));
  const auto index = static_cast<std::uint32_t>(reader.scene.materials.size() - 1);
  if (varies) reader.solid_materials.emplace(index, reader.solids);
  return index;
}

void ReadMaterial(PbrtReader& reader, PbrtSource& source, const PbrtToken& word) {
  const InputPosition position = PositionOf(source, word);
  const std::string type = ExpectString(source, "the type of Material");
  PbrtParameters parameters = ReadParametersAndAttributes(reader, source, position, "material",
                                                          fmt::format("Material \"{}\"", type));
  reader.state.material = AddMaterial(reader, type, type, parameters);
}

void MakeNamedMaterial(PbrtReader& reader, PbrtSource& source, const PbrtToken& word) {
  const InputPosition position = PositionOf(source, word);
  const std::string name = ExpectString(source, "the name of a material");
  PbrtParameters parameters = ReadParametersAndAttributes(
      reader, source, position, "material", fmt::format("MakeNamedMaterial \"{}\"", name));
  const auto type = FindString(parameters, "type");
  if (!type) {
    throw InputError(position,
                     fmt::format("MakeNamedMaterial \"{}\" needs a \"string type\"", name));
  }
  parameters.directive += fmt::format(" (type \"{}\")", *type);
  reader.named_materials[name] = AddMaterial(reader, *type, name, parameters);
}

void NamedMaterial(PbrtReader& reader, PbrtSource& source, const PbrtToken& word) {
  const std::string name = ExpectString(source, "the name of a material");
  const auto found = reader.named_materials.find(name);
  if (found == reader.named_materials.end()) {
    // Version 3 goes on with the material that there was; version 4 ends with an error.
    AddWarning(reader.warnings, PositionOf(source, word),
               fmt::format("there is no material \"{}\": the one before it stays", name));
    return;
  }
  reader.state.material = found->second;
}

// pbrt-v4's Attribute gives parameters to all later directives of a kind within the scope.
void Attribute(PbrtReader& reader, PbrtSource& source, const PbrtToken& word) {
  const InputPosition position = PositionOf(source, word);
  const std::string kind = ExpectString(source, "the kind of Attribute");
  const PbrtParameters given =
      ReadParameters(source, position, fmt::format("Attribute \"{}\"", kind), reader.warnings);
  if (kind == "medium") {
    AddWarning(reader.warnings, position, given.directive + " is not supported: ignored");
    return;
  }
  if (kind != "shape" && kind != "light" && kind != "material" && kind != "texture") {
    throw InputError(
        position, given.directive + ": the kinds are shape, light, material, medium and texture");
  }
  auto all = reader.state.attributes ? *reader.state.attributes : PbrtAttributeMap();
  for (const PbrtParameter& parameter : given.list) {
    std::erase_if(all[kind], [&](auto& other) { return other.name == parameter.name; });
    all[kind].push_back(parameter);
  }
  if (all[kind].size() > kMaxPbrtParameters) {
    throw InputError(position, fmt::format("{} has more than {} parameters", given.directive,
                                           kMaxPbrtParameters));
  }
  reader.state.attributes = std::make_shared<const PbrtAttributeMap>(std::move(all));
}

// Skips `Word "name" parameters`, a directive without effect on the picture.
void IgnoreNamed(PbrtReader& reader, PbrtSource& source, const PbrtToken& word) {
  const std::string name = ExpectString(source, fmt::format("the name of {}", word.text));
  ReadParameters(source, PositionOf(source, word), std::string(word.text), reader.warnings);
  AddWarning(reader.warnings, PositionOf(source, word),
             fmt::format("{} \"{}\" is not supported: ignored", word.text, name));
}

void MediumInterface(PbrtReader& reader, PbrtSource& source, const PbrtToken& word) {
  ExpectString(source, "the name of a medium");
  if (PeekToken(source).kind == PbrtTokenKind::kString) NextToken(source);
  AddWarning(reader.warnings, PositionOf(source, word),
             "MediumInterface is not supported: ignored");
}

// Returns whether the end of a scope that `one` began may close one that `other` began. To pbrt-v4,
// TransformBegin and TransformEnd are other words for AttributeBegin and AttributeEnd; version 3
// keeps attributes and objects on one stack.
bool OpenTheSame(const PbrtReader& reader, std::string_view one, std::string_view other) {
  const std::string_view alias = reader.v3 ? "ObjectBegin" : "TransformBegin";
  const auto attributes = [&](std::string_view word) {
    return word == "AttributeBegin" || word == alias;
  };
  return one == other || (attributes(one) && attributes(other));
}

constexpr PbrtDirective kWorldDirectives[] = {
    {"WorldBegin", WorldBegin},
    {"WorldEnd", WorldEnd},
    {"AttributeBegin", AttributeBegin},
    {"AttributeEnd", AttributeEnd},
    {"TransformBegin", TransformBegin},
    {"TransformEnd", TransformEnd},
    {"ObjectBegin", ObjectBegin},
    {"ObjectEnd", ObjectEnd},
    {"ObjectInstance", ObjectInstance},
    {"Shape", ReadShape},
    {"Material", ReadMaterial},
    {"MakeNamedMaterial", MakeNamedMaterial},
    {"NamedMaterial", NamedMaterial},
    {"Texture", ReadPbrtTexture},
    {"LightSource", ReadPbrtLightSource},
    {"AreaLightSource", ReadPbrtAreaLight},
    {"MakeNamedMedium", IgnoreNamed},
    {"Attribute", Attribute},
    {"Volume", IgnoreNamed},  // pbrt-v2
    {"MediumInterface", MediumInterface},
};

}  // namespace

void OpenPbrtScope(PbrtReader& reader, const PbrtSource& source, const PbrtToken& word) {
  if (reader.scopes.size() >= kMaxPbrtScopes) {
    throw InputError(PositionOf(source, word),
                     fmt::format("scopes are nested more than {} deep", kMaxPbrtScopes));
  }
  reader.scopes.push_back({std::string(word.text), PositionOf(source, word), reader.state});
}

PbrtGraphicsState ClosePbrtScope(PbrtReader& reader, const PbrtSource& source,
                                 const PbrtToken& word, std::string_view begin) {
  if (reader.scopes.empty()) {
    const std::string what = fmt::format("{} without {}", word.text, begin);
    if (!reader.v3) throw InputError(PositionOf(source, word), what);
    AddWarning(reader.warnings, PositionOf(source, word), what + ": ignored");
    return reader.state;
  }
  const PbrtScope scope = std::move(reader.scopes.back());
  if (!OpenTheSame(reader, scope.begin, begin)) {
    throw InputError(PositionOf(source, word),
                     fmt::format("{} cannot close the {} of {}", word.text, scope.begin,
                                 ToString(scope.position)));
  }
  if (reader.v3 && scope.begin != begin) {
    AddWarning(
        reader.warnings, PositionOf(source, word),
        fmt::format("{} closes the {} of {}", word.text, scope.begin, ToString(scope.position)));
  }
  reader.scopes.pop_back();
  return scope.saved;
}

PbrtHandler FindPbrtWorldDirective(std::string_view word) {
  return FindPbrtDirective(kWorldDirectives, word);
}

}  // namespace skywave
