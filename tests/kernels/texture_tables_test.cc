// Tests the tables of textures that kernels read: coordinates, colours and images of a scene.
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <iterator>

#include "base/error.h"
#include "kernels/surface/texture.h"
#include "scene/builtin/scene_building.h"
#include "scene/geometry.h"
#include "scene/materials/texture_tables.h"
#include "scene/shapes/shapes.h"

namespace skywave {
namespace {

// Vertex colours follow the order of corners in the record, also if that is reversed; meshes
// without colours are white.
TEST(TextureTables, ColoursOfVerticesGoWithTheirCorners) {
  Scene scene;
  Mesh mesh = Quad(1);
  for (std::size_t i = 0; i < mesh.positions.size(); ++i) {
    mesh.colors.push_back(glm::vec3(0.25f * float(i), 0, 1));
  }
  for (glm::uvec3& t : mesh.triangles) std::swap(t.y, t.z);
  const std::uint32_t floor = AddLambert(scene, "floor", glm::vec3(1));
  Place(scene, Quad(1), floor, glm::vec3(3));
  EXPECT_EQ(Geometry(scene, "test").vertex_colors(), nullptr);
  Place(scene, mesh, floor, glm::vec3(0));
  const Geometry geometry(scene, "test");
  const float white[3] = {1, 1, 1};
  for (int i = 0; i < 6; ++i) EXPECT_EQ(geometry.vertex_colors()[i], PackTexel(white));
  for (std::size_t t = 0; t < 2; ++t) {
    const glm::uvec3& wound = mesh.triangles[t];
    const std::uint32_t corners[3] = {wound.x, wound.z, wound.y};
    for (std::size_t i = 0; i < 3; ++i) {
      EXPECT_EQ(geometry.vertex_colors()[6 + 3 * t + i], PackTexel(&mesh.colors[corners[i]].x));
    }
  }
  scene.meshes[1].colors.pop_back();
  EXPECT_THROW(Geometry(scene, "test"), InputError);
}

TEST(TextureTables, TrianglesThatAreTurnedTakeTheirCoordinatesAlong) {
  Scene scene;
  scene.images.push_back(Image(1, 1));
  scene.textures = {{}};
  Mesh mesh = Quad(1);
  // The winding opposes the normals, as in a mirrored instance.
  for (glm::uvec3& t : mesh.triangles) std::swap(t.y, t.z);
  Place(scene, mesh, AddLambert(scene, "floor", glm::vec3(1)), glm::vec3(0));
  EXPECT_TRUE(Geometry(scene, "test").textures().empty());
  scene.materials[0].color_texture = 0;
  const Geometry geometry(scene, "test");
  const TextureView view = geometry.textures();
  ASSERT_FALSE(view.empty());
  for (std::size_t t = 0; t < 2; ++t) {
    const glm::uvec3& wound = scene.meshes[0].triangles[t];
    const std::uint32_t corners[3] = {wound.x, wound.z, wound.y};
    for (int i = 0; i < 3; ++i) {
      EXPECT_EQ(view.uvs[t].uv[i][0], mesh.uvs[corners[i]].x);
      EXPECT_EQ(view.uvs[t].uv[i][1], mesh.uvs[corners[i]].y);
    }
    EXPECT_NEAR(view.uvs[t].density, 0.5, 1e-6);  // a length of 2 in the world is one unit of uv
  }
}

// A texture of the second coordinates finds them at its own rows of the table; triangles of
// mixtures, which have records of their own, have both, too.
TEST(TextureTables, TexturesTakeTheCoordinatesOfTheirSet) {
  Scene scene;
  scene.images.push_back(Image(1, 1));
  scene.textures = {{}, {.uv_set = UvSet::kSecond}};
  Mesh mesh = Quad(1);
  for (const glm::vec2& uv : mesh.uvs) mesh.second_uvs.push_back(2.0f * uv + 0.25f);
  const std::uint32_t red = AddLambert(scene, "red", glm::vec3(1, 0, 0));
  const std::uint32_t blue = AddLambert(scene, "blue", glm::vec3(0, 0, 1));
  scene.materials[red].color_texture = 0, scene.materials[blue].color_texture = 1;
  scene.materials.push_back({.name = "both", .mixture = Mixture{red, blue, 0.5f}});
  Place(scene, mesh, 2, glm::vec3(0));
  const Geometry geometry(scene, "test");
  const TextureView view = geometry.textures();
  ASSERT_TRUE(view.two_uv_sets);
  for (std::size_t record = 0; record < 6; ++record) {
    const std::size_t triangle = record < 2 ? record : (record - 2) / 2;
    for (int i = 0; i < 3; ++i) {
      const glm::vec2 uv = mesh.uvs[mesh.triangles[triangle][i]];
      for (const std::uint32_t texture : {0u, 1u}) {
        const TriangleUvs& uvs = view.uvs[view.records[texture].first_uvs + record];
        const glm::vec2 expected = texture == 0 ? uv : 2.0f * uv + 0.25f;
        EXPECT_EQ(glm::vec2(uvs.uv[i][0], uvs.uv[i][1]), expected) << record << texture;
      }
    }
  }
  scene.textures[1].uv_set = UvSet::kFirst;
  EXPECT_FALSE(Geometry(scene, "test").textures().two_uv_sets);
}

TEST(TextureTables, MissingImagesAndBadTransformsAreRefused) {
  Scene scene;
  Place(scene, Quad(1), AddLambert(scene, "floor", glm::vec3(1)), glm::vec3(0));
  scene.materials[0].color_texture = 0;
  EXPECT_THROW(Geometry(scene, "test"), InputError);
  scene.textures = {{.image = 0}};
  EXPECT_THROW(Geometry(scene, "test"), InputError);
  scene.images.push_back(Image(2, 2));
  EXPECT_NO_THROW(Geometry(scene, "test"));
  scene.textures[0].transform[2][0] = NAN;
  EXPECT_THROW(Geometry(scene, "test"), InputError);
  scene.textures[0].transform[2][0] = 0;
  scene.meshes[0].uvs.pop_back();
  EXPECT_THROW(Geometry(scene, "test"), InputError);
  scene.meshes[0].uvs.clear();
  EXPECT_NO_THROW(Geometry(scene, "test"));
}

}  // namespace
}  // namespace skywave
