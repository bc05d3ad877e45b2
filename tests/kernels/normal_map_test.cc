// Tests normal maps: a constant map gives a tilted normal, whatever the mesh, its side and its
// coordinates.
#include "kernels/surface/normal_map.h"

#include <gtest/gtest.h>

#include <cmath>
#define GLM_ENABLE_EXPERIMENTAL
#include <glm/gtc/matrix_transform.hpp>
#include <glm/gtx/string_cast.hpp>

#include "kernels/surface/surface.h"
#include "scene/geometry.h"
#include "scene/materials/texture_tables.h"
#include "scene/pbrt/reader.h"
#include "scene/shapes/mesh.h"
#include "tests/support/bent_normal.h"
#include "tests/support/random_rows.h"
#include "tests/support/screens_scene.h"
#include "tests/support/targets.h"
#include "tests/support/temporary_folder.h"
#include "wavefront/soa.h"

namespace skywave {
namespace {

glm::vec3 Unpacked(std::uint32_t packed) {
  return {float(packed & 2047) / 1023 - 1, float(packed >> 11 & 2047) / 1023 - 1,
          float(packed >> 22) / 511 - 1};
}

TEST(PackNormalTexel, IsOffByAtMostATenthOfADegreeAndExactWhereFlat) {
  const float up[3] = {0, 0, 1};
  EXPECT_EQ(Unpacked(PackNormalTexel(up)), glm::vec3(0, 0, 1));
  Random random(81);
  for (int i = 0; i < 10000; ++i) {
    const glm::vec3 n =
        glm::normalize(glm::vec3(float(random.Between(-1, 1)), float(random.Between(-1, 1)), 0.3f));
    EXPECT_LT(glm::length(glm::cross(Unpacked(PackNormalTexel(&n.x)), n)), 0.0018f);
  }
}

// A square in the plane y = 0 whose uvs increase along x and against z, like Quad's. Bent() returns
// its shading normal at `place` as seen from `wo`.
struct Relief {
  Scene scene;
  explicit Relief(TextureUse use, const Image& image) {
    AddLambert(scene, "relief", glm::vec3(1));
    scene.images = {image};
    scene.textures = {{.image = 0, .use = use}};
    scene.materials[0].normal_texture = 0;
    Place(scene, Quad(1), 0, {0, 0, 0});
  }
  // Returns the direction of the image's axis `step` on the mesh.
  static glm::vec3 Axis(const Mesh& mesh, glm::vec2 step) {
    const glm::uvec3& t = mesh.triangles[0];
    const glm::mat2 uv(mesh.uvs[t.y] - mesh.uvs[t.x], mesh.uvs[t.z] - mesh.uvs[t.x]);
    const glm::vec2 edges = glm::inverse(uv) * step;
    return glm::normalize(edges.x * (mesh.positions[t.y] - mesh.positions[t.x]) +
                          edges.y * (mesh.positions[t.z] - mesh.positions[t.x]));
  }
  glm::vec3 Bent(const glm::vec3& wo, glm::vec2 place = {0.25f, 0.25f}) const {
    return BentNormal(Geometry(scene, "test"), scene.meshes[0], 0, place, wo);
  }
};

void ExpectNear(const glm::vec3& a, const glm::vec3& b) {
  EXPECT_LT(glm::length(a - b), 2e-3) << glm::to_string(a) << " is not " << glm::to_string(b);
}

const glm::vec3 kTilt(0.3f, 0.2f, 1);

TEST(NormalMaps, AConstantOneTiltsAlongTheAxesOfTheImage) {
  Relief relief(TextureUse::kNormals, Plain(NormalColor(kTilt)));
  const Mesh flat = relief.scene.meshes[0];
  for (const bool mirrored : {false, true}) {
    for (const bool facetted : {false, true}) {
      for (const bool upwards : {false, true}) {
        Mesh mesh = facetted ? Facetted(flat) : flat;
        glm::dmat4 world = glm::rotate(glm::dmat4(1), 0.7, glm::dvec3(0.3, 1, 0.2));
        if (mirrored) world = glm::scale(world, glm::dvec3(-1, 2, 1));
        TransformMesh(world, mesh);
        // In OBJ and pbrt, v points upwards, and the transform flips it.
        relief.scene.textures[0].transform =
            upwards ? glm::mat3x2(1, 0, 0, -1, 0, 1) : glm::mat3x2(1, 0, 0, 1, 0, 0);
        relief.scene.meshes = {mesh};
        const glm::vec3 x = Relief::Axis(mesh, {1, 0}),
                        y = Relief::Axis(mesh, {0, upwards ? 1 : -1});
        const glm::uvec3& t = mesh.triangles[0];
        const glm::vec3 up = glm::normalize(glm::cross(mesh.positions[t.y] - mesh.positions[t.x],
                                                       mesh.positions[t.z] - mesh.positions[t.x]));
        const glm::vec3 bent = glm::normalize(kTilt.x * x + kTilt.y * y + kTilt.z * up);
        SCOPED_TRACE(testing::Message() << mirrored << facetted << upwards);
        ExpectNear(relief.Bent(up), bent);
        ExpectNear(relief.Bent(-up), -bent);
      }
    }
  }
}

// In pbrt y of a normal map points along normal x tangent, even where v grows the other way.
TEST(NormalMaps, OfPbrtFollowTheNormalAndNotV) {
  const TemporaryFolder folder;
  WritePfm(folder.Path("normal.pfm"), Plain(NormalColor(kTilt)));
  const std::string map = "Material \"diffuse\" \"string normalmap\" \"normal.pfm\"\n";
  const std::string square =
      "Shape \"trianglemesh\" \"integer indices\" [0 1 2 0 2 3] "
      "\"point3 P\" [-1 -1 0 1 -1 0 1 1 0 -1 1 0] ";
  const std::string plain = "\"point2 uv\" [0 0 1 0 1 1 0 1] ";
  for (const std::string& shape :
       {square + plain, "ReverseOrientation " + square + plain, "Scale -1 1 1 " + square + plain,
        "ReverseOrientation Scale -1 1 1 " + square + plain,
        square + "\"point2 uv\" [1 0 0 0 0 1 1 1]",
        square + plain + "\"normal N\" [0 0 -1 0 0 -1 0 0 -1 0 0 -1]"}) {
    SCOPED_TRACE(shape);
    Relief relief(TextureUse::kColor, Plain({1, 1, 1}));
    relief.scene = ParsePbrt("WorldBegin\n" + map + shape, folder.Path("t.pbrt"));
    const Mesh& mesh = relief.scene.meshes.at(0);
    const glm::uvec3& t = mesh.triangles[0];
    const glm::vec3 up = glm::normalize(glm::cross(mesh.positions[t.y] - mesh.positions[t.x],
                                                   mesh.positions[t.z] - mesh.positions[t.x]));
    const glm::vec3 x = Relief::Axis(mesh, {1, 0}), y = glm::cross(up, x);
    ExpectNear(relief.Bent(up), glm::normalize(kTilt.x * x + kTilt.y * y + kTilt.z * up));
  }
}

TEST(NormalMaps, ScaleTiltsMore) {
  Relief relief(TextureUse::kNormals, Plain(NormalColor(kTilt)));
  const glm::vec3 x = Relief::Axis(relief.scene.meshes[0], {1, 0}),
                  y = Relief::Axis(relief.scene.meshes[0], {0, -1}), up(0, 1, 0);
  for (const float scale : {0.0f, 0.5f, 2.0f, -1.0f}) {
    relief.scene.materials[0].normal_scale = scale;
    ExpectNear(relief.Bent(up),
               glm::normalize(scale * kTilt.x * x + scale * kTilt.y * y + kTilt.z * up));
  }
}

TEST(NormalMaps, TangentsOfTheFileComeBeforeThoseOfTheCoordinates) {
  Relief relief(TextureUse::kNormals, Plain(NormalColor(kTilt)));
  Mesh& mesh = relief.scene.meshes[0];
  for (const float side : {1.0f, -1.0f}) {
    mesh.tangents.assign(mesh.positions.size(), glm::vec4(0, 0, 1, side));
    const glm::vec3 up(0, 1, 0), x(0, 0, 1), y = side * glm::cross(up, x);
    ExpectNear(relief.Bent(up), glm::normalize(kTilt.x * x + kTilt.y * y + kTilt.z * up));
  }
  mesh.tangents.assign(mesh.positions.size(), glm::vec4(0));
  ExpectNear(relief.Bent({0, 1, 0}), {0, 1, 0});
}

// A ramp of heights must have its slope in world units, whatever the size of square and image.
TEST(NormalMaps, HeightsAreLengthsOfTheWorld) {
  for (const auto& [width, half_size] : {std::pair{16, 1.0f}, {64, 1.0f}, {16, 3.0f}}) {
    Image ramp(width, width);
    for (int y = 0; y < width; ++y) {
      for (int x = 0; x < width; ++x) {
        std::fill_n(ramp.Pixel(x, y), 3, (float(x) + 0.5f) / float(width));
      }
    }
    Relief relief(TextureUse::kHeights, ramp);
    relief.scene.textures[0].wrap_u = TextureWrap::kClamp;
    relief.scene.meshes.clear();
    Place(relief.scene, Quad(half_size), 0, {0, 0, 0});
    relief.scene.materials[0].normal_scale = 0.8f;  // from 0 to 0.8 over the square
    const glm::vec3 x = Relief::Axis(relief.scene.meshes[0], {1, 0});
    const float slope = 0.8f / (2 * half_size);
    ExpectNear(relief.Bent({0, 1, 0}), glm::normalize(glm::vec3(0, 1, 0) - slope * x));
    relief.scene.materials[0].height_in_texels = true;
    const float of_texels = 0.8f / float(width);
    ExpectNear(relief.Bent({0, 1, 0}), glm::normalize(glm::vec3(0, 1, 0) - of_texels * x));
  }
}

// A ramp along both axes of an image that is no square, laid on triangles by coordinates that
// stretch, skew and mirror it, rises over the triangle as its heights at the corners do.
TEST(NormalMaps, HeightsFollowTheirCoordinates) {
  const glm::dvec2 rise(0.7, -0.4);
  Image ramp(48, 20);
  for (int y = 0; y < ramp.height; ++y) {
    for (int x = 0; x < ramp.width; ++x) {
      const double height =
          rise.x * (x + 0.5) / ramp.width + rise.y * (y + 0.5) / ramp.height + 0.5;
      std::fill_n(ramp.Pixel(x, y), 3, float(height));
    }
  }
  Relief relief(TextureUse::kHeights, ramp);
  relief.scene.textures[0].wrap_u = relief.scene.textures[0].wrap_v = TextureWrap::kClamp;
  Random random(85);
  int used = 0;
  for (int trial = 0; trial < 300; ++trial) {
    Mesh mesh;
    mesh.triangles = {{0, 1, 2}};
    double heights[3];
    for (double& height : heights) {
      mesh.positions.emplace_back(random.Between(-1, 1), random.Between(-1, 1),
                                  random.Between(-1, 1));
      mesh.uvs.emplace_back(random.Between(0.15, 0.85), random.Between(0.15, 0.85));
      const glm::mat3x2 upwards(1, 0, 0, -1, 0, 1);
      relief.scene.textures[0].transform = upwards;
      height = glm::dot(rise, glm::dvec2(upwards * glm::vec3(mesh.uvs.back(), 1)));
    }
    const glm::dvec3 a(mesh.positions[0]), e1 = glm::dvec3(mesh.positions[1]) - a,
                                           e2 = glm::dvec3(mesh.positions[2]) - a;
    const glm::dvec3 up = glm::normalize(glm::cross(e1, e2));
    // Along the surface, the gradient is what the heights of the edges ask for.
    const glm::dvec3 gradient = glm::inverse(glm::transpose(glm::dmat3(e1, e2, up))) *
                                glm::dvec3(heights[1] - heights[0], heights[2] - heights[0], 0);
    const glm::dvec2 d1 = mesh.uvs[1] - mesh.uvs[0], d2 = mesh.uvs[2] - mesh.uvs[0];
    if (glm::length(gradient) > 3 || std::abs(d1.x * d2.y - d1.y * d2.x) < 0.02) continue;
    ++used;
    relief.scene.meshes = {mesh};
    const glm::vec3 expected(glm::normalize(up - gradient));
    ForEachTarget([&] { ExpectNear(relief.Bent(glm::vec3(up), {0.3f, 0.4f}), expected); });
  }
  EXPECT_GT(used, 100);
}

// A coat and what lies below it are bent each by its own map, as a surface with that map alone is,
// but that the base is not turned to the eye here.
TEST(NormalMaps, CoatsAndTheirBasesHaveNormalsOfTheirOwn) {
  Relief relief(TextureUse::kNormals, Plain(NormalColor(kTilt)));
  relief.scene.images.push_back(Plain(NormalColor({-0.4f, 0.1f, 1})));
  relief.scene.textures.push_back({.image = 1, .use = TextureUse::kNormals});
  Material& material = relief.scene.materials[0];
  material.base_normal_scale = 0.5f;
  // Returns base_normal of a front or back face, and leaves ns in `coat`.
  const auto base_normal = [&](float side, glm::vec3& coat) {
    const Geometry geometry(relief.scene, "test");
    const soa::Table<SurfaceColumns> s(1);
    s->ng_y[0] = 1, s->wo_y[0] = side, s->u[0] = s->v[0] = 0.25f, s->t[0] = 1;
    PrepareSurfaces(geometry.triangle_tables(), geometry.materials().records, 1, s);
    const NormalMapView bases = geometry.base_normal_maps();
    EXPECT_EQ(bases.empty(), !geometry.materials().base_normals);
    if (!bases.empty()) WriteBaseNormals(geometry.textures(), bases, 0, 1, s);
    BendNormals(geometry.textures(), geometry.normal_maps(), 0, 1, s);
    coat = {s->ns_x[0], s->ns_y[0], s->ns_z[0]};
    return bases.empty() ? kSameNormal : s->base_normal[0];
  };
  glm::vec3 coat;
  EXPECT_EQ(base_normal(1, coat), kSameNormal);
  material.own_base_normals = true;
  for (const bool base_bent : {false, true}) {
    if (base_bent) material.base_normal_texture = 1;
    for (const float side : {1.0f, -1.0f}) {
      Relief alone = relief;
      const glm::vec3 of_coat = alone.Bent({0, side, 0});
      alone.scene.materials[0].normal_texture = material.base_normal_texture;
      alone.scene.materials[0].normal_scale = 0.5f;
      const glm::vec3 of_base = base_bent ? alone.Bent({0, side, 0}) : glm::vec3(0, side, 0);
      ForEachTarget([&] {
        EXPECT_EQ(base_normal(side, coat), EncodeNormal(of_base.x, of_base.y, of_base.z));
        EXPECT_EQ(coat, of_coat);
      });
    }
  }
  // Another material of the scene has one normal.
  relief.scene.materials.push_back(material);
  relief.scene.materials[0].own_base_normals = false;
  EXPECT_EQ(base_normal(1, coat), kSameNormal);
}

TEST(NormalMaps, NormalsNeverLookAwayFromTheEye) {
  Relief relief(TextureUse::kNormals, Plain(NormalColor({3, 0, 1})));
  const glm::vec3 x = Relief::Axis(relief.scene.meshes[0], {1, 0});
  for (const float lean : {0.0f, 0.5f, 1.0f, 5.0f, 50.0f}) {
    const glm::vec3 wo = glm::normalize(glm::vec3(0, 1, 0) - lean * x);
    const glm::vec3 bent = relief.Bent(wo);
    EXPECT_NEAR(glm::length(bent), 1, 1e-5);
    EXPECT_GT(glm::dot(bent, wo), 0.005f) << lean;
  }
}

TEST(NormalMaps, RowsWithoutAMapStayAndBitsDoNotDependOnTarget) {
  const Scene scene = ScreensScene();
  const Geometry geometry(scene, "test");
  const auto bend = [&](std::uint32_t n, bool maps) {
    Random random(83);
    const soa::Table<SurfaceColumns> table(kFullWave);
    const SurfaceColumns& s = table;
    for (std::uint32_t i = 0; i < kFullWave; ++i) {
      s.u[i] = float(random.Float()), s.v[i] = float(random.Float()) * (1 - s.u[i]);
      s.t[i] = 1, s.triangle[i] = random.Word() % 10;
      const Vec ng = random.Direction();
      Put(ng, i, s.ng_x, s.ng_y, s.ng_z);
      Put(random.DirectionAbout(ng), i, s.wo_x, s.wo_y, s.wo_z);
    }
    PrepareSurfaces(geometry.triangle_tables(), geometry.materials().records, kFullWave, s);
    if (maps) BendNormals(geometry.textures(), geometry.normal_maps(), 0.01f, n, s);
    std::vector<float> values;
    for (std::uint32_t i = 0; i < kFullWave; ++i) {
      values.insert(values.end(), {s.ns_x[i], s.ns_y[i], s.ns_z[i], float(s.material[i] & 255)});
    }
    return values;
  };
  const std::vector<float> plain = bend(kFullWave, false), all = bend(kFullWave, true);
  int bent = 0;
  for (std::uint32_t i = 0; i < kFullWave; ++i) {
    const bool mapped = scene.materials[std::size_t(all[4 * i + 3])].normal_texture.has_value();
    if (!mapped) {
      ASSERT_EQ(all[4 * i], plain[4 * i]);
    }
    bent += all[4 * i] != plain[4 * i];
  }
  EXPECT_GT(bent, int(kFullWave / 10));
  ForEachTarget([&] {
    for (const std::uint32_t n : kRowCounts) {
      const std::vector<float> some = bend(n, true);
      for (std::uint32_t i = 0; i < 4 * n; ++i) ASSERT_EQ(some[i], all[i]) << n << ", " << i;
    }
  });
}

}  // namespace
}  // namespace skywave
