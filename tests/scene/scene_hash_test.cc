// Tests the hash of a scene: every field of a material counts, and hashes remain stable.

#include "scene/scene_hash.h"

#include <gtest/gtest.h>

#include <optional>
#include <set>
#include <string_view>

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

TEST(SceneHash, TellsEveryFieldOfAMaterial) {
  const Material base = MaterialOfAllParts(BsdfKind::kConductor);
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

TEST(SceneHash, TellsWhetherATextureHasLevels) {
  Texture texture;
  const std::uint64_t hash = SceneHash({.textures = {texture}});
  texture.one_level = true;
  EXPECT_NE(SceneHash({.textures = {texture}}), hash);
}

TEST(SceneHash, DoesNotKnowNames) {
  Material material = MaterialOfAllParts(BsdfKind::kConductor);
  const std::uint64_t hash = HashOf(material);
  material.name = "other";
  EXPECT_EQ(HashOf(material), hash);
}

// Pictures carry hashes in their files, so those of existing scenes must not change.
TEST(SceneHash, StaysWhatItWas) {
  EXPECT_EQ(HashOf({}), 0x6261c5dbb102e218u);
  Material conductor = MaterialOfAllParts(BsdfKind::kConductor);
  // These are younger than the hashes, and materials do not have them unless they are asked for.
  conductor.coat_thickness = 0;
  conductor.mixture_texture.reset();
  conductor.second_color_texture.reset();
  EXPECT_EQ(HashOf(conductor), 0x3029de41f722c611u);
}

}  // namespace
}  // namespace skywave
