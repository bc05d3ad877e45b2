#include "scene/builtin/scene_building.h"

#include <glm/gtc/matrix_transform.hpp>
#include <utility>

#include "scene/builtin/procedural_sky.h"
#include "scene/materials/metals.h"
#include "scene/shapes/mesh.h"

namespace skywave {
namespace {

std::uint32_t AddMaterial(Scene& scene, Material material) {
  scene.materials.push_back(std::move(material));
  return static_cast<std::uint32_t>(scene.materials.size() - 1);
}

}  // namespace

std::uint32_t AddLambert(Scene& scene, const std::string& name, const glm::vec3& reflectance) {
  return AddMaterial(scene, {.name = name, .reflectance = reflectance});
}

std::uint32_t AddMetal(Scene& scene, const std::string& symbol, float alpha) {
  const MetalIndex metal = FindMetal(symbol).value();
  return AddMaterial(scene, {.name = symbol,
                             .bsdf = BsdfKind::kConductor,
                             .reflectance = glm::vec3(1),
                             .eta = metal.eta,
                             .k = metal.k,
                             .alpha = alpha});
}

std::uint32_t AddMirror(Scene& scene, float reflectance) {
  return AddMaterial(
      scene, {.name = "mirror", .bsdf = BsdfKind::kMirror, .reflectance = glm::vec3(reflectance)});
}

std::uint32_t AddGlass(Scene& scene, float ior) {
  return AddMaterial(
      scene,
      {.name = "glass", .bsdf = BsdfKind::kDielectric, .reflectance = glm::vec3(1), .ior = ior});
}

void Place(Scene& scene, Mesh mesh, std::uint32_t material, const glm::vec3& position,
           float turn_degrees) {
  const glm::dmat4 moved = glm::translate(glm::dmat4(1), glm::dvec3(position));
  TransformMesh(glm::rotate(moved, glm::radians(double(turn_degrees)), glm::dvec3(0, 1, 0)), mesh);
  mesh.material = material;
  if (mesh.name.empty()) mesh.name = scene.materials[material].name;
  scene.meshes.push_back(std::move(mesh));
}

void AddProceduralSky(Scene& scene) {
  EnvironmentLight light;
  light.map = MakeProceduralSky({});
  light.world_from_map = EnvironmentFrame('y', false, 0);
  scene.environments.push_back(std::move(light));
}

RenderSettings BuiltinSettings(int samples_per_pixel, int max_depth) {
  return {.width = 640,
          .height = 480,
          .samples_per_pixel = samples_per_pixel,
          .max_depth = max_depth,
          .integrator = "path"};
}

}  // namespace skywave
