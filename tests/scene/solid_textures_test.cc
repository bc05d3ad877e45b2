// Tests textures in space: what is baked for a shape is what their formulas give there.
#include <fmt/format.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <functional>
#include <random>
#include <string>

#include "base/error.h"
#include "image/image.h"
#include "scene/geometry.h"
#include "scene/materials/noise.h"
#include "scene/pbrt/reader.h"
#include "tests/support/baked_places.h"
#include "tests/support/bent_normal.h"
#include "tests/support/temporary_folder.h"

namespace skywave {
namespace {

// The value at (3.14, 42, 7) is that of Perlin's own program.
TEST(GradientNoise, IsThatOfPerlin) {
  EXPECT_NEAR(GradientNoise({3.14, 42, 7}), 0.13691995878400012, 1e-12);
  EXPECT_NEAR(GradientNoise({3.14 - 256, 42 + 512, 7}), 0.13691995878400012, 1e-9);
  EXPECT_EQ(GradientNoise({-5, 0, 77}), 0);
  EXPECT_EQ(FractalNoise({0.3, 0.4, 0.5}, 0.5, 0), 0);
  EXPECT_NEAR(FractalNoise({0.3, 0.4, 0.5}, 0.25, 2),
              GradientNoise({0.3, 0.4, 0.5}) + 0.25 * GradientNoise({0.597, 0.796, 0.995}), 1e-12);
}

// The space of the texture is moved and stretched.
TEST(SolidTextures, ChecksInSpaceAreEvaluated) {
  const std::string checks =
      "AttributeBegin Translate .3 .1 .2 Scale .5 .25 1 Texture \"c\" \"spectrum\" "
      "\"checkerboard\" \"integer dimension\" 3 \"rgb tex1\" [.9 .8 .7] \"rgb tex2\" [.1 .2 .3] "
      "AttributeEnd Material \"diffuse\" \"texture reflectance\" \"c\" ";
  for (const char* shape :
       {"Rotate 30 1 1 0 Shape \"sphere\"", "Shape \"cylinder\" \"float phimax\" 200",
        "Shape \"trianglemesh\" \"point3 P\" [-1 -1 .3 1 -1 .2 1 1 .9 -1 1 .4] "
        "\"integer indices\" [0 1 2 0 2 3]",
        "Scale -1 1 1 Shape \"loopsubdiv\" \"integer levels\" 2 \"integer indices\" [0 1 2 0 2 3] "
        "\"point3 P\" [-1 -1 .3 1 -1 .2 1 1 .9 -1 1 .4]"}) {
    SCOPED_TRACE(shape);
    const Scene scene = ParseAll(checks + shape);
    ExpectChecks(Places(scene, scene.meshes[0].triangles.size() > 99 ? 2 : 999), 0.04,
                 {.9f, .8f, .7f}, {.1f, .2f, .3f}, [](const Place& place) {
                   return (place.position - glm::vec3(.3f, .1f, .2f)) / glm::vec3(.5f, .25f, 1);
                 });
  }
}

// As in pbrt, the first of two colours is black by default where textures are mixed, and white in
// checks.
TEST(SolidTextures, HaveDefaults) {
  const std::string ball = " Material \"matte\" \"texture Kd\" \"t\" Shape \"sphere\"";
  const Scene mixed = Parse("Texture \"t\" \"spectrum\" \"directionmix\"" + ball);
  for (const Place& place : Places(mixed, 1)) {
    ASSERT_NEAR(place.color.x, 1 - std::abs(place.normal.y), 0.02f);
  }
  const Scene checks =
      Parse("Texture \"t\" \"spectrum\" \"checkerboard\" \"integer dimension\" 3" + ball);
  ExpectChecks(Places(checks, 1), 0.02, glm::vec3(1), glm::vec3(0),
               [](const Place& place) { return place.position; });
}

TEST(SolidTextures, MixByDirection) {
  const Scene scene = ParseAll(
      "Rotate 90 0 0 1 Texture \"d\" \"spectrum\" \"directionmix\" \"rgb tex1\" [1 .5 0] "
      "\"float tex2\" .2 \"vector3 dir\" [0 3 0] Material \"matte\" \"texture Kd\" \"d\" "
      "Shape \"sphere\"");
  for (const Place& place : Places(scene, 1)) {
    // The turn takes y to -x.
    const float share = std::abs(place.normal.x);
    const glm::vec3 expected = glm::mix(glm::vec3(.2f), glm::vec3(1, .5f, 0), share);
    ASSERT_LT(glm::length(place.color - expected), 0.02f) << place.normal.x;
  }
}

// A mesh with smooth normals is mixed by those of its triangles.
TEST(SolidTextures, MixMeshesByTheirTriangles) {
  const Scene scene = ParseAll(
      "Texture \"d\" \"spectrum\" \"directionmix\" \"rgb tex1\" [1 .5 0] \"float tex2\" .2 "
      "Material \"matte\" \"texture Kd\" \"d\" Shape \"trianglemesh\" \"point3 P\" "
      "[0 0 0 1 0 0 0 1 1] \"integer indices\" [0 1 2] \"normal N\" [0 -.2 1 0 -1 .2 0 -1 1]");
  for (const Place& place : Places(scene, 1)) {
    const glm::vec3 expected = glm::mix(glm::vec3(.2f), glm::vec3(1, .5f, 0), std::sqrt(.5f));
    ASSERT_LT(glm::length(place.color - expected), 0.01f) << place.position.y;
  }
}

// Without noise, the darkest stone is where the sine along y is highest but for the last knot.
TEST(SolidTextures, MarbleFollowsItsCurve) {
  const Scene scene = ParseAll(
      "Texture \"m\" \"spectrum\" \"marble\" \"float variation\" 0 \"float scale\" 2 Material "
      "\"diffuse\" \"texture reflectance\" \"m\" Shape \"sphere\"");
  for (const Place& place : Places(scene, 1)) {
    const double along = 6 * (0.5 + 0.5 * std::sin(2.0 * double(place.position.y)));
    if (along > 0.98) continue;
    // The first of the six curves has one knot that is not the stone's colour, .5 instead of .58.
    const double t = along, expected = 1.5 * (0.58 - 0.08 * t * t * t);
    // Half a texel is 0.003 of y, over which the colour changes by at most 0.0045.
    ASSERT_NEAR(place.color.x, expected, 0.0055) << place.position.y;
  }
}

// Half a texel is 0.003 of a radius, over which noise of two octaves changes by less than 0.03.
TEST(SolidTextures, NoiseIsInTheSpaceOfItsTexture) {
  const auto places = [](const std::string& noise) {
    return Places(
        ParseAll("AttributeBegin Translate .2 0 0 Scale .5 1 1 Texture \"n\" \"spectrum\" " +
                 noise +
                 " AttributeEnd Material \"diffuse\" \"texture reflectance\" \"n\" "
                 "Shape \"sphere\""),
        1);
  };
  const auto inside = [](const Place& place) {
    return glm::dvec3((place.position - glm::vec3(.2f, 0, 0)) / glm::vec3(.5f, 1, 1));
  };
  double most = 0;
  for (const Place& p : places("\"fbm\" \"integer octaves\" 2 \"float roughness\" .3")) {
    const glm::dvec3 at = inside(p);
    const double sum = GradientNoise(at) + 0.3 * GradientNoise(1.99 * at);
    ASSERT_NEAR(p.color.x, Clamped(sum), 0.03);
    most = std::max(most, sum);
  }
  EXPECT_GT(most, 0.4);
  for (const Place& p : places("\"wrinkled\" \"integer octaves\" 2 \"float roughness\" .3")) {
    const glm::dvec3 at = inside(p);
    const double sum = std::abs(GradientNoise(at)) + 0.3 * std::abs(GradientNoise(1.99 * at));
    ASSERT_NEAR(p.color.y, Clamped(sum + 0.2 * 0.09), 0.03);
  }
  for (const Place& p : places("\"windy\"")) {
    const glm::dvec3 at = inside(p);
    const double wind = std::abs(FractalNoise(0.1 * at, 0.5, 3));
    ASSERT_NEAR(p.color.z, Clamped(wind * FractalNoise(at, 0.5, 6)), 0.03);
  }
}

// The bent normal is that of a surface raised by the noise, whatever the shape, its transform and
// the place of its triangles in the image. Half a texel of the coarsest is 0.005.
TEST(SolidTextures, RaiseSurfaces) {
  const std::string noise =
      "AttributeBegin Scale .8 1 .9 Texture \"n\" \"float\" \"fbm\" \"integer octaves\" 2 "
      "AttributeEnd Texture \"h\" \"float\" \"scale\" \"texture tex\" \"n\" \"float scale\" .3 "
      "Material \"diffuse\" \"texture displacement\" \"h\" ";
  const auto height = [](const glm::dvec3& p) {
    const glm::dvec3 at = p / glm::dvec3(.8, 1, .9);
    return 0.3 * (GradientNoise(at) + 0.5 * GradientNoise(1.99 * at));
  };
  for (const char* shape :
       {"Shape \"sphere\"", "ReverseOrientation Shape \"sphere\" \"float zmax\" .7",
        "Scale 1 2 1 Shape \"cylinder\" \"float phimax\" 200",
        "Rotate 20 1 1 0 Scale -1 1 1 Shape \"disk\" \"float innerradius\" .3",
        "Shape \"trianglemesh\" \"point3 P\" [-1 -1 .3 1 -1 .2 1 1 .9 -1 1 .4] "
        "\"integer indices\" [0 1 2 0 2 3]",
        "Scale 1 -.3 1 Shape \"trianglemesh\" \"point3 P\" [-1 -1 .3 1 -1 .2 1 1 .9]"}) {
    SCOPED_TRACE(shape);
    const Scene scene = Parse(noise + shape);
    ASSERT_TRUE(scene.warnings.empty()) << scene.warnings[0];
    const Geometry geometry(scene, "t.pbrt");
    const Mesh& mesh = scene.meshes.at(0);
    std::mt19937 random(9);
    std::uniform_real_distribution<float> uniform(0, 0.5f);
    double steepest = 0;
    for (int i = 0; i < 2000; ++i) {
      const auto triangle = std::uint32_t(random() % mesh.triangles.size());
      const glm::uvec3& t = mesh.triangles[triangle];
      const glm::vec2 b(uniform(random), uniform(random));
      const auto blend = [&](const auto& of) {
        return glm::dvec3((1 - b.x - b.y) * of[t.x] + b.x * of[t.y] + b.y * of[t.z]);
      };
      const glm::dvec3 place = blend(mesh.positions);
      const glm::dvec3 edge = glm::dvec3(mesh.positions[t.y] - mesh.positions[t.x]);
      const glm::dvec3 normal = glm::normalize(
          mesh.normals.empty()
              ? glm::cross(edge, glm::dvec3(mesh.positions[t.z] - mesh.positions[t.x]))
              : blend(mesh.normals));
      // Where coordinates meet in a point, a texel is long and thin.
      if (std::abs(glm::normalize(place).z) > 0.95) continue;
      glm::dvec3 gradient;
      for (int c = 0; c < 3; ++c) {
        glm::dvec3 step(0);
        step[c] = 1e-4;
        gradient[c] = (height(place + step) - height(place - step)) / 2e-4;
      }
      gradient -= normal * glm::dot(normal, gradient);
      steepest = std::max(steepest, glm::length(gradient));
      const glm::dvec3 raised = glm::normalize(normal - gradient);
      const glm::dvec3 bent(BentNormal(geometry, mesh, triangle, b, glm::vec3(normal)));
      ASSERT_LT(glm::length(bent - raised), 0.02)
          << place.x << " " << place.y << " " << place.z << " on " << triangle;
    }
    EXPECT_GT(steepest, 0.4);
  }
}

// Images lie over the (u, v) of the shape, also where its texels are those of triangles.
TEST(SolidTextures, AreCombinedWithImages) {
  const std::string checks =
      "Texture \"c\" \"spectrum\" \"checkerboard\" \"float uscale\" 3 \"float vscale\" 2 "
      "\"rgb tex1\" [.9 .8 .7] \"rgb tex2\" [.1 .2 .3] "
      "Texture \"s\" \"spectrum\" \"checkerboard\" \"integer dimension\" 3 \"texture tex1\" \"c\" "
      "\"float tex2\" 0 Material \"diffuse\" \"texture reflectance\" \"s\" ";
  const auto on_sphere = [](const glm::vec3& p) {
    const double turn = std::atan2(p.y, p.x) / (2 * std::acos(-1.0));
    return glm::dvec2(turn - std::floor(turn), 1 - std::acos(double(p.z)) / std::acos(-1.0));
  };
  const auto on_mesh = [](const glm::vec3& p) { return glm::dvec2(p.x, 0.5 * double(p.y) + 1); };
  struct Case {
    std::string shape;
    std::function<glm::dvec2(const glm::vec3&)> uv;
  };
  for (const auto& [shape, uv_of] :
       {Case{"Shape \"sphere\"", on_sphere},
        Case{"Shape \"trianglemesh\" \"point3 P\" [-.9 -.9 .3 .9 -.9 .2 .9 .9 .6 -.9 .9 .4] "
             "\"point2 uv\" [-.9 .55 .9 .55 .9 1.45 -.9 1.45] "
             "\"integer indices\" [2 0 1 3 0 2]",
             on_mesh}}) {
    SCOPED_TRACE(shape);
    const Scene scene = ParseAll(checks + shape);
    std::size_t bright = 0, dim = 0, black = 0;
    for (const Place& place : Places(scene, scene.meshes[0].triangles.size() > 99 ? 2 : 999)) {
      const auto in_space = IsFirst(place.position, 0.03);
      const auto on_surface = IsFirst(uv_of(place.position) * glm::dvec2(3, 2), 0.05);
      if (!in_space || !on_surface) continue;
      const glm::vec3 expected = !*in_space    ? glm::vec3(0)
                                 : *on_surface ? glm::vec3(.9f, .8f, .7f)
                                               : glm::vec3(.1f, .2f, .3f);
      ++(!*in_space ? black : *on_surface ? bright : dim);
      ASSERT_LT(glm::length(place.color - expected), 0.02f)
          << place.position.x << " " << place.position.y << " " << place.position.z;
    }
    EXPECT_GT(std::min({bright, dim, black}), 50u);
  }
}

// Heights that rise along u, on a triangle whose u is (x + 1) / 2 and whose texels lie askew to it.
TEST(SolidTextures, RaiseSurfacesWithImages) {
  const Scene scene = ParseAll(
      "Texture \"u\" \"float\" \"bilerp\" \"float v00\" 0 \"float v01\" 0 \"float v10\" 1 "
      "\"float v11\" 1 Texture \"d\" \"float\" \"directionmix\" \"float tex1\" .5 \"float tex2\" 0 "
      "\"vector3 dir\" [0 0 1] Texture \"h\" \"float\" \"mix\" \"float tex1\" 0 "
      "\"texture tex2\" \"u\" \"texture amount\" \"d\" "
      "Material \"diffuse\" \"texture displacement\" \"h\" Shape \"trianglemesh\" "
      "\"point3 P\" [-.8 -.8 0 .8 -.2 0 .1 .8 0] \"point2 uv\" [.1 .1 .9 .4 .55 .9]");
  const Geometry geometry(scene, "t.pbrt");
  const glm::vec3 raised = glm::normalize(glm::vec3(-0.25f, 0, 1));  // half of half of x
  for (const glm::vec2 b : {glm::vec2(0.3f, 0.3f), {0.6f, 0.2f}, {0.2f, 0.6f}}) {
    const glm::vec3 bent = BentNormal(geometry, scene.meshes.at(0), 0, b, {0, 0, 1});
    EXPECT_LT(glm::length(bent - raised), 0.01f) << bent.x << " " << bent.y;
  }
}

// pbrt-v3 lets a texture reflect more than it gets: its marble extrapolates.
TEST(SolidTextures, OfVersion3ThatReflectMoreThanTheyGetAreReported) {
  const std::string ball =
      "Texture \"n\" \"spectrum\" \"checkerboard\" \"integer dimension\" 3 \"float tex1\" 2\n"
      "Material \"matte\" \"texture Kd\" \"n\"\nShape \"sphere\"\n";
  EXPECT_TRUE(Parse(ball).warnings.empty());
  const std::vector<std::string> v3 = Parse(ball + "WorldEnd").warnings;
  ASSERT_EQ(v3.size(), 1u);
  EXPECT_TRUE(v3[0].starts_with("t.pbrt:3: a texture in space reflects more")) << v3[0];
}

// Each texture of a chain takes twice the evaluations of the one before it, or one more.
TEST(SolidTextures, SlowTexturesAreReported) {
  const auto warnings = [](const std::string& next, int count, const std::string& shape) {
    std::string text = "Texture \"t\" \"float\" \"fbm\"\n";
    for (int i = 0; i < count; ++i) text += "Texture \"t\" \"float\" " + next + "\n";
    return Parse(text + "Material \"conductor\" \"texture roughness\" \"t\" " + shape).warnings;
  };
  const std::string shape = "Shape \"trianglemesh\" \"point3 P\" [0 0 0 1 0 0 0 1 0]";
  const std::string doubled = "\"mix\" \"texture tex1\" \"t\" \"texture tex2\" \"t\"";
  EXPECT_TRUE(warnings(doubled, 7, "").empty());
  const std::vector<std::string> many = warnings(doubled, 40, shape);
  ASSERT_FALSE(many.empty());
  EXPECT_TRUE(many[0].starts_with("t.pbrt:9: ")) << many[0];  // 1, 3, 7, ... 255, 511
  const std::string longer = "\"scale\" \"texture tex\" \"t\" \"float scale\" .5";
  EXPECT_TRUE(warnings(longer, 255, "").empty());
  const std::vector<std::string> deep = warnings(longer, 20000, shape);
  ASSERT_FALSE(deep.empty());
  EXPECT_TRUE(deep[0].starts_with("t.pbrt:257: ")) << deep[0];
}

// As in pbrt, a normal map replaces heights.
TEST(SolidTextures, NormalMapsReplaceHeights) {
  const TemporaryFolder folder;
  WriteImage(folder.Path("n.pfm"), Image(2, 2));
  const Scene scene = ParsePbrt(
      "WorldBegin Texture \"n\" \"float\" \"fbm\" Material \"diffuse\" \"texture displacement\" "
      "\"n\" \"string normalmap\" \"n.pfm\" Shape \"sphere\"",
      folder.Path("t.pbrt"), {.strict = true});
  const Material& material = scene.materials[scene.meshes.at(0).material];
  EXPECT_EQ(scene.textures[material.normal_texture.value()].use, TextureUse::kPbrtNormals);
  EXPECT_EQ(material.normal_scale, 1);
  EXPECT_EQ(scene.images.size(), 1u);
}

// Over a texel that is nearly nothing, heights rise by more than a float holds.
TEST(SolidTextures, SlopesAreFinite) {
  const Scene scene = Parse(
      "Texture \"n\" \"float\" \"checkerboard\" \"integer dimension\" 3 \"float tex1\" 1e30 "
      "Material \"diffuse\" \"texture displacement\" \"n\" Scale 1e-15 1e-15 1 Shape "
      "\"trianglemesh\" \"point3 P\" [-1 -1 0 1 -1 0 0 1 0]");
  const Material& material = scene.materials[scene.meshes.at(0).material];
  EXPECT_EQ(material.normal_scale, 1e6f);
  const Image image = scene.images.at(0).Floats();
  for (const float value : image.rgb) ASSERT_TRUE(std::isfinite(value));
}

// The alpha of a shape is its own: another shape of the same material is opaque. What varies on
// the material lies over the same (u, v).
TEST(SolidTextures, MakeShapesTransparent) {
  const std::string textures =
      "Texture \"n\" \"float\" \"wrinkled\" \"integer octaves\" 2 Texture \"c\" \"spectrum\" "
      "\"checkerboard\" \"integer dimension\" 3 \"rgb tex1\" [1 .5 0] \"rgb tex2\" [0 0 1] ";
  for (const char* shape :
       {"Shape \"sphere\"", "Shape \"trianglemesh\" \"point3 P\" [-1 -1 .3 1 -1 .2 1 1 .9]"}) {
    for (const char* reflectance :
         {"\"rgb reflectance\" [.2 .3 .4]", "\"texture reflectance\" \"c\""}) {
      SCOPED_TRACE(fmt::format("{}, {}", shape, reflectance));
      const bool checks = std::string(reflectance).starts_with("\"texture");
      const Scene scene = ParseAll(textures + "Material \"diffuse\" " + reflectance + " " + shape +
                                   " \"texture alpha\" \"n\" Shape \"sphere\"");
      EXPECT_TRUE(scene.materials[scene.meshes.at(1).material].opaque());
      const Material& material = scene.materials[scene.meshes.at(0).material];
      ASSERT_TRUE(material.opacity_texture);
      EXPECT_EQ(scene.textures[*material.opacity_texture].use, TextureUse::kOpacity);
      EXPECT_EQ(material.opacity, 1);
      for (const Place& p : Places(scene, 99, &Material::opacity_texture)) {
        const glm::dvec3 at(p.position);
        const double sum =
            std::abs(GradientNoise(at)) + 0.5 * std::abs(GradientNoise(1.99 * at)) + 0.2 * 0.25;
        ASSERT_NEAR(p.color.x, Clamped(sum), 0.03);
      }
      EXPECT_EQ(material.color_texture.has_value(), checks);
      if (!checks) continue;
      ExpectChecks(Places(scene, 99), 0.02, {1, .5f, 0}, {0, 0, 1},
                   [](const Place& place) { return place.position; });
    }
  }
}

// Each of 12800 small triangles shows the place that it is at, in as many texels as it needs.
TEST(SolidTextures, FollowSmallTriangles) {
  std::string points, triangles;
  constexpr int kCells = 80;
  for (int i = 0; i <= kCells; ++i) {
    for (int k = 0; k <= kCells; ++k) {
      const double x = double(k) / kCells, y = double(i) / kCells;
      points += fmt::format("{} {} {} ", x, y, 0.3 * x * y);
      if (i == kCells || k == kCells) continue;
      const int at = i * (kCells + 1) + k;
      triangles += fmt::format("{} {} {} {} {} {} ", at, at + 1, at + kCells + 2, at,
                               at + kCells + 2, at + kCells + 1);
    }
  }
  const Scene scene = ParseAll(
      "AttributeBegin Scale .02 .02 .02 Texture \"c\" \"spectrum\" \"checkerboard\" "
      "\"integer dimension\" 3 \"rgb tex1\" [.9 .8 .7] \"rgb tex2\" [.1 .2 .3] AttributeEnd "
      "Material \"diffuse\" \"texture reflectance\" \"c\" Translate .003 .004 .005 "
      "Shape \"trianglemesh\" \"point3 P\" [" +
      points + "] \"integer indices\" [" + triangles + "]");
  // Squares have 16 texels a side: one is 0.042 checks along a leg.
  ExpectChecks(Places(scene, 2), 0.05, {.9f, .8f, .7f}, {.1f, .2f, .3f},
               [](const Place& place) { return place.position / 0.02f; });
  EXPECT_TRUE(scene.textures.at(0).one_level);
}

// A shape leaves texels for those after it, and its parameters share what it takes.
TEST(SolidTextures, LeaveTexelsForOthers) {
  const auto shape = [](int count) {
    std::string triangles;
    for (int i = 0; i < count; ++i) triangles += "0 1 2 ";
    return "Shape \"trianglemesh\" \"point3 P\" [0 0 0 1 0 0 0 1 0] \"integer indices\" [" +
           triangles + "] ";
  };
  const std::string checks =
      "Texture \"c\" \"spectrum\" \"checkerboard\" \"integer dimension\" 3 "
      "Texture \"n\" \"float\" \"checkerboard\" \"integer dimension\" 3 "
      "Material \"diffuse\" \"texture reflectance\" \"c\" ";
  const Scene four = ParseAll(checks + shape(100) + shape(100) + shape(100) + shape(100));
  ASSERT_EQ(four.images.size(), 4u);
  std::size_t left = std::size_t{1} << 25;
  for (const CompactImage& image : four.images) {
    const std::size_t texels = image.values() / 3;
    EXPECT_LE(texels, left / 4);
    left -= texels;
  }
  // Squares have an eighth of all, so those of each of two images a sixteenth, and the image less
  // than twice that. Ten triangles alone would have squares of 512 texels a side.
  const Scene both = ParseAll(checks + "\"texture displacement\" \"n\" " + shape(10));
  ASSERT_EQ(both.images.size(), 2u);
  for (const CompactImage& image : both.images) EXPECT_LT(image.values() / 3, (1u << 25) / 8);
}

// A mesh without triangles shows no texture, and is no reason for a warning.
TEST(SolidTextures, AMeshWithoutTrianglesCausesNoWarning) {
  const TemporaryFolder folder;
  folder.Write("empty.ply",
               "ply\nformat ascii 1.0\nelement vertex 3\nproperty float x\nproperty float y\n"
               "property float z\nelement face 0\nproperty list uchar int vertex_indices\n"
               "end_header\n0 0 0\n1 0 0\n0 1 0\n");
  const Scene scene = ParsePbrt(
      "WorldBegin Texture \"c\" \"spectrum\" \"checkerboard\" \"integer dimension\" 3 "
      "Material \"diffuse\" \"texture reflectance\" \"c\" Shape \"plymesh\" \"string filename\" "
      "\"empty.ply\"",
      folder.Path("t.pbrt"), {.strict = true});
  EXPECT_TRUE(scene.images.empty());
}

TEST(SolidTextures, ShapesOfTooManyTrianglesAreReported) {
  std::string triangles;
  for (int i = 0; i <= 1 << 18; ++i) triangles += "0 1 2 ";
  const Scene fine = Parse(
      "Texture \"c\" \"spectrum\" \"checkerboard\" \"integer dimension\" 3 "
      "Material \"diffuse\" \"texture reflectance\" \"c\" "
      "Shape \"trianglemesh\" \"point3 P\" [0 0 0 1 0 0 0 1 0] "
      "\"integer indices\" [" +
      triangles + "]");
  ASSERT_EQ(fine.warnings.size(), 1u);
  EXPECT_EQ(fine.materials[fine.meshes[0].material].reflectance, glm::vec3(0.5f));
}

TEST(SolidTextures, AreReportedWhereOthersNeedTheCoordinates) {
  const std::string checks = "Texture \"c\" \"spectrum\" \"checkerboard\" \"integer dimension\" 3 ";
  // Alpha depends on the (u, v) that the triangle has.
  const std::string shape =
      "Texture \"a\" \"float\" \"checkerboard\" Shape \"trianglemesh\" \"point3 P\" "
      "[0 0 0 1 0 0 0 1 0] \"texture alpha\" \"a\"";
  const Scene fixed = Parse(checks + "Material \"diffuse\" \"texture reflectance\" \"c\" " + shape);
  ASSERT_EQ(fixed.warnings.size(), 1u);
  EXPECT_EQ(fixed.materials[fixed.meshes[0].material].reflectance, glm::vec3(0.5f));
  const Scene mixed = Parse(checks +
                            "MakeNamedMaterial \"p\" \"string type\" \"diffuse\" \"texture "
                            "reflectance\" \"c\" Material \"mix\" \"string materials\" [\"p\" "
                            "\"p\"] " +
                            shape);
  ASSERT_EQ(mixed.warnings.size(), 1u);
  const auto& mixture = mixed.materials[mixed.meshes[0].material].mixture;
  EXPECT_EQ(mixed.materials[mixture->first].reflectance, glm::vec3(0.5f));
}

}  // namespace
}  // namespace skywave
