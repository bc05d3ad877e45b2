// Tests pbrt scenes: every directive, the syntax of both versions, and the warnings about
// unsupported features. Numbers are computed by hand from pbrt's conventions.
#include "scene/materials/spectrum.h"
#include "scene/pbrt/reader.h"

#include <gtest/gtest.h>

#include <cmath>
#include <filesystem>
#include <fstream>
#include <string>

#include "base/error.h"
#include "scene/reader.h"
#include "scene/scene.h"

namespace skywave {
namespace {

Scene Parse(const std::string& text) { return ParsePbrt(text, "t.pbrt"); }

constexpr const char* kTriangle =
    "Shape \"trianglemesh\" \"integer indices\" [0 1 2] \"point3 P\" [0 0 0  1 0 0  0 1 0]\n";

void ExpectNear(const glm::vec3& a, const glm::vec3& b, float tolerance = 1e-5f) {
  for (int i = 0; i < 3; ++i) {
    EXPECT_NEAR(a[i], b[i], tolerance) << "(" << a.x << " " << a.y << " " << a.z << ") for (" << b.x
                                       << " " << b.y << " " << b.z << ")";
  }
}

// Returns the position to which `directives` move the point (1, 2, 3).
glm::vec3 Transformed(const std::string& directives) {
  const Scene scene = Parse(
      "WorldBegin\n" + directives +
      "\nShape \"trianglemesh\" \"integer indices\" [0 1 2] \"point3 P\" [1 2 3 5 5 5 5 0 0]");
  return scene.meshes.at(0).positions.at(0);
}

Material OnlyMaterial(const std::string& directive) {
  const Scene scene = Parse("WorldBegin\n" + directive + "\n" + kTriangle);
  return scene.materials.at(scene.meshes.at(0).material);
}

glm::vec3 GeometricNormal(const Mesh& mesh, std::size_t i = 0) {
  const glm::uvec3 t = mesh.triangles[i];
  return glm::normalize(glm::cross(mesh.positions[t.y] - mesh.positions[t.x],
                                   mesh.positions[t.z] - mesh.positions[t.x]));
}

// A separate folder for each test, removed with it.
class TemporaryFolder {
 public:
  TemporaryFolder()
      : path_(std::filesystem::path(testing::TempDir()) /
              ("skywave_" +
               std::string(testing::UnitTest::GetInstance()->current_test_info()->name()))) {
    std::filesystem::create_directories(path_ / "parts");
  }
  ~TemporaryFolder() { std::filesystem::remove_all(path_); }
  std::string Write(const std::string& name, const std::string& text) const {
    std::ofstream(path_ / name, std::ios::binary) << text;
    return (path_ / name).string();
  }

 private:
  std::filesystem::path path_;
};

TEST(Transforms, MatchHandComputedMatrices) {
  ExpectNear(Transformed(""), {1, 2, 3});
  ExpectNear(Transformed("Translate 10 20 30"), {11, 22, 33});
  ExpectNear(Transformed("Translate [10 20 30]"), {11, 22, 33});
  ExpectNear(Transformed("Scale 2 3 -1"), {2, 6, -3});
  ExpectNear(Transformed("Rotate 90 0 0 1"), {-2, 1, 3});
  ExpectNear(Transformed("Rotate 90 0 2 0"), {3, 2, -1});
  // The last directive acts first.
  ExpectNear(Transformed("Translate 10 0 0 Scale 2 2 2"), {12, 4, 6});
  ExpectNear(Transformed("Scale 2 2 2 Translate 10 0 0"), {22, 4, 6});
  ExpectNear(Transformed("Translate 9 9 9 Identity"), {1, 2, 3});
  // The columns map x to y, y to z, z to x; a translation follows.
  const std::string matrix = "[0 1 0 0  0 0 1 0  1 0 0 0  7 8 9 1]";
  ExpectNear(Transformed("Translate 1 1 1 Transform " + matrix), {10, 9, 11});
  ExpectNear(Transformed("Translate 1 1 1 ConcatTransform " + matrix), {11, 10, 12});
  // A viewer at (0, 0, -5) that looks along +z with y up sees x on the right.
  ExpectNear(Transformed("LookAt 0 0 -5  0 0 0  0 1 0"), {1, 2, 8});
  // Looking along +x with y up, the right is -z in a left-handed world.
  ExpectNear(Transformed("LookAt 0 0 0  1 0 0  0 1 0"), {-3, 2, 1});
}

TEST(Transforms, CoordinateSystemsAreRecalled) {
  ExpectNear(Transformed("Translate 1 0 0 CoordinateSystem \"a\" Scale 5 5 5 Identity "
                         "CoordSysTransform \"a\""),
             {2, 2, 3});
  const Scene scene = Parse(std::string("Translate 0 0 4 Camera \"perspective\" WorldBegin\n"
                                        "CoordSysTransform \"camera\"\n") +
                            kTriangle);
  ExpectNear(scene.meshes.at(0).positions[0], {0, 0, -4});
}

TEST(Transforms, MotionStandsAtItsStart) {
  ExpectNear(Transformed("ActiveTransform EndTime Translate 9 9 9 Scale 2 2 2 Identity "
                         "ActiveTransform StartTime Translate 1 0 0 ActiveTransform All "
                         "Translate 0 0 1"),
             {2, 2, 4});
  ExpectNear(Transformed("TransformBegin ActiveTransform EndTime TransformEnd Translate 1 0 0"),
             {2, 2, 3});
}

TEST(Transforms, WorldBeginForgetsTheCamera) {
  const Scene scene = Parse(std::string("Translate 1 2 3 WorldBegin\n") + kTriangle);
  ExpectNear(scene.meshes.at(0).positions[0], {0, 0, 0});
}

TEST(Transforms, NormalsKeepTheirSide) {
  const std::string mesh =
      "Shape \"trianglemesh\" \"integer indices\" [0 1 2] \"point3 P\" [0 0 0 1 0 0 0 1 0] "
      "\"normal N\" [0 0 1 0 0 1 0 0 1]\n";
  for (const char* transform : {"", "Scale -1 1 1", "Rotate 70 1 2 3", "Scale 1 2 -3",
                                "ReverseOrientation", "ReverseOrientation Scale -1 1 1"}) {
    const Mesh smooth = Parse(std::string("WorldBegin ") + transform + "\n" + mesh).meshes.at(0);
    const Mesh flat = Parse(std::string("WorldBegin ") + transform + "\n" + kTriangle).meshes.at(0);
    ExpectNear(GeometricNormal(smooth), smooth.normals[0]);
    // Flat or smooth, the outside is the same.
    ExpectNear(GeometricNormal(flat), smooth.normals[0]);
    EXPECT_NEAR(glm::length(smooth.normals[1]), 1, 1e-6);
  }
  // A mirror keeps the normal (0, 0, 1); ReverseOrientation flips it.
  ExpectNear(Parse("WorldBegin Scale -1 1 1\n" + mesh).meshes.at(0).normals[0], {0, 0, 1});
  ExpectNear(Parse("WorldBegin ReverseOrientation\n" + mesh).meshes.at(0).normals[0], {0, 0, -1});
  const Mesh twice =
      Parse("WorldBegin ReverseOrientation ReverseOrientation\n" + mesh).meshes.at(0);
  ExpectNear(twice.normals[0], {0, 0, 1});
  // Where pbrt turns round shapes and subdivisions inside out, they are; lamps are not.
  const auto faces_out = [](const std::string& text) {
    const Mesh inside_out = Parse("WorldBegin " + text).meshes.at(0);
    const glm::vec3 middle = inside_out.positions[inside_out.triangles[0].x];
    const bool out = glm::dot(GeometricNormal(inside_out), middle) > 0;
    EXPECT_EQ(glm::dot(inside_out.normals[inside_out.triangles[0].x], middle) > 0, out);
    return out;
  };
  EXPECT_TRUE(faces_out("Shape \"sphere\""));
  EXPECT_FALSE(faces_out("Scale -1 1 1 Shape \"sphere\""));
  EXPECT_TRUE(faces_out("Scale -1 1 1 ReverseOrientation Shape \"sphere\""));
  EXPECT_TRUE(faces_out("AreaLightSource \"diffuse\" Scale -1 1 1 Shape \"sphere\""));
  const std::string solid =
      "Shape \"loopsubdiv\" \"integer levels\" 2 \"point3 P\" [1 1 1 -1 -1 1 -1 1 -1 1 -1 -1] "
      "\"integer indices\" ";
  EXPECT_FALSE(faces_out(solid + "[0 2 1 0 1 3 0 3 2 1 2 3]"));
  EXPECT_TRUE(faces_out(solid + "[0 1 2 0 3 1 0 2 3 1 3 2]"));
  // Normals take precedence over the winding.
  const Mesh against = Parse(
                           "WorldBegin Shape \"trianglemesh\" \"integer indices\" [0 1 2] "
                           "\"point3 P\" [0 0 0 1 0 0 0 1 0] \"normal N\" [0 0 -1 0 0 -1 0 0 -1]")
                           .meshes.at(0);
  ExpectNear(GeometricNormal(against), {0, 0, -1});
}

TEST(Materials, BothVersionsNames) {
  ExpectNear(OnlyMaterial("").reflectance, glm::vec3(0.5f));
  const Material matte = OnlyMaterial("Material \"matte\" \"color Kd\" [.1 .2 .3]");
  EXPECT_EQ(matte.bsdf, BsdfKind::kLambert);
  ExpectNear(matte.reflectance, {0.1f, 0.2f, 0.3f});
  ExpectNear(OnlyMaterial("Material \"diffuse\" \"rgb reflectance\" [.4 .5 .6]").reflectance,
             {0.4f, 0.5f, 0.6f});
  ExpectNear(OnlyMaterial("Material \"matte\" \"float Kd\" .25").reflectance, glm::vec3(0.25f));
  ExpectNear(
      OnlyMaterial("Material \"diffuse\" \"spectrum reflectance\" [400 .7 700 .7]").reflectance,
      glm::vec3(0.7f));
  const Material mirror = OnlyMaterial("Material \"mirror\" \"rgb Kr\" [.8 .7 .6]");
  EXPECT_EQ(mirror.bsdf, BsdfKind::kMirror);
  ExpectNear(mirror.reflectance, {0.8f, 0.7f, 0.6f});
  ExpectNear(OnlyMaterial("Material \"mirror\"").reflectance, glm::vec3(0.9f));
  const Material glass = OnlyMaterial("Material \"glass\" \"float index\" 1.33");
  EXPECT_EQ(glass.bsdf, BsdfKind::kDielectric);
  EXPECT_FLOAT_EQ(glass.ior, 1.33f);
  EXPECT_FLOAT_EQ(OnlyMaterial("Material \"dielectric\" \"float eta\" 1.7").ior, 1.7f);
  EXPECT_FLOAT_EQ(OnlyMaterial("Material \"dielectric\" \"spectrum eta\" \"glass-BK7\"").ior,
                  1.5168f);
  EXPECT_FLOAT_EQ(OnlyMaterial("Material \"dielectric\"").ior, 1.5f);
}

TEST(Materials, Conductors) {
  const Material gold = OnlyMaterial(
      "Material \"conductor\" \"spectrum eta\" \"metal-Au-eta\" \"spectrum k\" \"metal-Au-k\" "
      "\"float roughness\" 0.04");
  EXPECT_EQ(gold.bsdf, BsdfKind::kConductor);
  ExpectNear(gold.eta, {0.14312f, 0.37496f, 1.44248f});
  ExpectNear(gold.k, {3.98316f, 2.38572f, 1.60322f});
  EXPECT_FLOAT_EQ(gold.alpha, 0.2f);  // pbrt-v4: the square root
  const Material v3 = OnlyMaterial(
      "Material \"metal\" \"spectrum eta\" \"spds/Ag.eta.spd\" \"spectrum k\" \"spds/Ag.k.spd\" "
      "\"float roughness\" 0.1");
  ExpectNear(v3.k, {4.82834f, 3.12225f, 2.14695f});
  // 1.62142 + 0.819955 x + 0.1734 x^2 + 0.0171201 x^3 + 0.000640711 x^4 at x = ln 0.1
  EXPECT_NEAR(v3.alpha, 0.46176f, 1e-4f);
  EXPECT_FLOAT_EQ(OnlyMaterial("Material \"metal\" \"float roughness\" .3 "
                               "\"bool remaproughness\" \"false\"")
                      .alpha,
                  0.3f);
  EXPECT_FLOAT_EQ(
      OnlyMaterial("Material \"conductor\" \"float roughness\" .3 \"bool remaproughness\" false")
          .alpha,
      0.3f);
  ExpectNear(OnlyMaterial("Material \"metal\" \"rgb eta\" [1 2 3] \"rgb k\" [4 5 6]").eta,
             {1, 2, 3});
  // Smooth conductors become mirrors that keep their Fresnel reflectance.
  const Material smooth = OnlyMaterial("Material \"conductor\"");
  EXPECT_EQ(smooth.bsdf, BsdfKind::kMirror);
  ExpectNear(smooth.eta, {0.20044f, 0.92403f, 1.10221f});
  // eta = 1 and k give F = k^2 / (4 + k^2) at normal incidence.
  const glm::vec3 k =
      OnlyMaterial("Material \"conductor\" \"rgb reflectance\" [.2 .5 .8] \"float roughness\" 0.1")
          .k;
  ExpectNear(k * k / (4.0f + k * k), {0.2f, 0.5f, 0.8f});
  const Material anisotropic = OnlyMaterial(
      "Material \"conductor\" \"float uroughness\" .1 \"float vroughness\" .4 \"bool "
      "remaproughness\" "
      "false");
  EXPECT_EQ(anisotropic.bsdf, BsdfKind::kAnisotropicConductor);
  EXPECT_FLOAT_EQ(anisotropic.alpha, 0.1f);
  EXPECT_FLOAT_EQ(anisotropic.alpha_across.value(), 0.4f);
  // Metal that is rough in one direction alone is brushed.
  for (const bool along : {true, false}) {
    const Material brushed = OnlyMaterial(std::string("Material \"conductor\" \"float ") +
                                          (along ? "uroughness" : "vroughness") + "\" .09");
    EXPECT_EQ(brushed.bsdf, BsdfKind::kAnisotropicConductor);
    EXPECT_FLOAT_EQ(brushed.alpha, along ? 0.3f : 0.0f);
    EXPECT_FLOAT_EQ(brushed.alpha_across.value(), along ? 0.0f : 0.3f);
  }
  const Material coated = OnlyMaterial(
      "Material \"coatedconductor\" \"float conductor.roughness\" .25 "
      "\"float interface.roughness\" .01 \"float interface.eta\" 1.4 "
      "\"spectrum conductor.eta\" \"metal-Au-eta\" \"spectrum conductor.k\" \"metal-Au-k\"");
  EXPECT_EQ(coated.bsdf, BsdfKind::kCoatedConductor);
  EXPECT_FLOAT_EQ(coated.alpha, 0.5f);
  EXPECT_FLOAT_EQ(coated.coat_alpha, 0.1f);
  EXPECT_FLOAT_EQ(coated.ior, 1.4f);
  // The geometric mean with pbrt's least width.
  const Material brushed_coat =
      OnlyMaterial("Material \"coatedconductor\" \"float interface.vroughness\" .09");
  EXPECT_NEAR(brushed_coat.coat_alpha, std::sqrt(0.3f * 1e-4f), 1e-6f);
  ExpectNear(coated.k, {3.98316f, 2.38572f, 1.60322f});
}

// The indices n_d of Schott's catalogue, to all of its digits; F5, F10 and F11 are SF5, SF10 and
// SF11 in pbrt. An index by wavelength counts where n_d does.
TEST(Materials, NamedGlasses) {
  const std::pair<const char*, double> glasses[] = {
      {"BK7", 1.51680},  {"BAF10", 1.67003}, {"FK51A", 1.48656}, {"LASF9", 1.85025},
      {"F5", 1.67271},   {"F10", 1.72825},   {"F11", 1.78472},   {"SF5", 1.67271},
      {"SF10", 1.72825}, {"SF11", 1.78472}};
  for (const auto& [name, index] : glasses) {
    const std::string material =
        "Material \"dielectric\" \"spectrum eta\" \"glass-" + std::string(name) + "\"";
    EXPECT_NEAR(OnlyMaterial(material).ior, index, 1e-4) << name;
  }
  const std::string glass = "Material \"dielectric\" \"spectrum eta\" ";
  EXPECT_NEAR(OnlyMaterial(glass + "[400 1.7 700 1.4]").ior, 1.7 - 0.3 * 187.6 / 300, 1e-6);
  EXPECT_NEAR(OnlyMaterial("Material \"coateddiffuse\" \"spectrum eta\" [300 1.4]").ior, 1.4, 1e-6);
  EXPECT_THROW(OnlyMaterial(glass + "[700 1.7 400 1.4]"), InputError);
  EXPECT_THROW(OnlyMaterial(glass + "[400]"), InputError);
}

// Under both of pbrt's spellings; and about the reflectances at normal incidence that are published
// for these metals (Akenine-Moeller et al. 2018, table 9.2, where gold's red is above 1).
TEST(Materials, NamedMetals) {
  struct Metal {
    std::string name;
    glm::vec3 eta, k, reflectance;
  };
  const Metal metals[] = {
      {"Ag", {0.15526f, 0.11672f, 0.13838f}, {4.82834f, 3.12225f, 2.14695f}, {0.97f, 0.96f, 0.92f}},
      {"Al", {1.65746f, 0.88037f, 0.52123f}, {9.22387f, 6.26952f, 4.83700f}, {0.91f, 0.92f, 0.92f}},
      {"Au", {0.14312f, 0.37496f, 1.44248f}, {3.98316f, 2.38572f, 1.60322f}, {0.97f, 0.78f, 0.34f}},
      {"Cu", {0.20044f, 0.92403f, 1.10221f}, {3.91295f, 2.45285f, 2.14219f}, {0.95f, 0.64f, 0.54f}},
      {"MgO", {1.73438f, 1.74079f, 1.75403f}, glm::vec3(0), {0.072f, 0.073f, 0.075f}},
  };
  for (const Metal& metal : metals) {
    SCOPED_TRACE(metal.name);
    const auto read = [&](const std::string& eta, const std::string& k) {
      const Material material = OnlyMaterial(
          "Material \"conductor\" \"float roughness\" 0.1 "
          "\"spectrum eta\" \"" +
          eta + "\" \"spectrum k\" \"" + k + "\"");
      ExpectNear(material.eta, metal.eta);
      ExpectNear(material.k, metal.k);
    };
    read("metal-" + metal.name + "-eta", "metal-" + metal.name + "-k");
    read("spds/" + metal.name + ".eta.spd", "spds/" + metal.name + ".k.spd");
    const glm::vec3 k2 = metal.k * metal.k, less = metal.eta - 1.0f, more = metal.eta + 1.0f;
    const glm::vec3 reflectance = (less * less + k2) / (more * more + k2);
    for (int c = 0; c < 3; ++c) EXPECT_NEAR(reflectance[c], metal.reflectance[c], 0.03);
  }
}

TEST(Materials, DiffuseOnes) {
  const Material clay = OnlyMaterial("Material \"matte\" \"float sigma\" 20");
  EXPECT_EQ(clay.bsdf, BsdfKind::kOrenNayar);
  // The ratio is B / A of Oren and Nayar 1994 for sigma = 20 degrees.
  EXPECT_NEAR(clay.alpha, 0.2591 / 0.8652, 1e-3);
  EXPECT_EQ(OnlyMaterial("Material \"matte\" \"float sigma\" 0").bsdf, BsdfKind::kLambert);
  const Material sheet = OnlyMaterial(
      "Material \"diffusetransmission\" \"rgb reflectance\" [.1 .2 .3] \"rgb transmittance\" "
      "[.4 .5 .6] \"float scale\" .5");
  EXPECT_EQ(sheet.bsdf, BsdfKind::kDiffuseTransmission);
  ExpectNear(sheet.reflectance, {0.05f, 0.1f, 0.15f});
  ExpectNear(sheet.second_color, {0.2f, 0.25f, 0.3f});
  const Material too_much = OnlyMaterial(
      "Material \"diffusetransmission\" \"rgb reflectance\" [1 1 1] \"rgb transmittance\" [1 1 1]");
  ExpectNear(too_much.reflectance + too_much.second_color, glm::vec3(1));
  const Material translucent =
      OnlyMaterial("Material \"translucent\" \"rgb Kd\" [.8 .8 .8] \"rgb transmit\" [.25 .5 1]");
  ExpectNear(translucent.second_color, {0.2f, 0.4f, 0.8f});
}

// What a file leaves out is what pbrt's own readers take, which differs between materials and
// versions.
TEST(Materials, HaveTheDefaultsOfTheirVersions) {
  // 1.62142 + 0.819955 x + 0.1734 x^2 + 0.0171201 x^3 + 0.000640711 x^4 at x = ln 0.1 and ln 0.01
  constexpr float kAlphaOfTenth = 0.46176f, kAlphaOfHundredth = 0.13894f;
  for (const auto& [type, reflectance] :
       {std::pair("plastic", 0.25f), {"uber", 0.25f}, {"substrate", 0.5f}}) {
    SCOPED_TRACE(type);
    const Material coated = OnlyMaterial("Material \"" + std::string(type) + "\"");
    EXPECT_EQ(coated.bsdf, BsdfKind::kMetallicRoughness);
    ExpectNear(coated.reflectance, glm::vec3(reflectance));
    EXPECT_NEAR(coated.alpha, kAlphaOfTenth, 1e-4f);
    EXPECT_FLOAT_EQ(coated.ior, 1.5f);
  }
  const Material metal = OnlyMaterial("Material \"metal\"");
  EXPECT_EQ(metal.bsdf, BsdfKind::kConductor);
  EXPECT_NEAR(metal.alpha, kAlphaOfHundredth, 1e-4f);
  const Material paint = OnlyMaterial("Material \"coateddiffuse\"");
  ExpectNear(paint.reflectance, glm::vec3(0.5f));
  EXPECT_EQ(paint.alpha, 0);
  EXPECT_FLOAT_EQ(paint.ior, 1.5f);
  const Material lacquer = OnlyMaterial("Material \"coatedconductor\"");
  ExpectNear(lacquer.eta, {0.20044f, 0.92403f, 1.10221f});  // copper
  EXPECT_EQ(lacquer.alpha, 0);
  EXPECT_EQ(lacquer.coat_alpha, 0);
  EXPECT_FLOAT_EQ(lacquer.ior, 1.5f);
  const Material sheet = OnlyMaterial("Material \"diffusetransmission\"");
  ExpectNear(sheet.reflectance, glm::vec3(0.25f));
  ExpectNear(sheet.second_color, glm::vec3(0.25f));
  // A quarter of the light, of which each side gets a half.
  const Material leaf = OnlyMaterial("Material \"translucent\"");
  ExpectNear(leaf.reflectance, glm::vec3(0.125f));
  ExpectNear(leaf.second_color, glm::vec3(0.125f));
  const Material page =
      OnlyMaterial("Material \"translucent\" \"rgb reflect\" [.4 .2 0] \"rgb transmit\" [.1 0 .8]");
  ExpectNear(page.reflectance, {0.1f, 0.05f, 0});
  ExpectNear(page.second_color, {0.025f, 0, 0.2f});
  EXPECT_FLOAT_EQ(OnlyMaterial("Material \"thindielectric\"").ior, 1.5f);
}

TEST(Materials, RoughAndThinGlass) {
  const Material frosted =
      OnlyMaterial("Material \"dielectric\" \"float roughness\" .09 \"float eta\" 1.4");
  EXPECT_EQ(frosted.bsdf, BsdfKind::kRoughDielectric);
  EXPECT_FLOAT_EQ(frosted.alpha, 0.3f);
  EXPECT_FLOAT_EQ(frosted.ior, 1.4f);
  EXPECT_EQ(OnlyMaterial("Material \"glass\" \"float uroughness\" .1 \"float vroughness\" .1").bsdf,
            BsdfKind::kRoughDielectric);
  const Material ground =
      OnlyMaterial("Material \"dielectric\" \"float uroughness\" .04 \"float vroughness\" .25");
  EXPECT_EQ(ground.bsdf, BsdfKind::kRoughDielectric);
  EXPECT_FLOAT_EQ(ground.alpha, 0.2f);
  EXPECT_FLOAT_EQ(ground.alpha_across.value(), 0.5f);
  EXPECT_FALSE(frosted.alpha_across);
  EXPECT_EQ(OnlyMaterial("Material \"glass\" \"float roughness\" 0").bsdf, BsdfKind::kDielectric);
  // Roughness may be a texture that is constant.
  const std::string by_texture =
      "Texture \"r\" \"float\" \"constant\" \"float value\" .09\n"
      "Texture \"z\" \"float\" \"constant\" \"float value\" 0\n";
  EXPECT_FLOAT_EQ(
      OnlyMaterial(by_texture + "Material \"dielectric\" \"texture roughness\" \"r\"").alpha, 0.3f);
  for (const char* const type : {"dielectric", "glass"}) {
    const std::string glass = "Material \"" + std::string(type) + "\" \"texture roughness\" ";
    EXPECT_EQ(OnlyMaterial(by_texture + glass + "\"r\"").bsdf, BsdfKind::kRoughDielectric);
    EXPECT_EQ(OnlyMaterial(by_texture + glass + "\"z\"").bsdf, BsdfKind::kDielectric);
  }
  EXPECT_EQ(OnlyMaterial("Material \"thindielectric\" \"float eta\" 1.2").bsdf,
            BsdfKind::kThinDielectric);
}

TEST(Materials, Mixtures) {
  const char* const kTwo =
      "WorldBegin\nMakeNamedMaterial \"a\" \"string type\" \"matte\"\n"
      "MakeNamedMaterial \"b\" \"string type\" \"mirror\"\n";
  const auto mixture = [&](const std::string& rest) {
    const Scene scene = Parse(kTwo + ("Material \"mix\" " + rest) + "\n" + kTriangle);
    return scene.materials.at(scene.meshes.at(0).material).mixture.value();
  };
  const Mixture v4 = mixture("\"string materials\" [\"a\" \"b\"] \"float amount\" .3");
  EXPECT_EQ(v4.second, v4.first + 1);
  EXPECT_FLOAT_EQ(v4.share, 0.3f);
  const Mixture v3 = mixture(
      "\"string namedmaterial1\" \"a\" \"string namedmaterial2\" \"b\" \"rgb amount\" [.3 .3 .3]");
  EXPECT_EQ(v3.second, v3.first + 1);
  EXPECT_FLOAT_EQ(v3.share, 0.7f);
  EXPECT_THROW(mixture("\"string materials\" [\"a\" \"c\"]"), InputError);
  EXPECT_THROW(mixture("\"string materials\" [\"a\"]"), InputError);
}

TEST(Materials, NamedOnesAndConstantTextures) {
  const Scene scene = Parse(
      std::string("WorldBegin\n"
                  "Texture \"warm\" \"spectrum\" \"constant\" \"rgb value\" [.9 .5 .1]\n"
                  "MakeNamedMaterial \"a\" \"string type\" \"matte\" \"texture Kd\" \"warm\"\n"
                  "MakeNamedMaterial \"b\" \"string type\" [\"glass\"]\n"
                  "NamedMaterial \"a\"\n") +
      kTriangle + "NamedMaterial \"b\"\n" + kTriangle);
  EXPECT_EQ(scene.warnings, std::vector<std::string>{});
  ExpectNear(scene.materials.at(scene.meshes.at(0).material).reflectance, {0.9f, 0.5f, 0.1f});
  EXPECT_EQ(scene.materials.at(scene.meshes.at(1).material).bsdf, BsdfKind::kDielectric);
}

TEST(Scopes, RestoreWhatTheySave) {
  const std::string v4 = std::string(
                             "WorldBegin\nMaterial \"mirror\"\nAttributeBegin\n"
                             "Material \"glass\" Translate 5 0 0 ReverseOrientation\n"
                             "AttributeEnd\n") +
                         kTriangle + "TransformBegin Translate 7 0 0 Material \"matte\"\n" +
                         kTriangle + "TransformEnd\n" + kTriangle;
  const Scene scene = Parse(v4 + "WorldEnd\n");
  ASSERT_EQ(scene.meshes.size(), 3u);
  const auto kind = [&](int i) { return scene.materials[scene.meshes[i].material].bsdf; };
  EXPECT_EQ(kind(0), BsdfKind::kMirror);
  ExpectNear(scene.meshes[0].positions[0], {0, 0, 0});
  ExpectNear(GeometricNormal(scene.meshes[0]), {0, 0, 1});
  ExpectNear(scene.meshes[1].positions[0], {7, 0, 0});
  // TransformEnd restores the transform only, but in version 4, which has no WorldEnd, all.
  EXPECT_EQ(kind(2), BsdfKind::kLambert);
  ExpectNear(scene.meshes[2].positions[0], {0, 0, 0});
  const Scene newer = Parse(v4);
  EXPECT_EQ(newer.materials[newer.meshes.at(2).material].bsdf, BsdfKind::kMirror);
  ExpectNear(newer.meshes[2].positions[0], {0, 0, 0});
  // Each may close what the other has opened, in version 4 only.
  const std::string crossed =
      "WorldBegin AttributeBegin TransformEnd TransformBegin AttributeEnd AttributeBegin "
      "AttributeEnd ";
  EXPECT_NO_THROW(Parse(crossed));
  EXPECT_THROW(Parse(crossed + "WorldEnd"), InputError);
  EXPECT_THROW(Parse("WorldBegin ObjectBegin \"o\" AttributeEnd"), InputError);
}

TEST(Scopes, AttributesReachWhatFollows) {
  const Scene scene = Parse(
      "WorldBegin\nAttribute \"shape\" \"float radius\" 2\nAttribute \"material\" \"float eta\" "
      "1.7\nAttributeBegin\nAttribute \"shape\" \"float radius\" 3\nShape \"sphere\"\n"
      "Shape \"sphere\" \"float radius\" 4\nAttributeEnd\nMaterial \"glass\" Shape \"sphere\"\n");
  EXPECT_EQ(scene.warnings, std::vector<std::string>{});
  const float radii[] = {3, 4, 2};
  for (std::size_t i = 0; i < 3; ++i) {
    EXPECT_NEAR(glm::length(scene.meshes.at(i).positions[0]), radii[i], 1e-5) << i;
  }
  EXPECT_FLOAT_EQ(scene.materials.at(scene.meshes[2].material).ior, 1.7f);
}

TEST(Objects, InstancesAreTransformedCopies) {
  const Scene scene =
      Parse(std::string("WorldBegin\nObjectBegin \"o\"\nTranslate 1 0 0\n") + kTriangle +
            "ObjectEnd\nAttributeBegin Scale 2 2 2 ObjectInstance \"o\" AttributeEnd\n"
            "Translate 0 0 3 Scale -1 1 1 ObjectInstance \"o\"");
  ASSERT_EQ(scene.meshes.size(), 2u);
  ExpectNear(scene.meshes[0].positions[0], {2, 0, 0});
  ExpectNear(scene.meshes[0].positions[1], {4, 0, 0});
  ExpectNear(scene.meshes[1].positions[0], {-1, 0, 3});
  ExpectNear(GeometricNormal(scene.meshes[1]), {0, 0, 1});
}

TEST(Objects, InstancesShareTheirTriangles) {
  const std::string text =
      std::string("WorldBegin\nObjectBegin \"o\"\nTranslate 1 0 0\n") + kTriangle +
      "ObjectEnd\nAttributeBegin Scale 2 3 4 ObjectInstance \"o\" AttributeEnd\n" + kTriangle +
      "Translate 0 0 3 ObjectInstance \"o\"";
  ReadOptions options;
  options.instances = InstanceUse::kShare;
  const Scene scene = ParsePbrt(text, "t.pbrt", options);
  ASSERT_EQ(scene.objects.size(), 1u);
  EXPECT_EQ(scene.objects[0].name, "o");
  ASSERT_EQ(scene.objects[0].meshes.size(), 1u);
  ExpectNear(scene.objects[0].meshes[0].positions[0], {1, 0, 0});
  ASSERT_EQ(scene.instances.size(), 2u);
  ExpectNear(scene.instances[0].world_from_object * glm::dvec4(1, 1, 1, 1), {2, 3, 4});
  ExpectNear(scene.instances[1].world_from_object * glm::dvec4(1, 1, 1, 1), {1, 1, 4});
  EXPECT_EQ(scene.meshes.size(), 1u);
  options.max_instances = 1;
  try {
    ParsePbrt(text, "t.pbrt", options);
    ADD_FAILURE() << "two instances are read";
  } catch (const InputError& error) {
    EXPECT_NE(std::string(error.what()).find("more than 1 instances"), std::string::npos);
  }
}

TEST(Shapes, SphereTriangleMeshAndSubdivision) {
  const Scene scene = Parse(
      "WorldBegin Translate 1 0 0 Shape \"sphere\" \"float radius\" 2\n"
      "Identity Shape \"trianglemesh\" \"point P\" [0 0 0 1 0 0 0 1 0] \"float uv\" [0 0 1 0 0 1]\n"
      "Shape \"loopsubdiv\" \"integer nlevels\" 1 \"integer indices\" [0 1 2] \"point P\" "
      "[0 0 0 1 0 0 0 1 0]\n"
      "Shape \"loopsubdiv\" \"integer levels\" 2 \"integer indices\" [0 1 2] \"point3 P\" "
      "[0 0 0 1 0 0 0 1 0]\n"
      "Shape \"loopsubdiv\" \"integer indices\" [0 1 2] \"point3 P\" [0 0 0 1 0 0 0 1 0]\n");
  EXPECT_EQ(scene.warnings, std::vector<std::string>{});
  for (const glm::vec3& p : scene.meshes.at(0).positions) {
    EXPECT_NEAR(glm::distance(p, glm::vec3(1, 0, 0)), 2, 1e-5);
  }
  EXPECT_EQ(scene.meshes.at(1).triangles.at(0), glm::uvec3(0, 1, 2));
  EXPECT_EQ(scene.meshes.at(1).uvs.at(1), glm::vec2(1, 0));
  EXPECT_EQ(scene.meshes.at(2).triangles.size(), 4u);
  EXPECT_EQ(scene.meshes.at(3).triangles.size(), 16u);
  EXPECT_EQ(scene.meshes.at(4).triangles.size(), 64u);  // three levels are pbrt's default
}

TEST(Lights, FramesOfInfiniteLights) {
  const Scene constant =
      Parse("WorldBegin LightSource \"infinite\" \"rgb L\" [1 2 3] \"float scale\" 2");
  ASSERT_EQ(constant.environments.size(), 1u);
  EXPECT_TRUE(constant.environments[0].map_path.empty());
  ExpectNear(constant.environments[0].scale, {2, 4, 6});
  ExpectNear(constant.environments[0].world_from_map[0], {0, -1, 0});  // right
  ExpectNear(constant.environments[0].world_from_map[1], {-1, 0, 0});  // forward
  ExpectNear(constant.environments[0].world_from_map[2], {0, 0, 1});   // up
  // This is the common rotation of an upright map in a y-up world: light +z to world +y.
  const glm::mat3 upright =
      Parse("WorldBegin Rotate -90 1 0 0 LightSource \"infinite\" \"color scale\" [2 2 2]")
          .environments.at(0)
          .world_from_map;
  ExpectNear(upright[2], {0, 1, 0});
  ExpectNear(upright[1], {-1, 0, 0});
  ExpectNear(upright[0], {0, 0, 1});
  // Uniform scales change no direction; mirrors do.
  const glm::mat3 mirrored =
      Parse("WorldBegin Scale -3 3 3 LightSource \"infinite\"").environments.at(0).world_from_map;
  ExpectNear(mirrored[1], {1, 0, 0});
  ExpectNear(mirrored[0], {0, -1, 0});
}

TEST(Files, IncludesAndMapsAreLookedUpInTheFolderOfTheirFile) {
  const TemporaryFolder folder;
  folder.Write("parts/shape.pbrt", kTriangle);
  folder.Write("parts/map.hdr", "");
  folder.Write("parts/light.pbrt",
               "LightSource \"infinite\" \"string mapname\" \"map.hdr\"\n"
               "LightSource \"infinite\" \"string filename\" \"parts/map.hdr\"\n");
  folder.Write("parts/all.pbrt", "Include \"shape.pbrt\"\nImport \"light.pbrt\"\n");
  const std::string path = folder.Write("main.pbrt", "WorldBegin\nInclude \"parts/all.pbrt\"\n");
  const Scene scene = ReadScene(path);
  EXPECT_EQ(scene.meshes.size(), 1u);
  ASSERT_EQ(scene.environments.size(), 2u);
  EXPECT_TRUE(std::filesystem::exists(scene.environments[0].map_path));
  // as in pbrt: relative to the main file
  EXPECT_TRUE(std::filesystem::exists(scene.environments[1].map_path));
}

// What an imported file sets ends with it, and what it inherits does not.
TEST(Files, ImportsKeepTheirStateToThemselves) {
  const TemporaryFolder folder;
  const std::string part = std::string("Translate 5 0 0\n") + kTriangle +
                           "Material \"mirror\" ReverseOrientation\n"
                           "Attribute \"shape\" \"float radius\" 3\n";
  folder.Write("part.pbrt", part);
  const std::string rest = std::string(kTriangle) + "Shape \"sphere\"\n";
  const std::string begin = "WorldBegin\nTranslate 0 1 0 Material \"glass\"\n";
  const auto read = [&](const std::string& directive) {
    return ReadScene(folder.Write("main.pbrt", begin + directive + " \"part.pbrt\"\n" + rest));
  };
  const Scene imported = read("Import"), included = read("Include");
  ASSERT_EQ(imported.meshes.size(), 3u);
  ExpectNear(imported.meshes[0].positions[0], {5, 1, 0});
  EXPECT_EQ(imported.materials[imported.meshes[0].material].bsdf, BsdfKind::kDielectric);
  ExpectNear(imported.meshes[1].positions[0], {0, 1, 0});
  ExpectNear(GeometricNormal(imported.meshes[1]), {0, 0, 1});
  EXPECT_EQ(imported.materials[imported.meshes[1].material].bsdf, BsdfKind::kDielectric);
  EXPECT_NEAR(glm::length(imported.meshes[2].positions[0] - glm::vec3(0, 1, 0)), 1, 1e-5);
  ExpectNear(included.meshes.at(1).positions[0], {5, 1, 0});
  EXPECT_EQ(included.materials[included.meshes[1].material].bsdf, BsdfKind::kMirror);
}

TEST(Files, PlyAloneAndInAScene) {
  const TemporaryFolder folder;
  const std::string ply = folder.Write("t.PLY",
                                       "ply\nformat ascii 1.0\nelement vertex 3\nproperty float x\n"
                                       "property float y\nproperty float z\nelement face 1\n"
                                       "property list uchar int vertex_indices\nend_header\n"
                                       "0 0 0\n1 0 0\n0 1 0\n3 0 1 2\n");
  const Scene alone = ReadScene(ply);
  EXPECT_FALSE(alone.left_handed);
  ASSERT_EQ(alone.materials.size(), 1u);
  EXPECT_EQ(alone.materials[0].bsdf, BsdfKind::kLambert);
  const Scene scene = ReadScene(folder.Write(
      "m.pbrt", "WorldBegin Translate 1 1 1 Shape \"plymesh\" \"string filename\" \"t.PLY\""));
  ExpectNear(scene.meshes.at(0).positions.at(1), {2, 1, 1});
}

TEST(Syntax, CommentsBracketsAndNumbers) {
  const Scene scene = Parse(
      "# a comment [\"\n"
      "WorldBegin # another\n"
      "Translate +1 -.5 2e0#glued\n"
      "Shape\"trianglemesh\"\"integer indices\"[0 1 2]\"point3 P\"[0 0 0 1 0 0 0 1 0]\n"
      "Shape \"trianglemesh\" \"integer  indices\" [ 0.0 1 2 ] \"\tpoint3\tP \" [0 0 0 1 0 0 0 1 "
      "1e-60]");
  EXPECT_EQ(scene.warnings, std::vector<std::string>{});
  ASSERT_EQ(scene.meshes.size(), 2u);
  ExpectNear(scene.meshes[0].positions[0], {1, -0.5f, 2});
}

TEST(Warnings, SayWhereAndWhatIsDone) {
  const Scene scene = Parse(
      "Film \"rgb\" \"string filename\" \"out.exr\"\n"              // 1
      "WorldBegin\n"                                                // 2
      "LightSource \"laser\" \"rgb I\" [1 1 1]\n"                   // 3
      "Material \"velvet\"\n"                                       // 4
      "Shape \"cone\"\n"                                            // 5
      "Shape \"sphere\"\n"                                          // 6
      "  \"float bulge\" 2\n"                                       // 7
      "Shape \"cone\"\n"                                            // 8
      "Material \"dielectric\" \"float roughness\" 0.1\n"           // 9
      "Texture \"wood\" \"spectrum\" \"ptex\" \"float gamma\" 1\n"  // 10
      "Material \"matte\" \"texture Kd\" \"wood\"\n"                // 11
      "AreaLightSource \"laser\" \"rgb L\" [1 1 1]\n"               // 12
      "WorldEnd\n"                                                  // 13
      "WorldBegin\n");                                              // 14
  const std::vector<std::string> expected = {
      "t.pbrt:1: Film \"rgb\": \"filename\" is ignored: the output is named on the command line",
      "t.pbrt:3: LightSource \"laser\" is not supported: left out",
      "t.pbrt:4: Material \"velvet\" is not supported: rendered as grey Lambert",
      "t.pbrt:5: Shape \"cone\" is not supported: left out (2 times)",
      "t.pbrt:7: Shape \"sphere\": \"float bulge\" is not understood: ignored",
      "t.pbrt:10: Texture \"wood\" \"ptex\" is not supported: its users take their default",
      "t.pbrt:11: Material \"matte\": \"texture Kd\" (\"wood\") varies: the default is used",
      "t.pbrt:12: AreaLightSource \"laser\" is not supported: left out",
      "t.pbrt:14: everything after WorldEnd is ignored",
  };
  EXPECT_EQ(scene.warnings, expected);
}

// A space lasts as its scope does. Reflectances are adapted to daylight, and lights are not.
TEST(ColorSpaces, AreThoseOfTheirScope) {
  const std::string paint = " Material \"matte\" \"rgb Kd\" [.5 .4 .3] Shape \"sphere\" ";
  const Scene scene =
      Parse("WorldBegin AttributeBegin ColorSpace \"rec2020\"" + paint + "AttributeEnd" + paint +
            "ColorSpace \"aces2065-1\" LightSource \"infinite\" \"rgb L\" [1 1 1]");
  EXPECT_EQ(scene.warnings, std::vector<std::string>{});
  const auto color = [&](std::size_t mesh) {
    return scene.materials[scene.meshes.at(mesh).material].reflectance;
  };
  const glm::vec3 wide(0.5f * 1.6605f - 0.4f * 0.5876f - 0.3f * 0.0728f,
                       -0.5f * 0.1246f + 0.4f * 1.1329f - 0.3f * 0.0083f,
                       -0.5f * 0.0182f - 0.4f * 0.1006f + 0.3f * 1.1187f);
  const glm::vec3 white = scene.environments.at(0).scale;
  const glm::vec3 d60 = RgbOfIlluminant("illum-acesD60").value();
  for (int c = 0; c < 3; ++c) {
    EXPECT_NEAR(color(0)[c], wide[c], 5e-4f) << c;
    EXPECT_EQ(color(1)[c], (glm::vec3(.5f, .4f, .3f))[c]) << c;
    EXPECT_NEAR(white[c], d60[c], 2e-3f) << c;
  }
  EXPECT_THROW(Parse("WorldBegin ColorSpace \"rec709\""), InputError);
}

// Each of these must give at least one line that begins with its position.
TEST(Warnings, NothingIsSkippedInSilence) {
  for (const char* text : {"Camera \"realistic\"",
                           "Camera \"perspective\" \"float shutterspeed\" 1",
                           "Sampler \"sobol\"",
                           "Integrator \"mlt\"",
                           "Integrator \"path\" \"bool regularize\" true",
                           "PixelFilter \"mitchell\" \"float B\" 1",
                           "PixelFilter \"gaussian\" \"float sigma\" 2",
                           "Accelerator \"bvh\"",
                           "Film \"gbuffer\" \"float diagonal\" 35",
                           "Option \"forcediffuse\" true",
                           "ColorSpace \"rec2020\" Material \"matte\" \"rgb Kd\" [0 1 0]",
                           "ActiveTransform StartTime",
                           "TransformTimes 0 1",
                           "MakeNamedMedium \"m\" \"string type\" \"homogeneous\"",
                           "MediumInterface \"m\" \"\"",
                           "Attribute \"medium\" \"float scale\" 2",
                           "Attribute \"shape\" \"float bulge\" 2 Shape \"sphere\"",
                           "LightSource \"laser\"",
                           "LightSource \"point\" \"float bulge\" 1",
                           "Film \"rgb\" \"float maxcomponentvalue\" 3",
                           "LightSource \"infinite\" \"spectrum L\" \"stdillum-X\"",
                           "Scale 1 2 1 LightSource \"infinite\"",
                           "Material \"plastic\"",
                           "Material \"coatedconductor\" \"float interface.vroughness\" .4",
                           "Material \"coateddiffuse\" \"float uroughness\" .4",
                           "Material \"translucent\"",
                           "Material \"conductor\" \"spectrum eta\" \"metal-Xx-eta\"",
                           "Material \"glass\" \"rgb Kt\" [0 0 0]",
                           "Material \"matte\" \"rgb Kd\" [2 0 0]",
                           "Shape \"cone\"",
                           "Shape \"sphere\" \"integer radius\" 2",
                           "Material \"none\" Shape \"sphere\"",
                           "AreaLightSource \"goniometric\""}) {
    const Scene scene = Parse(std::string("\n") + text);
    ASSERT_FALSE(scene.warnings.empty()) << text;
    for (const std::string& warning : scene.warnings) {
      EXPECT_TRUE(warning.starts_with("t.pbrt:2: ")) << text << " -> " << warning;
    }
  }
}

TEST(Warnings, NoneWithoutCause) {
  EXPECT_EQ(
      Parse(
          "LookAt 0 0 0 0 0 1 0 1 0 Camera \"perspective\" \"float fov\" 40\n"
          "Film \"image\" \"integer xresolution\" 64 \"integer yresolution\" 64\n"
          "Integrator \"path\" \"integer maxdepth\" 5 ColorSpace \"srgb\"\n"
          "PixelFilter \"box\" \"float xradius\" .5 \"float yradius\" .5\nWorldBegin\n"
          "LightSource \"infinite\" \"rgb L\" [1 1 1]\n"
          "Material \"metal\" \"float roughness\" .1 \"bool remaproughness\" \"true\"\n"
          "Shape \"sphere\" \"float radius\" 1 \"float zmin\" -1 \"float phimax\" 360\nWorldEnd\n")
          .warnings,
      std::vector<std::string>{});
}

// IEC 61966-2-1: half the XYZ of the white D65 is grey, and that of the red primary is red.
TEST(Materials, ColoursOfXyzAreThoseOfTheirPrimaries) {
  ExpectNear(OnlyMaterial("Material \"matte\" \"xyz Kd\" [.47525 .5 .54445]").reflectance,
             glm::vec3(0.5f), 1e-3f);
  ExpectNear(OnlyMaterial("Material \"matte\" \"xyz Kd\" [.2062 .1063 .00965]").reflectance,
             {0.5f, 0, 0}, 1e-3f);
}

}  // namespace
}  // namespace skywave
