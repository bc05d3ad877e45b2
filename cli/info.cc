// Implements skywave info: the contents of a scene.
#include <fmt/format.h>
#include <fmt/ranges.h>

#include <array>
#include <memory>
#include <nlohmann/json.hpp>
#include <span>

#include "base/clock.h"
#include "base/files.h"
#include "cli/commands.h"
#include "job/options.h"
#include "scene/geometry.h"
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

// A parameter of a BSDF in addition to the reflectance, in the order of printing.
struct Parameter {
  const char* name;
  std::vector<float> values;
};
std::vector<Parameter> ParametersOf(const Material& m) {
  const Parameter alpha = {"alpha", {m.alpha}}, ior = {"ior", {m.ior}};
  const Parameter eta = {"eta", List(m.eta)}, k = {"k", List(m.k)};
  const Parameter across = {"alpha_across", {m.alpha_across.value_or(m.alpha)}};
  const Parameter metallic = {"metallic", {m.metallic}};
  const Parameter coat = {"coat", {m.coat}}, coat_alpha = {"coat_alpha", {m.coat_alpha}};
  if (m.mixture) {
    return {{"mixture", {float(m.mixture->first), float(m.mixture->second)}},
            {"share", {m.mixture->share}}};
  }
  switch (m.bsdf) {
    case BsdfKind::kLambert:
    case BsdfKind::kMirror:
    case BsdfKind::kMeasured:
      return {};
    case BsdfKind::kConductor:
    case BsdfKind::kBlinn:
      return {alpha, eta, k};
    case BsdfKind::kAnisotropicConductor:
    case BsdfKind::kBeckmannConductor:
      return {alpha, across, eta, k};
    case BsdfKind::kCoatedConductor:
      return {alpha, eta, k, coat_alpha, ior};
    case BsdfKind::kMetallicRoughness:
      return {alpha, metallic, ior};
    case BsdfKind::kCoatedMetallicRoughness:
      return {alpha,
              metallic,
              ior,
              coat,
              coat_alpha,
              {"sheen", List(m.sheen)},
              {"sheen_alpha", {m.sheen_alpha}}};
    case BsdfKind::kOrenNayar:
      return {alpha};
    case BsdfKind::kDiffuseTransmission:
      return {{"transmittance", List(m.second_color)}};
    case BsdfKind::kPhong:
      return {alpha, {"gloss", List(m.second_color)}};
    case BsdfKind::kWard:
      return {alpha, across};
    case BsdfKind::kRoughDielectric:
      return {alpha, ior};
    case BsdfKind::kDielectric:
    case BsdfKind::kThinDielectric:
      return {ior};
  }
  return {};
}

nlohmann::ordered_json Json(const Material& material, std::size_t triangles) {
  nlohmann::ordered_json json = {{"name", material.name},
                                 {"bsdf", KindOf(material)},
                                 {"triangles", triangles},
                                 {"reflectance", List(material.reflectance)}};
  for (const Parameter& parameter : ParametersOf(material)) {
    if (parameter.values.size() == 1) {
      json[parameter.name] = parameter.values[0];
    } else {
      json[parameter.name] = parameter.values;
    }
  }
  if (material.color_texture) json["color_texture"] = *material.color_texture;
  if (material.roughness_texture) json["roughness_texture"] = *material.roughness_texture;
  if (!material.opaque()) {
    json["opacity"] = material.opacity;
    if (material.opacity_cutoff) json["opacity_cutoff"] = *material.opacity_cutoff;
    if (material.opacity_texture) json["opacity_texture"] = *material.opacity_texture;
  }
  if (material.normal_texture) json["normal_texture"] = *material.normal_texture;
  if (material.emission != glm::vec3(0)) json["emission"] = List(material.emission);
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

nlohmann::ordered_json Json(const Camera& camera) {
  nlohmann::ordered_json json = {{"kind", ToString(camera.kind)},
                                 {"eye", List(glm::vec3(camera.world_from_camera[3]))}};
  if (camera.kind == CameraKind::kPerspective) json["fov_degrees"] = camera.fov_degrees;
  if (camera.lens_radius > 0) {
    json["lens_radius"] = camera.lens_radius;
    json["focal_distance"] = camera.focal_distance;
  }
  return json;
}

nlohmann::ordered_json Json(const SceneFile& file) {
  const Scene& scene = file.scene;
  const SceneSummary& summary = file.summary;
  nlohmann::ordered_json json;
  json["schema"] = "skywave-scene-info-1";
  json["version"] = SKYWAVE_VERSION;
  json["meshes"] = summary.meshes;
  json["triangles"] = summary.triangles;
  json["vertices"] = summary.vertices;
  json["meshes_with_normals"] = summary.meshes_with_normals;
  json["meshes_with_uvs"] = summary.meshes_with_uvs;
  if (summary.bounds) {
    json["bounds"] = {{"low", List(summary.bounds->low)}, {"high", List(summary.bounds->high)}};
  }
  json["left_handed"] = scene.left_handed;
  json["up_axis"] = std::string(1, scene.up_axis);
  json["has_camera"] = scene.camera.has_value();
  if (scene.camera) json["camera"] = Json(*scene.camera);
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
  return json;
}

// Describes maps and other properties that any material may have.
std::string SurfaceMaps(const Material& material) {
  std::string text;
  if (!material.opaque()) {
    text += fmt::format(", {}opacity {:.4g}{}", material.opacity_cutoff ? "masked, " : "",
                        material.opacity, material.opacity_texture ? " * texture" : "");
  }
  if (material.normal_texture) text += ", normal map";
  return text;
}

std::string Parameters(const Material& material) {
  std::string text = "reflectance " + Text(material.reflectance);
  if (material.color_texture) text += " * texture";
  for (const Parameter& parameter : ParametersOf(material)) {
    text += fmt::format(", {} {:.4g}", parameter.name, fmt::join(parameter.values, " "));
    const bool textured = std::string_view(parameter.name) == "alpha" && material.roughness_texture;
    if (textured) text += " * texture";
  }
  return text;
}

std::string Emission(const Material& material) {
  if (material.emission == glm::vec3(0)) return "";
  return fmt::format(", shines with {}{}", Text(material.emission),
                     material.emission_texture ? " * texture" : "");
}

std::string Describe(const Camera& camera) {
  std::string text =
      fmt::format("{} at {}", ToString(camera.kind), Text(glm::vec3(camera.world_from_camera[3])));
  if (camera.kind == CameraKind::kPerspective) {
    text += fmt::format(", {:.4g} degrees", camera.fov_degrees);
  }
  if (camera.lens_radius > 0) {
    text += fmt::format(", lens of radius {:.4g}, sharp at {:.4g}", camera.lens_radius,
                        camera.focal_distance);
  }
  return text;
}

std::string Describe(const EnvironmentLight& light) {
  const std::string scale = ", scale " + Text(light.scale);
  if (light.map) return fmt::format("map of {} x {}", light.map->width, light.map->height) + scale;
  if (!light.map_path.empty()) return "map " + light.map_path + scale;
  return "constant radiance " + Text(light.scale);
}

void Print(const std::string& path, const SceneFile& file) {
  const Scene& scene = file.scene;
  const SceneSummary& summary = file.summary;
  const auto row = [](const char* name, const std::string& value) {
    fmt::print("{:<12}{}\n", name, value);
  };
  row("scene", path);
  row("meshes", fmt::format("{}, {} with normals, {} with texture coordinates", summary.meshes,
                            summary.meshes_with_normals, summary.meshes_with_uvs));
  row("triangles", fmt::format("{}", summary.triangles));
  row("vertices", fmt::format("{}", summary.vertices));
  if (summary.bounds) {
    row("bounds", fmt::format("{} to {}", Text(summary.bounds->low), Text(summary.bounds->high)));
    row("size", Text(summary.bounds->high - summary.bounds->low));
  }
  row("world",
      fmt::format("{}-handed, {} up", scene.left_handed ? "left" : "right", scene.up_axis));
  row("camera", scene.camera ? Describe(*scene.camera) : "none: one that sees everything is used");
  constexpr double kMib = 1024 * 1024;
  row("memory", fmt::format("{:.2f} MiB as read, {:.2f} MiB to render and {:.2f} MiB of BVH",
                            double(summary.mesh_bytes) / kMib, double(file.geometry_bytes) / kMib,
                            double(file.bvh_bytes) / kMib));
  row("time", fmt::format("load {:.3f} s, build {:.3f} s", file.load_seconds, file.build_seconds));
  fmt::print("\n{} materials\n", scene.materials.size());
  for (std::size_t i = 0; i < scene.materials.size(); ++i) {
    const Material& material = scene.materials[i];
    fmt::print("  {:<24}{:<12}{:>10}  {}{}{}\n", material.name, KindOf(material),
               summary.triangles_of_material[i], Parameters(material), SurfaceMaps(material),
               Emission(material));
  }
  std::size_t lights = scene.environments.size();
  for (const LocalLightTotal& total : file.local_lights) lights += total.count;
  fmt::print("\n{} lights\n", lights);
  for (const EnvironmentLight& light : scene.environments) fmt::print("  {}\n", Describe(light));
  for (std::uint32_t kind = 0; kind < kLocalLightKinds; ++kind) {
    const LocalLightTotal& total = file.local_lights[kind];
    if (total.count == 0) continue;
    fmt::print("  {:<24}{:>10}  power {:.6g}\n", ToString(LocalLightKind(kind)), total.count,
               total.power);
  }
  if (lights == 0) fmt::print("  give an illumination map with --env MAP\n");
  fmt::print("\n{} remarks\n", scene.warnings.size());
  for (const std::string& warning : scene.warnings) fmt::print("  {}\n", warning);
}

int InfoMain(const InfoFlags& flags) {
  if (!flags.json.empty()) CheckWritable(flags.json);
  const SceneFile file = Load(flags.request.scene, flags.request.read);
  Print(flags.request.scene, file);
  if (!flags.json.empty()) WriteFileAtomically(flags.json, Json(file).dump(2) + "\n");
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
    if (option.name == "scene" || IsReadOption(option)) {
      AddOptions(command, std::span(&option, 1), request);
    }
  }
  const auto json = MakeOption<InfoFlags>({.name = "json", .help = "write the same as JSON"},
                                          SKYWAVE_FIELD(json), Texts("JSON"));
  AddOptions(command, std::span(&json, 1), flags);
  return command;
}

}  // namespace skywave
