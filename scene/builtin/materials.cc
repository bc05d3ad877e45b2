// The built-in scene "materials" shows one sphere per BSDF; its materials also cover the objects of
// "many-materials".
#include <utility>

#include "scene/builtin/scene_building.h"
#include "scene/materials/metals.h"
#include "scene/shapes/shapes.h"

namespace skywave {
namespace {

Material Metal(const char* symbol, BsdfKind bsdf, float alpha) {
  const MetalIndex metal = FindMetal(symbol).value();
  return {.name = symbol,
          .bsdf = bsdf,
          .reflectance = glm::vec3(1),
          .eta = metal.eta,
          .k = metal.k,
          .alpha = alpha};
}

}  // namespace

std::vector<Material> OneOfEachBsdf() {
  using enum BsdfKind;
  const glm::vec3 white(1), red(0.6f, 0.12f, 0.08f), blue(0.1f, 0.2f, 0.5f);
  std::vector<Material> list = {
      {.name = "lambert", .reflectance = red},
      {.name = "clay", .bsdf = kOrenNayar, .reflectance = red, .alpha = 1},
      {.name = "paper",
       .bsdf = kDiffuseTransmission,
       .reflectance = {0.4f, 0.4f, 0.35f},
       .second_color = {0.5f, 0.45f, 0.3f}},
      {.name = "phong",
       .bsdf = kPhong,
       .reflectance = blue,
       .alpha = 0.15f,
       .second_color = glm::vec3(0.4f)},
      {.name = "varnish", .bsdf = kMetallicRoughness, .reflectance = blue, .alpha = 0.1f},
      {.name = "lacquer",
       .bsdf = kCoatedMetallicRoughness,
       .reflectance = red,
       .alpha = 0.4f,
       .metallic = 0.6f,
       .coat_alpha = 0.01f},
      {.name = "velvet",
       .bsdf = kCoatedMetallicRoughness,
       .reflectance = {0.1f, 0.02f, 0.15f},
       .alpha = 1,
       .coat = 0,
       .sheen = {0.8f, 0.6f, 0.9f},
       .sheen_alpha = 0.15f},
      Metal("Au", kConductor, 0.2f),
      Metal("Al", kAnisotropicConductor, 0.35f),
      Metal("Cu", kBeckmannConductor, 0.25f),
      Metal("Ag", kBlinn, 0.25f),
      {.name = "satin",
       .bsdf = kWard,
       .reflectance = {0.7f, 0.6f, 0.4f},
       .alpha = 0.08f,
       .alpha_across = 0.3f},
      Metal("Cu", kCoatedConductor, 0.35f),
      {.name = "mirror", .bsdf = kMirror, .reflectance = glm::vec3(0.95f)},
      {.name = "glass", .bsdf = kDielectric, .reflectance = white},
      {.name = "frosted glass", .bsdf = kRoughDielectric, .reflectance = white, .alpha = 0.15f},
      {.name = "soap bubble", .bsdf = kThinDielectric, .reflectance = white},
      {.name = "enamel", .bsdf = kCoatedDiffuse, .reflectance = {0.1f, 0.3f, 0.7f}, .alpha = 0.05f},
  };
  list[8].alpha_across = 0.05f;
  return list;
}

Scene MaterialsScene() {
  constexpr int kColumns = 6;
  Scene scene;
  Place(scene, Quad(200), AddLambert(scene, "floor", glm::vec3(0.4f)), glm::vec3(0));
  const auto first = std::uint32_t(scene.materials.size());
  for (Material& material : OneOfEachBsdf()) scene.materials.push_back(std::move(material));
  // This one looks like rust on gold.
  scene.materials.push_back({.name = "mixture", .mixture = Mixture{first + 7, first + 1, 0.5f}});
  for (std::uint32_t m = first; m < scene.materials.size(); ++m) {
    const int place = int(m - first), column = place % kColumns, row = place / kColumns;
    Place(scene, Sphere(0.45f, 24), m, {1.1f * (float(column) - 2.5f), 0.45f, 1.25f * (1 - row)});
  }
  AddProceduralSky(scene);
  scene.camera = LookAtCamera({0, 6.2f, 6.6f}, {0, 0.3f, 0.1f}, {0, 1, 0}, 36, false);
  scene.settings = BuiltinSettings(64, 12);
  return scene;
}

}  // namespace skywave
