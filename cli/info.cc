// skywave info: what is in a scene.
#include <fmt/format.h>

#include <chrono>
#include <memory>
#include <nlohmann/json.hpp>

#include "base/files.h"
#include "cli/commands.h"
#include "scene/geometry.h"
#include "scene/reader.h"
#include "scene/scene_summary.h"
#include "wavefront/job.h"

namespace skywave {
namespace {

struct InfoFlags {
  std::string scene, json;
};

struct SceneFile {
  Scene scene;
  SceneSummary summary;
  double load_seconds = 0, build_seconds = 0;
  std::size_t geometry_bytes = 0, bvh_bytes = 0;  // what rendering keeps
};

SceneFile Load(const std::string& path) {
  SceneFile file;
  const auto start = std::chrono::steady_clock::now();
  file.scene = ReadScene(path);
  file.load_seconds =
      std::chrono::duration<double>(std::chrono::steady_clock::now() - start).count();
  file.summary = Summarize(file.scene);
  if (file.summary.triangles > 0) {
    const Geometry geometry(file.scene, path);
    file.build_seconds = geometry.build_seconds();
    file.geometry_bytes = geometry.bytes();
    file.bvh_bytes = geometry.bvh_bytes();
  }
  return file;
}

std::vector<float> List(const glm::vec3& v) { return {v.x, v.y, v.z}; }
std::string Text(const glm::vec3& v) { return fmt::format("{:.6g} {:.6g} {:.6g}", v.x, v.y, v.z); }

nlohmann::ordered_json Json(const Material& material, std::size_t triangles) {
  nlohmann::ordered_json json = {{"name", material.name},
                                 {"bsdf", ToString(material.bsdf)},
                                 {"triangles", triangles},
                                 {"reflectance", List(material.reflectance)}};
  if (material.bsdf == BsdfKind::kConductor) {
    json["alpha"] = material.alpha;
    json["eta"] = List(material.eta);
    json["k"] = List(material.k);
  }
  if (material.bsdf == BsdfKind::kMetallicRoughness) {
    json["alpha"] = material.alpha;
    json["metallic"] = material.metallic;
    json["ior"] = material.ior;
  }
  if (material.color_texture) json["color_texture"] = *material.color_texture;
  if (material.roughness_texture) json["roughness_texture"] = *material.roughness_texture;
  if (material.bsdf == BsdfKind::kDielectric) json["ior"] = material.ior;
  if (!material.opaque()) {
    json["opacity"] = material.opacity;
    if (material.opacity_cutoff) json["opacity_cutoff"] = *material.opacity_cutoff;
    if (material.opacity_texture) json["opacity_texture"] = *material.opacity_texture;
  }
  if (material.normal_texture) json["normal_texture"] = *material.normal_texture;
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
  json["bytes"] = {
      {"meshes", summary.mesh_bytes}, {"geometry", file.geometry_bytes}, {"bvh", file.bvh_bytes}};
  json["seconds"] = {{"load", file.load_seconds}, {"build", file.build_seconds}};
  json["not_supported"] = scene.warnings;
  return json;
}

// What any material may have besides.
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
  switch (material.bsdf) {
    case BsdfKind::kLambert:
    case BsdfKind::kMirror:
      return "reflectance " + Text(material.reflectance);
    case BsdfKind::kConductor:
      return fmt::format("alpha {:.4g}, eta {}, k {}", material.alpha, Text(material.eta),
                         Text(material.k));
    case BsdfKind::kMetallicRoughness:
      return fmt::format("base colour {}{}, metallic {:.4g}, alpha {:.4g}{}, ior {:.4g}",
                         Text(material.reflectance), material.color_texture ? " * texture" : "",
                         material.metallic, material.alpha,
                         material.roughness_texture ? " * texture" : "", material.ior);
    case BsdfKind::kDielectric:
      return fmt::format("ior {:.4g}", material.ior);
  }
  return "";
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
    fmt::print("  {:<24}{:<12}{:>10}  {}\n", material.name, ToString(material.bsdf),
               summary.triangles_of_material[i], Parameters(material) + SurfaceMaps(material));
  }
  fmt::print("\n{} lights\n", scene.environments.size());
  for (const EnvironmentLight& light : scene.environments) fmt::print("  {}\n", Describe(light));
  if (scene.environments.empty()) fmt::print("  give an illumination map with --env MAP\n");
  fmt::print("\n{} remarks\n", scene.warnings.size());
  for (const std::string& warning : scene.warnings) fmt::print("  {}\n", warning);
}

int InfoMain(const InfoFlags& flags) {
  if (!flags.json.empty()) CheckWritable(flags.json);
  const SceneFile file = Load(flags.scene);
  Print(flags.scene, file);
  if (!flags.json.empty()) WriteFileAtomically(flags.json, Json(file).dump(2) + "\n");
  return 0;
}

}  // namespace

void AddInfoCommand(CLI::App& program, Run& run) {
  CLI::App* command = program.add_subcommand("info", "What is in a scene");
  const auto flags = std::make_shared<InfoFlags>();
  command->add_option("scene", flags->scene, "pbrt, OBJ or PLY file, or a built-in scene")
      ->required();
  command->add_option("--json", flags->json, "write the same as JSON");
  command->footer("Example:\n  skywave info model.obj --json model.json");
  command->callback([flags, &run] { run = [flags] { return InfoMain(*flags); }; });
}

}  // namespace skywave
