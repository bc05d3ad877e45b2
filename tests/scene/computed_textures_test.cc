// Tests textures of pbrt files that are computed from others: checkers, mixtures, products.
#include <gtest/gtest.h>

#include <cmath>

#include "image/image.h"
#include "tests/support/oracle_texture.h"
#include "tests/support/temporary_folder.h"
#include "tests/support/texture_scene.h"

namespace skywave {
namespace {

// Compares the texture "x" with expected values.
class ComputedTextures : public PbrtTextureFiles {
 protected:
  void Expect(const std::string& textures, glm::dvec2 uv, glm::dvec3 color,
              double tolerance = 4e-3) {
    SCOPED_TRACE(textures);
    const Scene scene = Read(textures, "Material \"matte\" \"texture Kd\" \"x\"");
    EXPECT_EQ(scene.warnings, std::vector<std::string>{});
    const Material& material = scene.materials.at(scene.meshes.at(0).material);
    glm::dvec3 seen = material.reflectance;
    if (material.color_texture) seen *= LookUpTexture(scene, *material.color_texture, uv);
    EXPECT_LT(glm::length(seen - color), tolerance) << seen.x << " " << seen.y << " " << seen.z;
  }
};

const std::string kImage = "\"imagemap\" \"string filename\" \"t.png\" ";

TEST_F(ComputedTextures, CheckersAreWhereTheirCoordinatesAreOdd) {
  const std::string board =
      "Texture \"x\" \"color\" \"checkerboard\" \"rgb tex1\" [1 0 0] \"rgb tex2\" [0 0 1] "
      "\"float uscale\" 3 \"float vscale\" 5 \"float udelta\" .5";
  for (int i = 0; i < 12; ++i) {
    for (int j = 0; j < 10; ++j) {
      // These points are the centres of halves of checks, on both sides of the unit square.
      const double u = (i + 0.5) / 6 - 0.5, v = (j + 0.5) / 10 - 0.3;
      const bool odd = std::abs(std::fmod(std::floor(3 * u + 0.5) + std::floor(5 * v), 2)) == 1;
      Expect(board, {u, v}, odd ? glm::dvec3(0, 0, 1) : glm::dvec3(1, 0, 0));
    }
  }
  Expect("Texture \"x\" \"spectrum\" \"checkerboard\"", {0.5, 0.5}, {1, 1, 1});
  Expect("Texture \"x\" \"spectrum\" \"checkerboard\"", {1.5, 0.5}, {0, 0, 0});
}

TEST_F(ComputedTextures, MixAndScaleWorkTexelByTexel) {
  const std::string t = "Texture \"t\" \"color\" " + kImage;
  Expect(t + "Texture \"x\" \"color\" \"mix\" \"texture tex1\" \"t\" \"rgb tex2\" [0 1 0] "
             "\"float amount\" .25",
         {0.25, 0.75}, {0.75, 0.25, 0});
  Expect("Texture \"x\" \"color\" \"mix\" \"rgb tex1\" [1 0 0] \"rgb tex2\" [0 1 0]", {0, 0},
         {0.5, 0.5, 0}, 1e-6);
  // The mean of the image's green is a third.
  Expect("Texture \"t\" \"float\" " + kImage +
             "Texture \"x\" \"color\" \"mix\" \"rgb tex1\" [.5 .5 .5] \"rgb tex2\" [1 1 1] "
             "\"texture amount\" \"t\"",
         {0.75, 0.75}, glm::dvec3(2 / 3.0));
  for (const auto& [type, names] :
       {std::pair("color", "\"texture tex1\" \"t\" \"texture tex2\" \"u\""),
        std::pair("float", "\"texture tex\" \"t\" \"texture scale\" \"u\"")}) {
    const std::string product = std::string("Texture \"x\" \"color\" \"scale\" ") + names;
    const std::string u = std::string("Texture \"u\" \"") + type + "\" " + kImage;
    // White times white is halved; red times green gives black, and times the mean of green a
    // third.
    Expect(t + u + "\"float scale\" .5 " + product, {0.75, 0.25}, glm::dvec3(0.5));
    Expect(t + u + "\"float udelta\" .5 " + product, {0.25, 0.75},
           glm::dvec3(type == std::string("float") ? 1 / 3.0 : 0, 0, 0));
  }
  // Textures of different scales are combined over the unit square. (0.125, 0.875) is red in both.
  const std::string finer = t + "Texture \"u\" \"color\" " + kImage +
                            "\"float uscale\" 2 \"float vscale\" 2 Texture \"x\" \"color\" "
                            "\"mix\" \"texture tex1\" \"t\" \"texture tex2\" \"u\"";
  const Scene scene = Read(finer, "Material \"matte\" \"texture Kd\" \"x\"");
  EXPECT_EQ(scene.warnings, std::vector<std::string>{});
  const CompactImage& baked = scene.images.back();
  EXPECT_EQ(baked.width, 4);
  EXPECT_EQ(baked.height, 4);
}

// pbrt's defaults are 1 for a constant, black and white for the two that are mixed.
TEST_F(ComputedTextures, HaveDefaults) {
  Expect("Texture \"x\" \"color\" \"constant\"", {0, 0}, glm::dvec3(1), 1e-6);
  Expect("Texture \"x\" \"color\" \"mix\" \"float amount\" .25", {0, 0}, glm::dvec3(0.25), 1e-6);
  Expect("Texture \"x\" \"color\" \"mix\" \"float amount\" .25 \"float tex1\" .5", {0, 0},
         glm::dvec3(0.625), 1e-6);
  Expect("Texture \"x\" \"color\" \"scale\" \"float scale\" .25", {0, 0}, glm::dvec3(0.25), 1e-6);
}

// (s, t) = (2 u + 0.1, v / 2 + 0.2), and t points up.
TEST_F(ComputedTextures, AreScaledAndMovedAlongBothAxes) {
  const std::string moved =
      "\"float uscale\" 2 \"float vscale\" .5 \"float udelta\" .1 \"float vdelta\" .2";
  const auto uv = [](double s, double t) { return glm::dvec2((s - 0.1) / 2, (t - 0.2) * 2); };
  const std::string image = "Texture \"x\" \"color\" " + kImage + moved;
  Expect(image, uv(0.25, 0.75), {1, 0, 0});
  Expect(image, uv(0.75, 0.75), {0, 1, 0});
  Expect(image, uv(0.25, 0.25), {0, 0, 1});
  const std::string checks =
      "Texture \"x\" \"color\" \"checkerboard\" \"rgb tex1\" [1 0 0] \"rgb tex2\" [0 0 1] " + moved;
  Expect(checks, uv(0.9, 0.1), {1, 0, 0});
  Expect(checks, uv(0.9, -0.1), {0, 0, 1});
  Expect(checks, uv(1.1, 0.1), {0, 0, 1});
}

TEST_F(ComputedTextures, InvertAndGammaActOnNumbers) {
  Expect("Texture \"x\" \"color\" " + kImage + "\"bool invert\" true \"float scale\" .5",
         {0.25, 0.75}, {0.5, 1, 1});
  WritePng(folder_.Path("t.png"), 1, 1, {51, 102, 255});
  Expect("Texture \"x\" \"color\" " + kImage + "\"string encoding\" \"gamma 2\"", {0.5, 0.5},
         {0.04, 0.16, 1});
  Expect("Texture \"x\" \"color\" " + kImage + "\"bool gamma\" \"false\"", {0.5, 0.5},
         {0.2, 0.4, 1});
}

TEST_F(ComputedTextures, FourColoursAreInterpolated) {
  const std::string corners =
      "Texture \"x\" \"color\" \"bilerp\" \"rgb v00\" [0 0 0] \"rgb v10\" [1 0 0] "
      "\"rgb v01\" [0 .5 0] \"rgb v11\" [1 1 1]";
  for (const double u : {0.0, 0.25, 0.6, 1.0}) {
    for (const double v : {0.0, 0.5, 0.9, 1.0}) {
      Expect(corners, {u, v}, {u, (1 - u) * v * 0.5 + u * v, u * v});
    }
  }
  // The coordinates are scaled and moved, and end at the corners.
  Expect(corners + " \"float uscale\" .5 \"float udelta\" .25", {0.5, 0}, {0.5, 0, 0});
  Expect("Texture \"x\" \"color\" \"bilerp\"", {0.25, 0.5}, glm::dvec3(0.5));
}

// "uv" shows coordinates without their whole parts.
TEST_F(ComputedTextures, CoordinatesAreColours) {
  for (const double u : {0.1, 0.7}) {
    for (const double v : {0.2, 0.9}) {
      Expect("Texture \"x\" \"color\" \"uv\"", {u, v}, {u, v, 0});
      const double s = 3 * u + 0.25;
      Expect("Texture \"x\" \"color\" \"uv\" \"float uscale\" 3 \"float udelta\" .25", {u, v},
             {s - std::floor(s), v, 0});
    }
  }
}

// No surface reflects more light than it gets, whatever the factor of its image is.
TEST_F(ComputedTextures, ReflectanceEndsAtOne) {
  WritePng(folder_.Path("t.png"), 1, 1, {51, 102, 255});
  const std::string bright = kImage + "\"string encoding\" \"linear\" \"float scale\" 3 ";
  Expect("Texture \"x\" \"color\" " + bright, {0.5, 0.5}, {0.6, 1, 1});
  Expect("Texture \"t\" \"color\" " + bright +
             "Texture \"x\" \"color\" \"scale\" \"texture tex\" \"t\" \"float scale\" .5",
         {0.5, 0.5}, {0.3, 0.5, 0.5});
  const Scene scene = Read("Texture \"x\" \"color\" " + bright,
                           "Material \"diffusetransmission\" \"texture reflectance\" \"x\" "
                           "\"rgb transmittance\" [0 0 0] \"float scale\" .25");
  const Material& leaf = scene.materials.at(scene.meshes.at(0).material);
  EXPECT_EQ(leaf.reflectance, glm::vec3(0.25f));
  ASSERT_TRUE(leaf.color_texture);
  EXPECT_LT(
      glm::length(LookUpTexture(scene, *leaf.color_texture, {0.5, 0.5}) - glm::dvec3(0.6, 1, 1)),
      1e-6);
}

TEST_F(ComputedTextures, IncompatibleOperandsAreNamed) {
  const std::string text = "Texture \"t\" \"color\" " + kImage + "Texture \"u\" \"float\" " +
                           kImage +
                           "\"float uscale\" 1.5\nTexture \"x\" \"color\" \"scale\" "
                           "\"texture tex\" \"t\" \"texture scale\" \"u\"";
  const Scene scene = Read(text, "Material \"matte\" \"texture Kd\" \"x\"");
  ASSERT_EQ(scene.warnings.size(), 1u);
  EXPECT_NE(scene.warnings[0].find("s.pbrt:3: "), std::string::npos) << scene.warnings[0];
}

}  // namespace
}  // namespace skywave
