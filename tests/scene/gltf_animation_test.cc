// Tests glTF animations: where vertices, lights and cameras are at a time, against values worked
// out by hand, and everything that is refused.
#include <gtest/gtest.h>

#include <cmath>
#include <functional>

#include "base/error.h"
#include "scene/gltf/reader.h"
#include "scene/reader.h"
#include "tests/support/gltf_document.h"
#include "tests/support/temporary_folder.h"

namespace skywave {
namespace {

constexpr double kPi = 3.14159265358979323846;

void ExpectNear(const glm::vec3& a, const glm::dvec3& b) {
  for (int i = 0; i < 3; ++i) {
    EXPECT_NEAR(double(a[i]), b[i], 2e-6) << a.x << " " << a.y << " " << a.z;
  }
}

// `frame` at one frame a second is a time in seconds.
Scene ReadAt(const GltfDocument& document, double seconds, const std::string& animation = "") {
  return ParseGltf(document.text(), "a.gltf", {.frame = seconds, .fps = 1, .animation = animation});
}

// Returns where the triangle's vertex is that the file has at (1, 0, 0).
glm::vec3 VertexAt(const GltfDocument& document, double seconds) {
  return ReadAt(document, seconds).meshes.at(0).positions.at(1);
}

// One channel of node 0, which is at (5, 0, 0) without it.
GltfDocument OneChannel(const std::string& property, const std::vector<float>& times,
                        const std::vector<float>& values,
                        const std::string& interpolation = "LINEAR") {
  GltfDocument document = TriangleDocument();
  const int input = document.Add<float>(times, "SCALAR");
  document.Animate(0, 0, property, input,
                   document.Add<float>(values, property == "rotation" ? "VEC4" : "VEC3"),
                   interpolation);
  return document;
}

TEST(GltfAnimation, LeavesNodesAtRestWithoutAFrame) {
  const Scene still = ParseGltf(TriangleDocument().text(), "a.gltf");
  const Scene moving = ParseGltf(MovingTriangle().text(), "a.gltf");
  EXPECT_EQ(still.meshes[0].positions, moving.meshes[0].positions);
  EXPECT_EQ(still.camera->world_from_camera, moving.camera->world_from_camera);
  EXPECT_TRUE(still.warnings.empty());
  EXPECT_TRUE(moving.warnings.empty());
  ASSERT_EQ(moving.notes.size(), 1u);
  EXPECT_NE(moving.notes[0].find("no frame"), std::string::npos) << moving.notes[0];
  ASSERT_EQ(moving.animations.size(), 2u);
  EXPECT_EQ(moving.animations[0].name, "slide");
  EXPECT_EQ(moving.animations[1].seconds, 2);
  EXPECT_EQ(moving.animations[1].channels, 1u);
}

TEST(GltfAnimation, LinearBetweenKeysAndClampedOutside) {
  const GltfDocument document =
      OneChannel("translation", {1, 2, 4}, {0, 2, 4, 4, 2, -6, 8, 10, -6});
  ExpectNear(VertexAt(document, 1.25), {2, 2, 1.5});
  ExpectNear(VertexAt(document, 2), {5, 2, -6});
  ExpectNear(VertexAt(document, 3.5), {8, 8, -6});
  ExpectNear(VertexAt(document, 0.5), {1, 2, 4});
  ExpectNear(VertexAt(document, -7), {1, 2, 4});
  ExpectNear(VertexAt(document, 4), {9, 10, -6});
  ExpectNear(VertexAt(document, 400), {9, 10, -6});
}

TEST(GltfAnimation, StepsKeepTheKeyBefore) {
  const GltfDocument document =
      OneChannel("translation", {0, 1, 2}, {1, 0, 0, 2, 0, 0, 3, 0, 0}, "STEP");
  ExpectNear(VertexAt(document, 0.999), {2, 0, 0});
  ExpectNear(VertexAt(document, 1), {3, 0, 0});
  ExpectNear(VertexAt(document, 1.999), {3, 0, 0});
  ExpectNear(VertexAt(document, 2), {4, 0, 0});
}

// 1/30 s is smaller than the float next to it, which the file has.
TEST(GltfAnimation, FramesMeetTheirKeysInSpiteOfRounding) {
  std::vector<float> times, values;
  for (int frame = 0; frame < 100; ++frame) {
    times.push_back(float(frame / 30.0));
    values.insert(values.end(), {float(frame), 0, 0});
  }
  const std::string text = OneChannel("translation", times, values, "STEP").text();
  for (int frame = 0; frame < 100; ++frame) {
    const Scene scene = ParseGltf(text, "a.gltf", {.frame = frame, .fps = 30, .animation = ""});
    EXPECT_EQ(scene.meshes[0].positions[0].x, float(frame));
  }
}

// Two seconds from 0 to 2 with an outgoing tangent of 1 and an incoming one of -3; at a quarter of
// the way 0.84375 * 0 + 2 * 0.140625 * 1 + 0.15625 * 2 + 2 * -0.046875 * -3 = 0.875.
TEST(GltfAnimation, CubicSplinesHaveTheirTangents) {
  const GltfDocument document = OneChannel("translation", {1, 3},
                                           {
                                               9,
                                               9,
                                               9,
                                               0,
                                               0,
                                               0,
                                               1,
                                               0,
                                               0,  // in, value, out
                                               -3,
                                               0,
                                               0,
                                               2,
                                               0,
                                               4,
                                               9,
                                               9,
                                               9,
                                           },
                                           "CUBICSPLINE");
  ExpectNear(VertexAt(document, 1.5), {1.875, 0, 4 * 0.15625});
  ExpectNear(VertexAt(document, 1), {1, 0, 0});
  ExpectNear(VertexAt(document, 3), {3, 0, 4});
  ExpectNear(VertexAt(document, 0), {1, 0, 0});
  ExpectNear(VertexAt(document, 9), {3, 0, 4});
}

TEST(GltfAnimation, CubicRotationsAreNormalised) {
  const float half = 0.70710678f;
  const GltfDocument document =
      OneChannel("rotation", {0, 1},
                 {0, 0, 0, 0, 0, 0, 0, 1, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, half, half, 0, 0, 0, 0},
                 "CUBICSPLINE");
  // Without tangents the middle is the mean of both, which is shorter than 1.
  ExpectNear(VertexAt(document, 0.5), {5 + std::cos(kPi / 4), std::sin(kPi / 4), 0});
}

TEST(GltfAnimation, RotationsTurnEvenlyOnTheShorterArc) {
  const float half = 0.70710678f;
  for (const float sign : {1.0f, -1.0f}) {  // q and -q are the same rotation
    const GltfDocument document =
        OneChannel("rotation", {0, 1}, {0, 0, 0, 1, 0, 0, sign * half, sign * half});
    for (const double share : {0.0, 0.25, 0.5, 0.9, 1.0}) {
      const double angle = share * kPi / 2;
      ExpectNear(VertexAt(document, share), {5 + std::cos(angle), std::sin(angle), 0});
    }
  }
}

TEST(GltfAnimation, ScalesThenTurnsThenMoves) {
  const float half = 0.70710678f;
  GltfDocument document = TriangleDocument();
  const int time = document.Add<float>({0}, "SCALAR");
  document.Animate(0, 0, "scale", time, document.Add<float>({2, 3, 1}, "VEC3"));
  document.Animate(0, 0, "rotation", time, document.Add<float>({0, 0, half, half}, "VEC4"));
  document.Animate(0, 0, "translation", time, document.Add<float>({1, 2, 3}, "VEC3"));
  const Mesh mesh = ReadAt(document, 0).meshes.at(0);
  ExpectNear(mesh.positions[1], {1, 4, 3});   // (1, 0, 0): (2, 0, 0), (0, 2, 0)
  ExpectNear(mesh.positions[2], {-2, 2, 3});  // (0, 1, 0): (0, 3, 0), (-3, 0, 0)
}

// A property that no channel moves is the file's.
TEST(GltfAnimation, KeepsWhatItDoesNotMove) {
  const GltfDocument document = OneChannel("scale", {0}, {2, 2, 2});
  ExpectNear(VertexAt(document, 0), {7, 0, 0});
}

TEST(GltfAnimation, MovesChildrenCamerasAndLights) {
  GltfDocument document = TriangleDocument();
  document.json["nodes"][0]["children"] = {1, 2, 5};
  document.json["scenes"][0]["nodes"] = {0, 3};
  document.json["extensionsUsed"] = {"KHR_lights_punctual"};
  document.json["extensions"]["KHR_lights_punctual"]["lights"] = {
      {{"type", "point"}, {"intensity", 1}}};
  document.json["nodes"].push_back(
      {{"extensions", {{"KHR_lights_punctual", {{"light", 0}}}}}, {"translation", {0, 1, 0}}});
  const float half = 0.70710678f;
  const int times = document.Add<float>({0, 1}, "SCALAR");
  document.Animate(0, 0, "translation", times, document.Add<float>({0, 0, 0, 2, 0, 0}, "VEC3"));
  document.Animate(0, 2, "rotation", times,
                   document.Add<float>({0, 0, 0, 1, 0, half, 0, half}, "VEC4"));
  const Scene scene = ReadAt(document, 1);
  ExpectNear(scene.meshes.at(0).positions[1], {3, 0, 0});
  ExpectNear(scene.lights.at(0).position, {2, 1, 0});
  // A quarter turn about y turns the view from -z to -x.
  const glm::mat4& world = scene.camera->world_from_camera;
  ExpectNear(glm::vec3(world[3]), {7.25, 0.25, 4});
  ExpectNear(glm::vec3(world[2]), {-1, 0, 0});
  // The other camera is a root and stays.
  ASSERT_EQ(scene.cameras.size(), 2u);
  EXPECT_EQ(scene.cameras[1].name, "side");
  ExpectNear(glm::vec3(scene.cameras[1].camera.world_from_camera[3]), {4, 1, 3});
}

TEST(GltfAnimation, RotationsMayBeNormalizedIntegers) {
  GltfDocument document = TriangleDocument();
  const int times = document.Add<float>({0, 1}, "SCALAR");
  const int turns = document.Add<std::int16_t>({0, 0, 0, 32767, 0, 0, 23170, 23170}, "VEC4", true);
  document.Animate(0, 0, "rotation", times, turns);
  ExpectNear(VertexAt(document, 0.5), {5 + std::cos(kPi / 4), std::sin(kPi / 4), 0});
  document.json["accessors"][std::size_t(turns)]["normalized"] = false;
  EXPECT_THROW(ReadAt(document, 0.5), InputError);
}

TEST(GltfAnimation, ValuesMayBeSparse) {
  GltfDocument document = OneChannel("translation", {0, 1, 2}, {1, 0, 0, 2, 0, 0, 3, 0, 0});
  nlohmann::json& accessor = document.json["accessors"].back();
  accessor["sparse"] = {
      {"count", 1},
      {"indices", {{"bufferView", document.AddView<std::uint16_t>({1})}, {"componentType", 5123}}},
      {"values", {{"bufferView", document.AddView<float>({7, 8, 9})}}}};
  ExpectNear(VertexAt(document, 0), {2, 0, 0});
  ExpectNear(VertexAt(document, 1), {8, 8, 9});
  ExpectNear(VertexAt(document, 2), {4, 0, 0});
  document.json["accessors"].back().erase("bufferView");  // the others are zero
  ExpectNear(VertexAt(document, 0), {1, 0, 0});
  ExpectNear(VertexAt(document, 1), {8, 8, 9});
}

TEST(GltfAnimation, AllAnimationsMoveOrOnlyTheNamedOne) {
  const GltfDocument document = MovingTriangle();
  ExpectNear(ReadAt(document, 1).meshes[0].positions[1], {std::cos(kPi / 4), std::sin(kPi / 4), 0});
  ExpectNear(ReadAt(document, 1, "slide").meshes[0].positions[1], {1, 0, 0});
  ExpectNear(ReadAt(document, 1, "turn").meshes[0].positions[1],
             {5 + std::cos(kPi / 4), std::sin(kPi / 4), 0});
}

TEST(GltfAnimation, TheFirstOfSeveralMoversCounts) {
  GltfDocument document = OneChannel("translation", {0}, {1, 0, 0});
  document.Animate(1, 0, "translation", document.Add<float>({0}, "SCALAR"),
                   document.Add<float>({2, 0, 0}, "VEC3"));
  const Scene both = ReadAt(document, 0);
  ExpectNear(both.meshes[0].positions[0], {1, 0, 0});
  ASSERT_EQ(both.warnings.size(), 1u);
  EXPECT_NE(both.warnings[0].find("several animations"), std::string::npos) << both.warnings[0];
  const Scene second = ReadAt(document, 0, "#1");
  ExpectNear(second.meshes[0].positions[0], {2, 0, 0});
  EXPECT_TRUE(second.warnings.empty());
}

TEST(GltfAnimation, UnknownNamesListTheAnimations) {
  const TemporaryFolder folder;
  const std::string path = folder.Write("a.gltf", MovingTriangle().text());
  try {
    ReadScene(path, {.frame = 0, .fps = 1, .animation = "trun"});
    FAIL();
  } catch (const OptionError& error) {
    EXPECT_NE(std::string(error.what())
                  .find("animation trun: there is no such animation; there "
                        "are turn, slide"),
              std::string::npos)
        << error.what();
  }
}

// A file stores the weights of all targets at the first key, then those at the second one.
TEST(GltfAnimation, MovesTheWeightsOfMorphTargets) {
  GltfDocument document = TriangleDocument();
  nlohmann::json& mesh = document.json["meshes"][0];
  const auto target = [&](const std::vector<float>& moves) {
    mesh["primitives"][0]["targets"].push_back({{"POSITION", document.Add<float>(moves, "VEC3")}});
  };
  target({0, 0, 0, 0, 1, 0, 0, 0, 0}), target({0, 0, 0, 0, 0, 1, 0, 0, 0});
  mesh["weights"] = {9, 9};
  const int times = document.Add<float>({0, 2}, "SCALAR");
  document.Animate(0, 1, "weights", times, document.Add<float>({0, 1, 4, 3}, "SCALAR"));
  EXPECT_TRUE(ReadAt(document, 0).warnings.empty());
  ExpectNear(VertexAt(document, 0), {6, 0, 1});
  ExpectNear(VertexAt(document, 0.5), {6, 1, 1.5});
  ExpectNear(VertexAt(document, 3), {6, 4, 3});
  // Normalized bytes are fractions.
  document.json["animations"][0]["samplers"][0]["output"] =
      document.Add<std::uint8_t>({0, 255, 51, 0}, "SCALAR", true);
  ExpectNear(VertexAt(document, 2), {6, 0.2, 0});
  // Three keys cannot have four weights.
  document.json["animations"][0]["samplers"][0]["input"] = document.Add<float>({0, 1, 2}, "SCALAR");
  EXPECT_THROW(ReadAt(document, 0), InputError);
}

TEST(GltfAnimation, WhatIsNotAnimatedIsNamed) {
  GltfDocument document = OneChannel("translation", {0}, {1, 0, 0});
  document.json["animations"][0]["channels"][0]["target"]["path"] = "pointer";
  const Scene scene = ReadAt(document, 0);
  ASSERT_EQ(scene.warnings.size(), 1u);
  EXPECT_NE(scene.warnings[0].find("'pointer'"), std::string::npos) << scene.warnings[0];
  EXPECT_THROW(
      ParseGltf(document.text(), "a.gltf", {.strict = true, .frame = 0, .fps = 1, .animation = ""}),
      InputError);
}

// Each of these is refused with the file, the animation and the channel, but only if a frame is
// asked for.
TEST(GltfAnimation, InvalidAnimationsAreRefused) {
  using nlohmann::json;
  const float nan = std::nanf("");
  const auto changed = [](const std::function<void(json&)>& change) {
    GltfDocument document = OneChannel("translation", {0, 1}, {1, 0, 0, 2, 0, 0});
    change(document.json);
    return document;
  };
  const auto sampler = [](json& j) -> json& { return j["animations"][0]["samplers"][0]; };
  const auto channel = [](json& j) -> json& { return j["animations"][0]["channels"][0]; };
  const std::pair<const char*, GltfDocument> cases[] = {
      {"times decrease", OneChannel("translation", {0, 2, 1}, {1, 0, 0, 2, 0, 0, 3, 0, 0})},
      {"not finite", OneChannel("translation", {0, nan}, {1, 0, 0, 2, 0, 0})},
      {"not finite", OneChannel("translation", {0, 1}, {1, 0, nan, 2, 0, 0})},
      {"need 3 values, not 2", OneChannel("translation", {0, 1, 2}, {1, 0, 0, 2, 0, 0})},
      {"need 6 values, not 2",
       OneChannel("translation", {0, 1}, {1, 0, 0, 2, 0, 0}, "CUBICSPLINE")},
      {"length zero", OneChannel("rotation", {0, 1}, {0, 0, 0, 1, 0, 0, 0, 0})},
      {"length 0", OneChannel("rotation", {0, 1}, {0, 0, 0, 0, 0, 0, 0, 1,  0, 0, 0, 0,
                                                   0, 0, 0, 0, 0, 0, 0, -1, 0, 0, 0, 0},
                              "CUBICSPLINE")},
      {"no interpolation 'CURLY'", OneChannel("scale", {0, 1}, {1, 1, 1, 2, 2, 2}, "CURLY")},
      {"no node 99", changed([&](json& j) { channel(j)["target"]["node"] = 99; })},
      {"no sampler 7", changed([&](json& j) { channel(j)["sampler"] = 7; })},
      {"no accessor 99", changed([&](json& j) { sampler(j)["input"] = 99; })},
      {"no accessor 99", changed([&](json& j) { sampler(j)["output"] = 99; })},
      {"components", changed([&](json& j) { sampler(j)["output"] = sampler(j)["input"]; })},
      {"a second time",
       changed([&](json& j) { j["animations"][0]["channels"].push_back(channel(j)); })},
      {"has a matrix", changed([&](json& j) {
         j["nodes"][0].erase("translation");
         j["nodes"][0]["matrix"] = {1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1};
       })},
      {"no floats", changed([&](json& j) { j["accessors"].back()["componentType"] = 5125; })},
      {"does not hold", changed([&](json& j) { j["accessors"].back()["count"] = 3; })},
  };
  for (const auto& [word, document] : cases) {
    SCOPED_TRACE(word);
    EXPECT_NO_THROW(ParseGltf(document.text(), "a.gltf"));
    try {
      ReadAt(document, 0.5);
      ADD_FAILURE() << "not refused";
    } catch (const InputError& error) {
      const std::string what = error.what();
      EXPECT_NE(what.find(word), std::string::npos) << what;
      EXPECT_NE(what.find("a.gltf: "), std::string::npos) << what;
      EXPECT_EQ(error.exit_code(), kExitBadInput);
    }
  }
}

Scene ReadVariant(const GltfDocument& document, const std::string& variant) {
  ReadOptions options;
  options.variant = variant;
  return ParseGltf(document.text(), "a.gltf", options);
}

// A primitive has the material of the variant, or its own where it has none for it.
TEST(GltfChoices, VariantsReplaceMaterials) {
  GltfDocument document = MovingTriangle();
  const auto material = [&](const std::string& variant) {
    const Scene scene = ReadVariant(document, variant);
    return scene.materials.at(scene.meshes.at(0).material).name;
  };
  EXPECT_EQ(ReadVariant(document, "").variants, std::vector<std::string>{"worn"});
  EXPECT_EQ(material(""), "paint");
  EXPECT_EQ(material("worn"), "steel");
  document.json["extensions"]["KHR_materials_variants"]["variants"] = {{{"name", "new"}},
                                                                       {{"name", "worn"}}};
  EXPECT_EQ(material("new"), "steel");
  EXPECT_EQ(material("worn"), "paint");
  const TemporaryFolder folder;
  const std::string path = folder.Write("a.gltf", document.text());
  ReadOptions options;
  options.variant = "old";
  EXPECT_THROW(ReadScene(path, options), OptionError);
}

TEST(GltfChoices, ScenesHaveNamesAndNumbers) {
  const TemporaryFolder folder;
  const std::string path = folder.Write("a.gltf", MovingTriangle().text());
  const auto read = [&](const std::string& scene) {
    ReadOptions options;
    options.scene = scene;
    return ReadScene(path, options);
  };
  EXPECT_EQ(read("").scenes, (std::vector<std::string>{"#0", "other"}));
  ExpectNear(read("").meshes.at(0).positions.at(1), {6, 0, 0});
  EXPECT_EQ(read("0").meshes.size(), read("").meshes.size());
  EXPECT_EQ(read("other").meshes.size(), 1u);
  EXPECT_EQ(read("1").meshes.size(), 1u);
  EXPECT_THROW(read("2"), OptionError);
}

TEST(GltfCameras, HaveTheNamesOfTheirNodesAndNoNameTwice) {
  GltfDocument document = TriangleDocument();
  document.json["nodes"][3]["name"] = "front";
  document.json["nodes"].push_back({{"camera", 1}});
  document.json["cameras"][1]["name"] = "lens";
  document.json["nodes"].push_back({{"camera", 0}});
  document.json["nodes"].push_back({{"camera", 1}, {"scale", {0, 0, 0}}});
  document.json["scenes"][0]["nodes"] = {0, 2, 3, 5, 6, 7};
  const Scene scene = ParseGltf(document.text(), "a.gltf");
  std::vector<std::string> names;
  for (const NamedCamera& camera : scene.cameras) names.push_back(camera.name);
  EXPECT_EQ(names, (std::vector<std::string>{"front", "front#3", "lens", "#6"}));
  EXPECT_EQ(scene.camera->world_from_camera, scene.cameras[0].camera.world_from_camera);
  ASSERT_EQ(scene.notes.size(), 1u) << "one of no size is left out";
  EXPECT_NE(scene.notes[0].find("left out"), std::string::npos);
}

}  // namespace
}  // namespace skywave
