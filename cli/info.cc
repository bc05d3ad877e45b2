// Implements skywave info: the contents of a scene.
#include <fmt/format.h>
#include <fmt/ranges.h>

#include <array>
#include <memory>
#include <nlohmann/json.hpp>
#include <optional>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "base/clock.h"
#include "base/files.h"
#include "base/json.h"
#include "base/version.h"
#include "cli/commands.h"
#include "cli/print.h"
#include "job/options.h"
#include "kernels/bsdf/bsdf.h"
#include "kernels/bsdf/material.h"
#include "scene/geometry.h"
#include "scene/lens_system.h"
#include "scene/local_lights.h"
#include "scene/reader.h"
#include "scene/scene_summary.h"
#include "wavefront/option_names.h"

namespace skywave {
namespace {

struct InfoFlags {
  JobRequest request;  // the scene and how it is read
  std::string json;
};

struct SceneFile {
  Scene scene;
  SceneSummary summary;
  std::array<LocalLightTotal, kLocalLightKinds> local_lights = {};  // by kind
  double load_seconds = 0, build_seconds = 0;
  std::size_t geometry_bytes = 0, bvh_bytes = 0;  // memory during rendering
};

SceneFile Load(const std::string& path, const ReadOptions& options) {
  SceneFile file;
  const auto start = Clock::now();
  file.scene = ReadScene(path, options);
  file.load_seconds = SecondsSince(start);
  file.summary = Summarize(file.scene);
  if (file.summary.triangles > 0) {
    const Geometry geometry(file.scene, path);
    file.build_seconds = geometry.build_seconds();
    file.bvh_bytes = geometry.bvh_bytes();
    const LocalLights lights(file.scene, geometry, path, BoundingRadius(*file.summary.bounds), 0);
    file.local_lights = lights.totals();
    file.geometry_bytes = geometry.bytes() + lights.bytes();
  }
  return file;
}

std::vector<float> List(const glm::vec3& v) { return {v.x, v.y, v.z}; }
std::string Text(const glm::vec3& v) { return fmt::format("{:.6g} {:.6g} {:.6g}", v.x, v.y, v.z); }

std::string_view KindOf(const Material& material) {
  return material.mixture ? "mixture" : ToString(material.bsdf);
}

// Returns the value of a field of a material, null if it is unset.
template <class T>
nlohmann::ordered_json Value(const T& field) {
  return field;
}
nlohmann::ordered_json Value(const glm::vec3& field) { return List(field); }
nlohmann::ordered_json Value(BsdfKind field) { return ToString(field); }
nlohmann::ordered_json Value(const Mixture& field) { return {field.first, field.second}; }
template <class T>
nlohmann::ordered_json Value(const std::optional<T>& field) {
  return field ? Value(*field) : nullptr;
}

// A parameter of a BSDF in addition to the reflectance, in the order of printing.
struct Parameter {
  std::string name;
  nlohmann::ordered_json value;
};
std::vector<Parameter> ListParameters(Material material) {
  if (material.mixture) {
    if (material.mixture_texture) return {{"mixture", Value(*material.mixture)}};  // by an image
    return {{"mixture", Value(*material.mixture)}, {"share", material.mixture->share}};
  }
  if (!material.alpha_across) material.alpha_across = material.alpha;
  if (!material.reflection) material.reflection = material.reflectance;
  std::vector<Parameter> list;
  for (const MaterialParameter& parameter : ParametersOf(Bsdfs()[std::size_t(material.bsdf)])) {
    Material::ForEachField(material,
                           [&](std::string_view name, MaterialPart part, const auto& field) {
                             if (name != parameter.field || !material.has(part)) return;
                             list.push_back({std::string(parameter.name), Value(field)});
                           });
  }
  return list;
}

nlohmann::ordered_json Json(const Material& material, std::size_t triangles) {
  nlohmann::ordered_json json = {{"name", material.name},
                                 {"bsdf", KindOf(material)},
                                 {"triangles", triangles},
                                 {"reflectance", List(material.reflectance)}};
  for (const Parameter& parameter : ListParameters(material))
    json[parameter.name] = parameter.value;
  Material::ForEachField(material, [&](std::string_view name, MaterialPart part,
                                       const auto& field) {
    const bool printed = part == MaterialPart::kBsdf || part == MaterialPart::kMixture ||
                         part == MaterialPart::kLayers || part == MaterialPart::kReflectionLayers;
    const nlohmann::ordered_json value = Value(field);
    if (!printed && material.has(part) && !value.is_null()) json[std::string(name)] = value;
  });
  return json;
}

nlohmann::ordered_json Json(const EnvironmentLight& light) {
  nlohmann::ordered_json json = {{"kind", "environment"}, {"scale", List(light.scale)}};
  if (light.map) {
    json["map"] = {{"width", light.map->width}, {"height", light.map->height}};
  } else if (!light.map_path.empty()) {
    json["map"] = {{"file", light.map_path}};
  }
  return json;
}

glm::vec3 EyeInWorld(const Camera& camera, const Scene& scene) {
  return scene.origin + glm::dvec3(camera.world_from_camera[3]);
}

nlohmann::ordered_json Json(const Camera& camera, const Scene& scene) {
  nlohmann::ordered_json json = {{"kind", ToString(camera.kind)},
                                 {"eye", List(EyeInWorld(camera, scene))}};
  if (camera.kind == CameraKind::kPerspective) json["fov_degrees"] = camera.fov_degrees;
  if (camera.lens_radius > 0) {
    json["lens_radius"] = camera.lens_radius;
    json["focal_distance"] = camera.focal_distance;
  }
  if (camera.kind == CameraKind::kRealistic) {
    json["lens"] = {{"interfaces", camera.realistic->design.interfaces.size()},
                    {"focal_length", camera.realistic->focal_length},
                    {"film_diagonal", camera.realistic->design.film_diagonal}};
  }
  return json;
}

nlohmann::ordered_json Json(const SceneFile& file) {
  const Scene& scene = file.scene;
  const SceneSummary& summary = file.summary;
  nlohmann::ordered_json json;
  json["schema"] = "skywave-scene-info-1";
  json["version"] = Version();
  json["meshes"] = summary.meshes;
  json["triangles"] = summary.triangles;
  json["vertices"] = summary.vertices;
  json["objects"] = summary.objects;
  json["instances"] = summary.instances;
  json["triangles_with_instances"] = summary.triangles_seen;
  json["meshes_with_normals"] = summary.meshes_with_normals;
  json["meshes_with_uvs"] = summary.meshes_with_uvs;
  if (summary.bounds) {
    const Bounds bounds = BoundsInWorld(scene, *summary.bounds);
    json["bounds"] = {{"low", List(bounds.low)}, {"high", List(bounds.high)}};
  }
  json["left_handed"] = scene.left_handed;
  json["up_axis"] = std::string(1, scene.up_axis);
  json["has_camera"] = scene.camera.has_value();
  if (scene.camera) json["camera"] = Json(*scene.camera, scene);
  json["cameras"] = nlohmann::ordered_json::array();
  for (const NamedCamera& named : scene.cameras) {
    nlohmann::ordered_json camera = {{"name", named.name}};
    camera.update(Json(named.camera, scene));
    json["cameras"].push_back(std::move(camera));
  }
  json["animations"] = nlohmann::ordered_json::array();
  for (const AnimationInfo& animation : scene.animations) {
    json["animations"].push_back({{"name", animation.name},
                                  {"seconds", animation.seconds},
                                  {"channels", animation.channels}});
  }
  json["variants"] = scene.variants;
  json["scenes"] = scene.scenes;
  json["materials"] = nlohmann::ordered_json::array();
  for (std::size_t i = 0; i < scene.materials.size(); ++i) {
    json["materials"].push_back(Json(scene.materials[i], summary.triangles_of_material[i]));
  }
  json["lights"] = nlohmann::ordered_json::array();
  for (const EnvironmentLight& light : scene.environments) json["lights"].push_back(Json(light));
  for (std::uint32_t kind = 0; kind < kLocalLightKinds; ++kind) {
    const LocalLightTotal& total = file.local_lights[kind];
    if (total.count == 0) continue;
    json["lights"].push_back(
        {{"kind", ToString(LocalLightKind(kind))}, {"count", total.count}, {"power", total.power}});
  }
  json["bytes"] = {
      {"meshes", summary.mesh_bytes}, {"geometry", file.geometry_bytes}, {"bvh", file.bvh_bytes}};
  json["seconds"] = {{"load", file.load_seconds}, {"build", file.build_seconds}};
  json["not_supported"] = scene.warnings;
  json["notes"] = scene.notes;
  return json;
}

// Describes the parts that any material may have, except for its emission.
std::string SurfaceMaps(const Material& material) {
  std::string text;
  if (!material.opaque()) {
    text += fmt::format(", {}opacity {:.4g}{}", material.opacity_cutoff ? "masked, " : "",
                        material.opacity, material.opacity_texture ? " * texture" : "");
  }
  if (material.normal_texture) text += ", normal map";
  if (Bsdfs()[std::size_t(material.bsdf)].inside && material.has(MaterialPart::kAbsorption)) {
    text += ", absorption " + Text(material.absorption + 0.0f);  // prints 0 for -0
  }
  return text;
}

std::vector<double> Numbers(const nlohmann::ordered_json& value) {
  return value.is_array() ? value.get<std::vector<double>>()
                          : std::vector<double>{value.get<double>()};
}

std::string Parameters(const Material& material) {
  std::string text = "reflectance " + Text(material.reflectance);
  if (material.color_texture) text += " * texture";
  for (const Parameter& parameter : ListParameters(material)) {
    text += fmt::format(", {} {:.4g}", parameter.name, fmt::join(Numbers(parameter.value), " "));
    const bool varied = parameter.name == "alpha" || (parameter.name == "coat_alpha" &&
                                                      material.bsdf == BsdfKind::kCoatedConductor);
    if (varied && material.roughness_texture) text += " * texture";
  }
  return text;
}

std::string Emission(const Material& material) {
  if (!material.has(MaterialPart::kEmission)) return "";
  return fmt::format(", shines with {}{}", Text(material.emission),
                     material.emission_texture ? " * texture" : "");
}

std::string Describe(const Camera& camera, const Scene& scene) {
  std::string text =
      fmt::format("{} at {}", ToString(camera.kind), Text(EyeInWorld(camera, scene)));
  if (camera.kind == CameraKind::kPerspective) {
    text += fmt::format(", {:.4g} degrees", camera.fov_degrees);
  }
  if (camera.lens_radius > 0) {
    text += fmt::format(", lens of radius {:.4g}, sharp at {:.4g}", camera.lens_radius,
                        camera.focal_distance);
  }
  if (camera.kind == CameraKind::kRealistic) {
    text += fmt::format(", lens of {} interfaces, focal length {:.4g}, film of {:.4g}",
                        camera.realistic->design.interfaces.size(), camera.realistic->focal_length,
                        camera.realistic->design.film_diagonal);
  }
  return text;
}

std::string Describe(const EnvironmentLight& light) {
  const std::string scale = ", scale " + Text(light.scale);
  if (light.map) return fmt::format("map of {} x {}", light.map->width, light.map->height) + scale;
  if (!light.map_path.empty()) return "map " + light.map_path + scale;
  return "constant radiance " + Text(light.scale);
}

void PrintNames(const char* things, const std::vector<std::string>& names) {
  if (!names.empty()) Print(stdout, "\n{} {}\n", names.size(), things);
  for (const std::string& name : names) Print(stdout, "  {}\n", name);
}

void PrintScene(const std::string& path, const SceneFile& file) {
  const Scene& scene = file.scene;
  const SceneSummary& summary = file.summary;
  const auto row = [](const char* name, const std::string& value) {
    Print(stdout, "{:<12}{}\n", name, value);
  };
  row("scene", path);
  row("meshes", fmt::format("{}, {} with normals, {} with texture coordinates", summary.meshes,
                            summary.meshes_with_normals, summary.meshes_with_uvs));
  row("triangles", fmt::format("{}", summary.triangles));
  row("vertices", fmt::format("{}", summary.vertices));
  if (summary.instances > 0) {
    row("instances", fmt::format("{} of {} objects: {} triangles are seen", summary.instances,
                                 summary.objects, summary.triangles_seen));
  }
  if (summary.bounds) {
    const Bounds bounds = BoundsInWorld(scene, *summary.bounds);
    row("bounds", fmt::format("{} to {}", Text(bounds.low), Text(bounds.high)));
    row("size", Text(summary.bounds->high - summary.bounds->low));
  }
  row("world",
      fmt::format("{}-handed, {} up", scene.left_handed ? "left" : "right", scene.up_axis));
  row("camera",
      scene.camera ? Describe(*scene.camera, scene) : "none: one that sees everything is used");
  constexpr double kMib = 1024 * 1024;
  row("memory", fmt::format("{:.2f} MiB as read, {:.2f} MiB to render and {:.2f} MiB of BVH",
                            double(summary.mesh_bytes) / kMib, double(file.geometry_bytes) / kMib,
                            double(file.bvh_bytes) / kMib));
  row("time", fmt::format("load {:.3f} s, build {:.3f} s", file.load_seconds, file.build_seconds));
  if (!scene.cameras.empty()) Print(stdout, "\n{} cameras\n", scene.cameras.size());
  for (const NamedCamera& named : scene.cameras) {
    Print(stdout, "  {:<24}{}\n", named.name, Describe(named.camera, scene));
  }
  if (!scene.animations.empty()) Print(stdout, "\n{} animations\n", scene.animations.size());
  for (const AnimationInfo& animation : scene.animations) {
    Print(stdout, "  {:<24}{:.6g} s, {} channels\n", animation.name, animation.seconds,
          animation.channels);
  }
  PrintNames("variants of materials", scene.variants);
  if (scene.scenes.size() > 1) PrintNames("scenes", scene.scenes);
  Print(stdout, "\n{} materials\n", scene.materials.size());
  for (std::size_t i = 0; i < scene.materials.size(); ++i) {
    const Material& material = scene.materials[i];
    Print(stdout, "  {:<24}{:<12}{:>10}  {}{}{}\n", material.name, KindOf(material),
          summary.triangles_of_material[i], Parameters(material), SurfaceMaps(material),
          Emission(material));
  }
  std::size_t lights = scene.environments.size();
  for (const LocalLightTotal& total : file.local_lights) lights += total.count;
  Print(stdout, "\n{} lights\n", lights);
  for (const EnvironmentLight& light : scene.environments) Print(stdout, "  {}\n", Describe(light));
  for (std::uint32_t kind = 0; kind < kLocalLightKinds; ++kind) {
    const LocalLightTotal& total = file.local_lights[kind];
    if (total.count == 0) continue;
    Print(stdout, "  {:<24}{:>10}  power {:.6g}\n", ToString(LocalLightKind(kind)), total.count,
          total.power);
  }
  if (lights == 0) Print(stdout, "  give an illumination map with --env MAP\n");
  const auto list = [](const char* what, const std::vector<std::string>& remarks) {
    Print(stdout, "\n{} {}\n", remarks.size(), what);
    for (const std::string& remark : remarks) Print(stdout, "  {}\n", remark);
  };
  list("warnings", scene.warnings);
  list("notes", scene.notes);
}

int InfoMain(const InfoFlags& flags) {
  CheckOutputs(std::array{flags.json}, std::array{flags.request.scene});
  const SceneFile file = Load(flags.request.scene, flags.request.read);
  PrintScene(flags.request.scene, file);
  if (!flags.json.empty()) WriteFileAtomically(flags.json, JsonText(Json(file), 2) + "\n");
  return 0;
}

}  // namespace

Command InfoCommand() {
  const auto flags = std::make_shared<InfoFlags>();
  Command command = {.name = "info",
                     .summary = "What is in a scene",
                     .footer = "Example:\n  skywave info model.obj --json model.json",
                     .run = [flags](const GivenOptions&) { return InfoMain(*flags); }};
  const std::shared_ptr<JobRequest> request(flags, &flags->request);
  for (const JobOption& option : JobOptions()) {
    if (option.name == "scene" || option.of_reading) {
      AddOptions(command, std::span(&option, 1), request);
    }
  }
  const auto json = MakeOption<InfoFlags>({.name = "json", .help = "write the same as JSON"},
                                          SKYWAVE_FIELD(json), Texts("JSON"));
  AddOptions(command, std::span(&json, 1), flags);
  return command;
}

}  // namespace skywave
