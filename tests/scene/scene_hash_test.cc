// Tests the hash of a scene: every field of a material counts, and hashes remain stable.

#include "scene/scene_hash.h"

#include <gtest/gtest.h>

#include <optional>
#include <set>
#include <string_view>
#include <utility>

#include "tests/support/changed_field.h"

namespace skywave {
namespace {

std::uint64_t HashOf(const Material& material) { return SceneHash({.materials = {material}}); }

template <class T>
bool Unset(T&) {
  return false;
}
template <class T>
bool Unset(std::optional<T>& field) {
  field.reset();
  return true;
}

TEST(SceneHash, DependsOnEveryFieldOfAMaterial) {
  const Material base = MaterialOfAllParts(BsdfKind::kLayeredMetallicRoughness);
  std::set<std::uint64_t> hashes = {HashOf(base)};
  Material changed = base;
  Material::ForEachField(changed, [&](std::string_view name, MaterialPart, auto& field) {
    changed = base;
    ChangeField(field);
    EXPECT_TRUE(hashes.insert(HashOf(changed)).second) << name;
    changed = base;
    if (!Unset(field)) return;
    EXPECT_TRUE(hashes.insert(HashOf(changed)).second) << name << " unset";
  });
}

// Films of parts are added by the hash of their scene, so that all that is seen has to count.
TEST(SceneHash, DependsOnEveryVisibleNumber) {
  Mesh mesh;
  mesh.positions = {{0, 0, 0}, {1, 0, 0}, {0, 1, 0}};
  mesh.normals.assign(3, {0, 0, 1});
  mesh.uvs.assign(3, {0, 0});
  mesh.second_uvs.assign(3, {0, 0});
  mesh.tangents.assign(3, {1, 0, 0, 1});
  mesh.colors.assign(3, glm::vec3(1));
  mesh.alphas.assign(3, 1.0f);
  mesh.triangles = {{0, 1, 2}};
  Scene base;
  base.meshes = {mesh};
  base.objects = {{.name = "o", .meshes = {mesh}}};
  base.instances = {{}};
  base.materials.resize(2);
  base.measured = {{.rgb = {1, 2, 3}}};
  base.images.assign(2, Image(2, 2));
  base.textures.resize(1);
  base.camera = Camera{.window = ScreenWindow{}};
  base.environments = {{.map = Image(2, 1)}};
  base.lights = {{.kind = LocalLightKind::kShaped, .form = LightForm{.image = 0}}};

  using Change = void (*)(Scene&);
  const std::pair<const char*, Change> changes[] = {
      {"position", [](Scene& s) { s.meshes[0].positions[1].z = 1; }},
      {"normal", [](Scene& s) { s.meshes[0].normals[1].z = -1; }},
      {"uv", [](Scene& s) { s.meshes[0].uvs[1].y = 1; }},
      {"second uv", [](Scene& s) { s.meshes[0].second_uvs[1].y = 1; }},
      {"tangent", [](Scene& s) { s.meshes[0].tangents[1].w = -1; }},
      {"colour of a vertex", [](Scene& s) { s.meshes[0].colors[1].y = 0; }},
      {"alpha of a vertex", [](Scene& s) { s.meshes[0].alphas[1] = 0; }},
      {"triangle",
       [](Scene& s) {
         s.meshes[0].triangles[0] = {0, 2, 1};
       }},
      {"material", [](Scene& s) { s.meshes[0].material = 1; }},
      {"mesh of an object", [](Scene& s) { s.objects[0].meshes[0].positions[1].z = 1; }},
      {"object", [](Scene& s) { s.instances[0].object = 1; }},
      {"place of an instance", [](Scene& s) { s.instances[0].world_from_object[3].y = 1; }},
      {"measured BRDF", [](Scene& s) { s.measured[0].rgb[1] = 3; }},
      {"image",
       [](Scene& s) {
         Image image = s.images[0].Floats();
         image.rgb[5] = 1;
         s.images[0] = image;
       }},
      {"image of a texture", [](Scene& s) { s.textures[0].image = 1; }},
      {"wrap along u", [](Scene& s) { s.textures[0].wrap_u = TextureWrap::kClamp; }},
      {"wrap along v", [](Scene& s) { s.textures[0].wrap_v = TextureWrap::kClamp; }},
      {"transform of a texture", [](Scene& s) { s.textures[0].transform[2].y = 1; }},
      {"use of a texture", [](Scene& s) { s.textures[0].use = TextureUse::kHeights; }},
      {"coordinates of a texture", [](Scene& s) { s.textures[0].uv_set = UvSet::kSecond; }},
      {"kind of camera", [](Scene& s) { s.camera->kind = CameraKind::kFisheye; }},
      {"place of the camera", [](Scene& s) { s.camera->world_from_camera[3].y = 1; }},
      {"angle", [](Scene& s) { s.camera->fov_degrees = 46; }},
      {"window", [](Scene& s) { s.camera->window->top = 2; }},
      {"no window", [](Scene& s) { s.camera->window.reset(); }},
      {"lens", [](Scene& s) { s.camera->lens_radius = 1; }},
      {"focal distance", [](Scene& s) { s.camera->focal_distance = 1; }},
      {"map", [](Scene& s) { s.environments[0].map->rgb[4] = 1; }},
      {"scale of the map", [](Scene& s) { s.environments[0].scale.y = 2; }},
      {"turn of the map", [](Scene& s) { s.environments[0].world_from_map[2].x = 1; }},
      {"kind of light", [](Scene& s) { s.lights[0].kind = LocalLightKind::kSpot; }},
      {"emission", [](Scene& s) { s.lights[0].emission.y = 1; }},
      {"place of a light", [](Scene& s) { s.lights[0].position.y = 1; }},
      {"direction", [](Scene& s) { s.lights[0].direction.y = 1; }},
      {"inner cone", [](Scene& s) { s.lights[0].cos_full = 0.5f; }},
      {"curve of spot", [](Scene& s) { s.lights[0].curve = SpotCurve::kSquare; }},
      {"outer cone", [](Scene& s) { s.lights[0].cos_dark = 0.5f; }},
      {"form", [](Scene& s) { s.lights[0].form->mapping = LightMapping::kPlane; }},
      {"turn of the form", [](Scene& s) { s.lights[0].form->world_from_light[1].x = 1; }},
      {"image of the form", [](Scene& s) { s.lights[0].form->image = 1; }},
      {"size of the form", [](Scene& s) { s.lights[0].form->half_size.y = 2; }}};
  std::set<std::uint64_t> hashes = {SceneHash(base)};
  for (const auto& [name, change] : changes) {
    Scene changed = base;
    change(changed);
    EXPECT_TRUE(hashes.insert(SceneHash(changed)).second) << name;
  }
}

TEST(SceneHash, DependsOnWhetherATextureHasLevels) {
  Texture texture;
  const std::uint64_t hash = SceneHash({.textures = {texture}});
  texture.one_level = true;
  EXPECT_NE(SceneHash({.textures = {texture}}), hash);
}

TEST(SceneHash, OfAnImageIsThatOfItsFloatsWhicheverFormItHas) {
  Scene bytes, floats;
  bytes.images = {CompactImage(2, 1, {0, 50, 255, 128, 7, 9}, Encoding::kSrgb)};
  floats.images = {bytes.images[0].Floats()};
  EXPECT_EQ(SceneHash(bytes), SceneHash(floats));
  bytes.images = {CompactImage(2, 1, {0, 50, 255, 128, 7, 9}, Encoding::kLinear)};
  EXPECT_NE(SceneHash(bytes), SceneHash(floats));
}

TEST(SceneHash, DoesNotDependOnNames) {
  Material material = MaterialOfAllParts(BsdfKind::kConductor);
  const std::uint64_t hash = HashOf(material);
  material.name = "other";
  EXPECT_EQ(HashOf(material), hash);
}

// Pictures carry hashes in their files, so those of existing scenes must not change.
TEST(SceneHash, MatchesRecordedValues) {
  EXPECT_EQ(HashOf({}), 0x6261c5dbb102e218u);
  Material conductor = MaterialOfAllParts(BsdfKind::kConductor);
  // These are younger than the hashes, and materials do not have them unless they are asked for.
  conductor.coat_thickness = 0;
  conductor.mixture_texture.reset();
  conductor.second_color_texture.reset();
  conductor.reflection.reset();
  conductor.own_base_normals = false;
  conductor.film = 0, conductor.specular_texture.reset();
  conductor.specular_color_texture.reset();
  EXPECT_EQ(HashOf(conductor), 0x3029de41f722c611u);
}

}  // namespace
}  // namespace skywave
