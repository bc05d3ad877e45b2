// pbrt's directives that describe the world: scopes, materials, shapes, objects, lights.
#include <fmt/format.h>

#include <utility>

#include "base/error.h"
#include "scene/mesh.h"
#include "scene/pbrt_materials.h"
#include "scene/pbrt_reader.h"
#include "scene/pbrt_shapes.h"
#include "scene/pbrt_state.h"
#include "scene/pbrt_surface_maps.h"

namespace skywave {
namespace {

void OpenScope(PbrtReader& reader, const PbrtSource& source, const PbrtToken& word) {
  if (reader.scopes.size() >= kMaxPbrtScopes) {
    throw InputError(PositionOf(source, word),
                     fmt::format("scopes are nested more than {} deep", kMaxPbrtScopes));
  }
  reader.scopes.push_back({std::string(word.text), PositionOf(source, word), reader.state});
}

// Closes the innermost scope, which `begin` has to have opened; returns the state saved there.
PbrtGraphicsState CloseScope(PbrtReader& reader, const PbrtSource& source, const PbrtToken& word,
                             std::string_view begin) {
  if (reader.scopes.empty()) {
    throw InputError(PositionOf(source, word), fmt::format("{} without {}", word.text, begin));
  }
  const PbrtScope scope = std::move(reader.scopes.back());
  if (scope.begin != begin) {
    throw InputError(PositionOf(source, word),
                     fmt::format("{} cannot close the {} of {}", word.text, scope.begin,
                                 ToString(scope.position)));
  }
  reader.scopes.pop_back();
  return scope.saved;
}

void WorldBegin(PbrtReader& reader, PbrtSource& source, const PbrtToken& word) {
  if (reader.in_world) throw InputError(PositionOf(source, word), "a second WorldBegin");
  if (!reader.scopes.empty()) {
    throw InputError(PositionOf(source, word),
                     fmt::format("WorldBegin inside the {} of {}", reader.scopes.back().begin,
                                 ToString(reader.scopes.back().position)));
  }
  reader.in_world = true;
  reader.state.to_world = glm::dmat4(1);
  reader.coordinate_systems["world"] = glm::dmat4(1);
}

void WorldEnd(PbrtReader& reader, PbrtSource& source, const PbrtToken& word) {
  if (!reader.in_world) throw InputError(PositionOf(source, word), "WorldEnd without WorldBegin");
  reader.ended = true;
}

void AttributeBegin(PbrtReader& reader, PbrtSource& source, const PbrtToken& word) {
  OpenScope(reader, source, word);
}
void AttributeEnd(PbrtReader& reader, PbrtSource& source, const PbrtToken& word) {
  reader.state = CloseScope(reader, source, word, "AttributeBegin");
}
void TransformBegin(PbrtReader& reader, PbrtSource& source, const PbrtToken& word) {
  OpenScope(reader, source, word);
}
void TransformEnd(PbrtReader& reader, PbrtSource& source, const PbrtToken& word) {
  reader.state.to_world = CloseScope(reader, source, word, "TransformBegin").to_world;
}

void ObjectBegin(PbrtReader& reader, PbrtSource& source, const PbrtToken& word) {
  const std::string name = ExpectString(source, "the name of an object");
  if (reader.object) {
    throw InputError(PositionOf(source, word), "ObjectBegin inside another object");
  }
  const auto [object, is_new] = reader.objects.try_emplace(name);
  if (!is_new) {
    throw InputError(PositionOf(source, word), fmt::format("a second object \"{}\"", name));
  }
  OpenScope(reader, source, word);
  reader.object = &object->second;
}

void ObjectEnd(PbrtReader& reader, PbrtSource& source, const PbrtToken& word) {
  reader.state = CloseScope(reader, source, word, "ObjectBegin");
  reader.object = nullptr;
}

void AddMesh(PbrtReader& reader, const InputPosition& position, Mesh mesh,
             std::vector<Mesh>& meshes) {
  reader.triangles += mesh.triangles.size();
  if (reader.triangles > kMaxSceneTriangles) {
    throw InputError(position, fmt::format("the scene has more than {} triangles from here on",
                                           kMaxSceneTriangles));
  }
  const std::size_t bad = FirstNonFinite(mesh.positions);
  if (bad < mesh.positions.size()) {
    throw InputError(position, fmt::format("vertex {} is not finite after its transform", bad));
  }
  meshes.push_back(std::move(mesh));
}

void ObjectInstance(PbrtReader& reader, PbrtSource& source, const PbrtToken& word) {
  const std::string name = ExpectString(source, "the name of an object");
  const InputPosition position = PositionOf(source, word);
  const auto object = reader.objects.find(name);
  if (object == reader.objects.end()) {
    throw InputError(position, fmt::format("there is no object \"{}\"", name));
  }
  if (reader.object) throw InputError(position, "ObjectInstance inside an object");
  for (Mesh mesh : object->second) {
    TransformMesh(reader.state.to_world, mesh);
    AddMesh(reader, position, std::move(mesh), reader.scene.meshes);
  }
}

void ReadShape(PbrtReader& reader, PbrtSource& source, const PbrtToken& word) {
  const InputPosition position = PositionOf(source, word);
  const std::string type = ExpectString(source, "the type of Shape");
  PbrtParameters parameters = ReadParameters(source, position, fmt::format("Shape \"{}\"", type));
  const auto resolve = [&](const std::string& name) {
    return ResolvePbrtPath(reader, name, position);
  };
  std::optional<std::uint32_t> material = reader.state.material;
  if (material) material = MaterialWithPbrtAlpha(reader, parameters, *material);
  std::optional<Mesh> mesh = MakePbrtShape(type, parameters, resolve, reader.warnings);
  if (!mesh) return;
  if (!material) {
    AddWarning(reader.warnings, position,
               "a shape that only bounds a medium is not supported: left out");
    return;
  }
  if (reader.state.has_area_light) {
    AddWarning(reader.warnings, position,
               "a shape that is an area light does not emit: only its material is rendered");
  }
  TransformMesh(reader.state.to_world, *mesh);
  if (reader.state.reverse_orientation) FlipOrientation(*mesh);
  mesh->material = *material;
  mesh->name = fmt::format("{} ({})", type, ToString(position));
  AddMesh(reader, position, std::move(*mesh), reader.object ? *reader.object : reader.scene.meshes);
}

std::optional<std::uint32_t> AddMaterial(PbrtReader& reader, const std::string& type,
                                         const std::string& name, PbrtParameters& parameters) {
  if (IsInvisiblePbrtMaterial(type)) {
    ReportUnused(parameters, reader.warnings);
    return std::nullopt;
  }
  Material relief;
  ReadPbrtRelief(reader, parameters, relief);
  Material material = MakePbrtMaterial(type, parameters, reader.textures, reader.warnings);
  material.name = name;
  material.normal_texture = relief.normal_texture;
  material.normal_scale = relief.normal_scale;
  reader.scene.materials.push_back(std::move(material));
  return static_cast<std::uint32_t>(reader.scene.materials.size() - 1);
}

void ReadMaterial(PbrtReader& reader, PbrtSource& source, const PbrtToken& word) {
  const InputPosition position = PositionOf(source, word);
  const std::string type = ExpectString(source, "the type of Material");
  PbrtParameters parameters =
      ReadParameters(source, position, fmt::format("Material \"{}\"", type));
  reader.state.material = AddMaterial(reader, type, type, parameters);
}

void MakeNamedMaterial(PbrtReader& reader, PbrtSource& source, const PbrtToken& word) {
  const InputPosition position = PositionOf(source, word);
  const std::string name = ExpectString(source, "the name of a material");
  PbrtParameters parameters =
      ReadParameters(source, position, fmt::format("MakeNamedMaterial \"{}\"", name));
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
    throw InputError(PositionOf(source, word), fmt::format("there is no material \"{}\"", name));
  }
  reader.state.material = found->second;
}

// Columns right, forward, up of a lat-long map in the light's space (see pbrt_reader.h), in the
// world. Frames are unit vectors: pbrt's directions do not change by a scale either.
glm::mat3 MapFrame(PbrtReader& reader, const PbrtParameters& parameters) {
  const glm::dmat3 linear(reader.state.to_world);
  glm::dmat3 frame(-linear[1], -linear[0], linear[2]);
  for (int i = 0; i < 3; ++i) frame[i] = glm::normalize(frame[i]);
  const double skew = std::abs(glm::dot(frame[0], frame[1])) +
                      std::abs(glm::dot(frame[1], frame[2])) +
                      std::abs(glm::dot(frame[2], frame[0]));
  const double lengths[] = {glm::length(linear[0]), glm::length(linear[1]), glm::length(linear[2])};
  const bool even = std::max({lengths[0], lengths[1], lengths[2]}) <=
                    1.001 * std::min({lengths[0], lengths[1], lengths[2]});
  if (skew > 1e-4 || !even) {
    AddWarning(
        reader.warnings, parameters.position,
        parameters.directive + ": its transform stretches the map: only the rotation is used");
    const double side = glm::determinant(frame) < 0 ? -1 : 1;
    frame[1] = glm::normalize(frame[1] - frame[2] * glm::dot(frame[1], frame[2]));
    frame[0] = side * glm::cross(frame[1], frame[2]);
  }
  return frame;
}

void ReadLightSource(PbrtReader& reader, PbrtSource& source, const PbrtToken& word) {
  const InputPosition position = PositionOf(source, word);
  const std::string type = ExpectString(source, "the type of LightSource");
  PbrtParameters parameters =
      ReadParameters(source, position, fmt::format("LightSource \"{}\"", type));
  if (type != "infinite" && type != "exinfinite") {
    AddWarning(reader.warnings, position, parameters.directive + " is not supported: left out");
    return;
  }
  EnvironmentLight light;
  light.scale = FindColor(parameters, "L", reader.textures, reader.warnings).value_or(glm::vec3(1));
  if (Find(parameters, {"float"}, "scale")) {
    light.scale *= *FindFloat(parameters, "scale");
  } else if (const auto scale = FindColor(parameters, "scale", reader.textures, reader.warnings)) {
    light.scale *= *scale;  // a colour in pbrt-v3
  }
  if (!glm::all(glm::greaterThanEqual(light.scale, glm::vec3(0)))) {
    throw InputError(position, parameters.directive + ": negative radiance");
  }
  for (const char* name : {"filename", "mapname"}) {
    const auto file = FindString(parameters, name);
    if (!file || file->empty()) continue;
    light.map_path = ResolvePbrtPath(reader, *file, position);
    light.equal_area_square = std::string_view(name) == "filename";  // pbrt-v4; v3 has lat-longs
  }
  light.world_from_map = MapFrame(reader, parameters);
  ReportUnused(parameters, reader.warnings);
  reader.scene.environments.push_back(std::move(light));
}

void AreaLightSource(PbrtReader& reader, PbrtSource& source, const PbrtToken& word) {
  const std::string type = ExpectString(source, "the type of AreaLightSource");
  ReadParameters(source, PositionOf(source, word), "AreaLightSource");
  AddWarning(reader.warnings, PositionOf(source, word),
             fmt::format("AreaLightSource \"{}\" is not supported: left out", type));
  reader.state.has_area_light = true;
}

// `Word "name" parameters`, of which nothing is rendered.
void Ignore(PbrtReader& reader, PbrtSource& source, const PbrtToken& word) {
  const std::string name = ExpectString(source, fmt::format("the name of {}", word.text));
  ReadParameters(source, PositionOf(source, word), std::string(word.text));
  AddWarning(reader.warnings, PositionOf(source, word),
             fmt::format("{} \"{}\" is not supported: ignored", word.text, name));
}

void MediumInterface(PbrtReader& reader, PbrtSource& source, const PbrtToken& word) {
  ExpectString(source, "the name of a medium");
  if (PeekToken(source).kind == PbrtTokenKind::kString) NextToken(source);
  AddWarning(reader.warnings, PositionOf(source, word),
             "MediumInterface is not supported: ignored");
}

struct Entry {
  std::string_view word;
  PbrtHandler handler;
};
constexpr Entry kDirectives[] = {
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
    {"LightSource", ReadLightSource},
    {"AreaLightSource", AreaLightSource},
    {"MakeNamedMedium", Ignore},
    {"Attribute", Ignore},  // pbrt-v4: defaults of parameters
    {"Volume", Ignore},     // pbrt-v2
    {"MediumInterface", MediumInterface},
};

}  // namespace

PbrtHandler FindPbrtWorldDirective(std::string_view word) {
  for (const Entry& entry : kDirectives) {
    if (entry.word == word) return entry.handler;
  }
  return nullptr;
}

}  // namespace skywave
