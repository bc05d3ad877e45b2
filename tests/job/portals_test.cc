// Portals as scenes and users give them: pbrt's parameter, corners, meshes, and what is refused.
#include "job/portals.h"

#include <gtest/gtest.h>

#include <functional>

#include "base/error.h"
#include "job/job.h"
#include "lights/strategies/strategy.h"
#include "scene/gltf/reader.h"
#include "scene/pbrt/reader.h"
#include "scene/portals.h"
#include "scene/reader.h"
#include "tests/support/gltf_document.h"
#include "tests/support/temporary_folder.h"

namespace skywave {
namespace {

std::string Refusal(const std::function<void()>& call) {
  try {
    call();
  } catch (const InputError& error) {
    return error.what();
  }
  return "";
}
void ExpectContains(const std::string& text, const std::string& part) {
  EXPECT_NE(text.find(part), std::string::npos) << "'" << text << "' without '" << part << "'";
}

glm::vec3 Out(const Portal& portal) {
  return glm::normalize(glm::cross(portal.side_x, portal.side_y));
}
void ExpectNear(const glm::vec3& a, const glm::vec3& b) {
  EXPECT_LT(glm::length(a - b), 1e-5f) << a.x << " " << a.y << " " << a.z;
}

// The corners of a window in the plane z = 3, counter-clockwise for those at smaller z.
constexpr char kPbrt[] =
    "WorldBegin Rotate 90 0 0 1\n"
    "LightSource \"infinite\" \"rgb L\" [1 1 1]\n"
    "  \"point3 portal\" [ 0 0 3  0 2 3  1 2 3  1 0 3 ]\n"
    "Shape \"sphere\"\n";

TEST(PbrtPortals, AreRectanglesInTheWorld) {
  const Scene scene = ParsePbrt(kPbrt, "t.pbrt");
  EXPECT_TRUE(scene.warnings.empty()) << scene.warnings.at(0);
  ASSERT_EQ(scene.portals.size(), 1u);
  const Portal& portal = scene.portals[0];
  ExpectNear(portal.corner, {0, 0, 3});
  ExpectNear(portal.side_x, {1, 0, 0});
  ExpectNear(portal.side_y, {0, 2, 0});
  ExpectNear(Out(portal), {0, 0, 1});
}

TEST(PbrtPortals, ChooseTheStrategyUnlessTheUserDoes) {
  JobRequest request = {.read = {}};
  request.width = request.height = 4, request.samples_per_pixel = 1;
  const Scene scene = ParsePbrt(kPbrt, "t.pbrt");
  EXPECT_EQ(RenderJob(scene, request).strategy().name(), "portal");
  request.strategy = "warp";
  EXPECT_EQ(RenderJob(scene, request).strategy().name(), "warp");
  request.strategy.clear();
  Scene without = scene;
  without.portals.clear(), without.settings.strategy.reset();
  EXPECT_EQ(RenderJob(without, request).strategy().name(), "importance");
  request.portals = {"0,0,3,0,2,3,1,2,3,1,0,3"};
  EXPECT_EQ(RenderJob(without, request).strategy().name(), "portal");
  request.strategy = "portal:share=0", request.options.mis = false;
  ExpectContains(Refusal([&] { RenderJob(without, request); }), "leaves light to BSDF sampling");
  request.portals.clear(), request.strategy = "portal";
  ExpectContains(Refusal([&] { RenderJob(without, request); }), "no portals");
}

TEST(PbrtPortals, InvalidPortalsAreRefusedWithTheirPlace) {
  const std::pair<const char*, const char*> cases[] = {
      {"0 0 3  0 2 3  1 2 3", "9 numbers"},
      {"0 0 3  0 2 3  1 2 3  1 0 3  7 7 3", "15 numbers"},
      {"0 0 3  0 2 3  1 2 4  1 0 3", "not a plane rectangle"},
      {"0 0 3  0 2 3  1 3 3  1 1 3", "no right angle"},
      {"0 0 3  1 2 3  0 2 3  1 0 3", "in order"},
      {"0 0 3  0 0 3  1 0 3  1 0 3", "in one place"},
      {"0 0 3  0 2 3  1 2 3  1e39 0 3", ""},
  };
  for (const auto& [points, reason] : cases) {
    const std::string message = Refusal([&, text = points] {
      ParsePbrt(
          "WorldBegin\nLightSource \"infinite\" \"point3 portal\" [" + std::string(text) + "]\n",
          "t.pbrt");
    });
    ExpectContains(message, "t.pbrt:2");
    ExpectContains(message, reason);
  }
}

// A floor, and a window of two triangles in the plane x = -1 whose normals are along +x.
Scene RoomOfGltf() {
  GltfDocument file;
  const auto mesh = [&](const std::string& name, const std::vector<float>& positions,
                        const std::vector<std::uint16_t>& indices) {
    const int at = file.Add(positions, "VEC3");
    file.json["meshes"].push_back(
        {{"name", name},
         {"primitives",
          {{{"attributes", {{"POSITION", at}}}, {"indices", file.Add(indices, "SCALAR")}}}}});
  };
  mesh("floor", {-1, 0, -1, 1, 0, -1, 1, 0, 1, -1, 0, 1}, {0, 2, 1, 0, 3, 2});
  mesh("window", {-1, 0, -1, -1, 2, -1, -1, 2, 1, -1, 0, 1}, {0, 1, 2, 0, 2, 3});
  file.json["nodes"] = {{{"mesh", 0}}, {{"mesh", 1}, {"translation", {0, 0.5, 0}}}};
  file.json["scenes"] = {{{"nodes", {0, 1}}}};
  return ParseGltf(file.text(), "t.gltf");
}

TEST(GivenPortals, APortalMeshIsNotRendered) {
  Scene scene = RoomOfGltf();
  ASSERT_EQ(scene.meshes.size(), 2u);
  AddPortals({"window"}, scene);
  ASSERT_EQ(scene.meshes.size(), 1u);
  EXPECT_EQ(scene.meshes[0].name, "floor");
  ASSERT_EQ(scene.portals.size(), 1u);
  const Portal& portal = scene.portals[0];
  EXPECT_NEAR(glm::length(portal.side_x), 2, 1e-6);
  EXPECT_NEAR(glm::length(portal.side_y), 2, 1e-6);
  ExpectNear(portal.corner + 0.5f * (portal.side_x + portal.side_y), {-1, 1.5f, 0});
  ExpectNear(Out(portal), {-1, 0, 0});
}

TEST(GivenPortals, InvalidPortalsAreRefused) {
  const std::pair<std::vector<std::string>, const char*> cases[] = {
      {{"windows"}, "the scene has window"},
      {{"1,2,3"}, "3 numbers"},
      {{"0,0,3,0,2,3,1,2,4,1,0,3"}, "not a plane rectangle"},
      {{"-1,0,-1,-1,0,1,-1,2,1,-1,2,-1", "1,0,-1,1,0,1,1,2,1,1,2,-1"}, ""},
      {{"-1,0,-1,-1,2,-1,-1,2,1,-1,0,1", "1,0,-1,1,2,-1,1,2,1,1,0,1"}, "faces away"},
      {std::vector<std::string>(65, "window"), "is neither"},
      {std::vector<std::string>(65, "-1,0,-1,-1,2,-1,-1,2,1,-1,0,1"), "65 portals"},
  };
  for (const auto& [texts, reason] : cases) {
    Scene scene = RoomOfGltf();
    const std::string message = Refusal([&, given = texts] { AddPortals(given, scene); });
    EXPECT_FALSE(message.empty()) << reason;
    ExpectContains(message, reason);
  }
}

TEST(GivenPortals, OfMeshesNeedRectanglesOfTwoTriangles) {
  Mesh mesh = {.name = "m",
               .positions = {{0, 0, 0}, {1, 0, 0}, {1, 1, 0}, {0, 1, 0}, {2, 0, 0}, {2, 1, 0}},
               .triangles = {{0, 1, 2}, {0, 2, 3}, {1, 4, 5}, {1, 5, 2}}};
  EXPECT_EQ(PortalsOfMesh(mesh).size(), 2u);
  for (const Portal& portal : PortalsOfMesh(mesh)) ExpectNear(Out(portal), {0, 0, -1});
  mesh.triangles.pop_back();
  ExpectContains(Refusal([&] { PortalsOfMesh(mesh); }), "not made of rectangles");
  mesh.triangles.push_back({1, 5, 3});
  ExpectContains(Refusal([&] { PortalsOfMesh(mesh); }), "not made of rectangles");
  mesh.triangles.assign(2 * kMaxPortals + 2, {0, 1, 2});
  ExpectContains(Refusal([&] { PortalsOfMesh(mesh); }), "130 triangles");
}

// The window of the room is where its portal is: the two see the same rays.
TEST(RoomPortal, IsItsWindow) {
  const Scene scene = ReadScene("room");
  ASSERT_EQ(scene.portals.size(), 1u);
  JobRequest request = {.scene = "room"};
  request.width = 16, request.height = 12, request.samples_per_pixel = 1;
  EXPECT_EQ(RenderJob(scene, request).strategy().name(), "importance");
  ExpectNear(Out(scene.portals[0]), {-1, 0, 0});
  // No corner of a wall lies inside the window, and its own corners are corners of walls.
  const Portal& portal = scene.portals[0];
  for (const glm::vec3 corner :
       {portal.corner, portal.corner + portal.side_x, portal.corner + portal.side_y,
        portal.corner + portal.side_x + portal.side_y}) {
    int walls = 0;
    for (const Mesh& mesh : scene.meshes) {
      for (const glm::vec3& p : mesh.positions) walls += glm::length(p - corner) < 1e-5f;
    }
    EXPECT_GT(walls, 0) << corner.x << " " << corner.y << " " << corner.z;
  }
}

}  // namespace
}  // namespace skywave
