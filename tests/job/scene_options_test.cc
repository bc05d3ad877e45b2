// Tests the options that choose and change what a scene file has: its cameras, a turn of the camera
// about the scene, and its materials.
#include <gtest/gtest.h>

#include <functional>

#include "base/error.h"
#include "job/choose_camera.h"
#include "job/material_changes.h"
#include "scene/gltf/reader.h"
#include "scene/scene_hash.h"
#include "tests/support/expect_near.h"
#include "tests/support/gltf_document.h"

namespace skywave {
namespace {

const Bounds kBounds = {{-1, 0, -1}, {3, 2, 1}};  // its middle is (1, 1, 0)

glm::vec3 Eye(const Camera& camera) { return glm::vec3(camera.world_from_camera[3]); }
glm::vec3 View(const Camera& camera) { return glm::vec3(camera.world_from_camera[2]); }

Camera Choose(const Scene& scene, const CameraRequest& request) {
  return ChooseCamera(scene, kBounds, request, 1.5f);
}

std::string Refusal(const std::function<void()>& call) {
  try {
    call();
  } catch (const OptionError& error) {
    EXPECT_EQ(error.exit_code(), kExitUsage);
    return error.what();
  }
  return "";
}

// Seen from the tip of +y, with x to the right, +z is at the bottom; from there a quarter turn
// counter-clockwise leads to +x.
TEST(Orbit, TurnsCounterClockwiseSeenFromAbove) {
  CameraRequest request = {.eye = glm::vec3(1, 3, 5), .target = glm::vec3(1, 1, 0)};
  request.orbit_degrees = 90.0f;
  const Camera y_up = Choose({}, request);
  ExpectNear(Eye(y_up), {6, 3, 0});
  ExpectNear(View(y_up), glm::normalize(glm::vec3(-5, -2, 0)));
  // With z up, a quarter turn leads from -y to +x.
  Scene scene;
  scene.up_axis = 'z';
  request = {.eye = glm::vec3(0, -4, 1), .target = glm::vec3(0)};
  request.orbit_degrees = 90.0f;
  ExpectNear(Eye(Choose(scene, request)), {4, 0, 1});
  // In a left-handed world with y up, seen from above x is to the right and +z at the top.
  scene.up_axis = 'y';
  scene.left_handed = true;
  request = {.eye = glm::vec3(0, 1, -4), .target = glm::vec3(0)};
  request.orbit_degrees = 90.0f;
  ExpectNear(Eye(Choose(scene, request)), {4, 1, 0});
}

glm::vec3 Up(const Camera& camera) {
  return glm::normalize(glm::vec3(camera.world_from_camera[1]));
}

TEST(Up, IsUpInThePicture) {
  CameraRequest request = {.eye = glm::vec3(0, 0, 5), .target = glm::vec3(0)};
  request.up = glm::vec3(3, 0, 1);
  ExpectNear(Up(Choose({}, request)), {1, 0, 0});
  ExpectNear(View(Choose({}, request)), {0, 0, -1});
  // The camera of a scene keeps its place and view.
  const Scene with_camera = {.camera = LookAtCamera({2, 1, 7}, {2, 1, 0}, {0, 1, 0}, 30, false)};
  request = {};
  request.up = glm::vec3(0, -2, 0);
  ExpectNear(Eye(Choose(with_camera, request)), {2, 1, 7});
  ExpectNear(View(Choose(with_camera, request)), {0, 0, -1});
  ExpectNear(Up(Choose(with_camera, request)), {0, -1, 0});
  request.up = glm::vec3(0, 0, 3);
  EXPECT_NE(Refusal([&] { Choose(with_camera, request); }).find("up"), std::string::npos);
  request.up = glm::vec3(0);
  EXPECT_NE(Refusal([&] { Choose(with_camera, request); }).find("no direction"), std::string::npos);
}

// A camera that looks straight down has the middle of the map at the top of its picture.
TEST(Up, NeedsNothingToLookStraightDown) {
  CameraRequest request = {.eye = glm::vec3(0, 5, 0), .target = glm::vec3(0)};
  const Camera down = Choose({}, request);
  ExpectNear(View(down), {0, -1, 0});
  ExpectNear(Up(down), EnvironmentFrame('y', false, 0)[1]);
  Scene scene;
  scene.up_axis = 'z';
  request = {.eye = glm::vec3(0, 0, -5), .target = glm::vec3(0)};
  ExpectNear(View(Choose(scene, request)), {0, 0, 1});
  request.target = request.eye;
  EXPECT_NE(Refusal([&] { Choose(scene, request); }).find("look somewhere"), std::string::npos);
}

// Clockwise as the camera looks: what was up is then on its right.
TEST(Roll, TurnsTheCameraClockwise) {
  CameraRequest request = {.eye = glm::vec3(0, 0, 5), .target = glm::vec3(0)};
  request.roll_degrees = 90.0f;
  const Camera rolled = Choose({}, request);
  ExpectNear(Up(rolled), {1, 0, 0});
  ExpectNear(glm::vec3(rolled.world_from_camera[0]), {0, -1, 0});
  ExpectNear(View(rolled), {0, 0, -1});
  ExpectNear(Eye(rolled), {0, 0, 5});
}

TEST(Orbit, TurnsAboutTheTargetOrTheMiddleOfTheScene) {
  CameraRequest request = {.eye = glm::vec3(1, 1, 5)};
  request.orbit_degrees = 180.0f;
  ExpectNear(Eye(Choose({}, request)), {1, 1, -5});
  request.target = glm::vec3(2, 0, 0);
  ExpectNear(Eye(Choose({}, request)), {3, 1, -5});
  // The scene's own camera and the automatic one turn about the middle too.
  const Scene with_camera = {.camera = LookAtCamera({1, 1, 7}, {0, 1, 0}, {0, 1, 0}, 30, false)};
  request = {};
  request.orbit_degrees = -90.0f;
  ExpectNear(Eye(Choose(with_camera, request)), {-6, 1, 0});
  const Camera automatic = Choose({}, {});
  ExpectNear(Eye(Choose({}, request)),
             {1 - Eye(automatic).z, Eye(automatic).y, Eye(automatic).x - 1}, 1e-4f);
}

TEST(Orbit, FourQuarterTurnsReturnToTheStart) {
  Scene scene = {.camera = LookAtCamera({3, 4, 5}, {0, 1, 0}, {0, 1, 0}, 30, false)};
  const glm::mat4 start = scene.camera->world_from_camera;
  CameraRequest quarter;
  quarter.orbit_degrees = 90.0f;
  for (int i = 0; i < 4; ++i) scene.camera = Choose(scene, quarter);
  for (int column = 0; column < 4; ++column) {
    ExpectNear(glm::vec3(scene.camera->world_from_camera[column]), glm::vec3(start[column]));
  }
  quarter.orbit_degrees = 0.0f;
  scene.camera->world_from_camera = start;
  EXPECT_EQ(Choose(scene, quarter).world_from_camera, start) << "no turn changes no bit";
}

// The distance in focus follows from the eye and the target, which keep their distance.
TEST(Orbit, KeepsEverythingElseOfTheCamera) {
  CameraRequest request = {.eye = glm::vec3(1, 3, 5), .target = glm::vec3(1, 1, 0)};
  request.fov_degrees = 33.0f;
  request.lens_radius = 0.25f;
  const Camera before = Choose({}, request);
  request.orbit_degrees = 77.0f;
  const Camera after = Choose({}, request);
  EXPECT_EQ(after.fov_degrees, 33);
  EXPECT_EQ(after.lens_radius, before.lens_radius);
  EXPECT_EQ(after.focal_distance, before.focal_distance);
}

// The options of a lens are in units of the world, however a file has scaled its camera.
TEST(Lens, OfAScaledCameraIsInUnitsOfTheWorld) {
  Camera camera = LookAtCamera({1, 1, 9}, {1, 1, 0}, {0, 1, 0}, 30, false);
  camera.world_from_camera[0] *= 2.0f, camera.world_from_camera[1] *= 2.0f;
  camera.world_from_camera[2] *= 4.0f;
  const Scene scene = {.camera = camera};
  CameraRequest request;
  request.lens_radius = 0.25f;
  const auto distance = [](const Camera& of) {
    return of.focal_distance * glm::length(glm::vec3(of.world_from_camera[2]));
  };
  const Camera automatic = Choose(scene, request);
  EXPECT_FLOAT_EQ(automatic.lens_radius * glm::length(glm::vec3(automatic.world_from_camera[0])),
                  0.25f);
  EXPECT_FLOAT_EQ(distance(automatic), 9) << "that of the middle of the scene";
  request.focal_distance = 3.0f;
  EXPECT_FLOAT_EQ(distance(Choose(scene, request)), 3);
  // What lies behind the camera cannot be sharp.
  request.focal_distance.reset();
  request.eye = glm::vec3(1, 1, 5), request.target = glm::vec3(1, 1, 9);
  EXPECT_EQ(Choose(scene, request).focal_distance, Camera().focal_distance);
}

// A file of glTF describes a view, which the film shows whole; an angle that is asked for is across
// the shorter side of the film, whatever that view was.
TEST(SceneCamera, AnAngleIsAcrossTheFilmAndNotAcrossTheViewOfTheFile) {
  GltfDocument document = TriangleDocument();
  document.json["cameras"][0]["perspective"]["aspectRatio"] = 3;
  const Scene scene = ParseGltf(document.text(), "a.gltf");
  CameraRequest request;
  ASSERT_TRUE(Choose(scene, request).window);
  EXPECT_EQ(Choose(scene, request).window->right, 3);
  request.fov_degrees = 40.0f;
  EXPECT_FALSE(Choose(scene, request).window);
  EXPECT_EQ(Choose(scene, request).fov_degrees, 40);
}

TEST(SceneCamera, IsFoundByItsName) {
  const Scene scene = ParseGltf(TriangleDocument().text(), "a.gltf");
  CameraRequest request;
  ExpectNear(Eye(Choose(scene, request)), {5.25f, 0.25f, 4});
  request.name = "side";
  const Camera side = Choose(scene, request);
  ExpectNear(Eye(side), {4, 1, 3});
  EXPECT_NEAR(side.fov_degrees, glm::degrees(0.5f), 1e-4f);
  request.name = "sied";
  EXPECT_EQ(Refusal([&] { Choose(scene, request); }),
            "scene-camera sied: there is no such camera; there are side, front");
  EXPECT_NE(Refusal([&] { Choose({}, request); }), "");
}

Scene Painted() {
  Scene scene;
  scene.materials = {{.name = "paint", .reflectance = {0.5f, 0.25f, 1}, .color_texture = 0u},
                     {.name = "a=b", .bsdf = BsdfKind::kDielectric, .ior = 1.25f},
                     {.name = "paint", .bsdf = BsdfKind::kConductor, .alpha = 0.5f},
                     {.name = "both", .mixture = Mixture{0, 1, 0.5f}}};
  scene.images.push_back(Image(1, 1));
  scene.textures.push_back({.image = 0});
  return scene;
}

std::uint64_t HashOf(const Material& material) { return SceneHash({.materials = {material}}); }

TEST(MaterialChanges, GiveEveryMaterialOfTheNameANewBsdf) {
  const Scene before = Painted();
  Scene scene = before;
  ChangeMaterials({"paint=conductor:alpha=0.25,reflectance=0.9/0.5/0.125"}, scene);
  for (const std::size_t changed : {0u, 2u}) {
    const Material& material = scene.materials[changed];
    EXPECT_EQ(material.name, "paint");
    EXPECT_EQ(material.bsdf, BsdfKind::kConductor);
    EXPECT_EQ(material.alpha, 0.25f);
    EXPECT_EQ(material.reflectance, glm::vec3(0.9f, 0.5f, 0.125f));
    EXPECT_FALSE(material.color_texture) << "a new material has no textures";
  }
  for (const std::size_t other : {1u, 3u}) {
    EXPECT_EQ(HashOf(scene.materials[other]), HashOf(before.materials[other]));
  }
  EXPECT_NE(SceneHash(scene), SceneHash(before));
}

TEST(MaterialChanges, WithoutABsdfOtherParametersAreKept) {
  Scene scene = Painted();
  ChangeMaterials({"paint=:reflectance=0.75", " a=b=:ior=1.75 ", "a=b=:absorption=1/2/3"}, scene);
  EXPECT_EQ(scene.materials[0].reflectance, glm::vec3(0.75f)) << "one number is grey";
  EXPECT_EQ(scene.materials[0].color_texture, 0u);
  EXPECT_EQ(scene.materials[2].alpha, 0.5f);
  EXPECT_EQ(scene.materials[2].bsdf, BsdfKind::kConductor);
  EXPECT_EQ(scene.materials[1].ior, 1.75f) << "the name has the sign that ends it";
  EXPECT_EQ(scene.materials[1].absorption, glm::vec3(1, 2, 3));
}

TEST(MaterialChanges, TheLongestMatchingNameCounts) {
  Scene scene = Painted();
  scene.materials.push_back({.name = "a", .bsdf = BsdfKind::kDielectric, .ior = 2});
  ChangeMaterials({"a=b=:ior=1.75"}, scene);
  EXPECT_EQ(scene.materials[1].ior, 1.75f);
  EXPECT_EQ(scene.materials[4].ior, 2);
  ChangeMaterials({"a=:ior=3"}, scene);
  EXPECT_EQ(scene.materials[1].ior, 1.75f);
  EXPECT_EQ(scene.materials[4].ior, 3);
}

// Without compensation rough metal is that of two widths, which are equal: it draws no other lobe.
TEST(MaterialChanges, CompensationCanBeLeftOut) {
  Scene scene = Painted();
  scene.materials.push_back({.bsdf = BsdfKind::kConductor, .alpha = 0.5f, .roughness_texture = 0u});
  LeaveOutCompensation(scene);
  for (const Material& material : scene.materials) EXPECT_FALSE(material.energy_compensation);
  EXPECT_EQ(scene.materials[1].bsdf, BsdfKind::kDielectric);
  EXPECT_EQ(scene.materials[2].bsdf, BsdfKind::kAnisotropicConductor);
  EXPECT_EQ(scene.materials[2].alpha, 0.5f);
  EXPECT_EQ(scene.materials[2].alpha_across, 0.5f);
  EXPECT_EQ(scene.materials[4].bsdf, BsdfKind::kConductor) << "its widths are those of an image";
}

TEST(MaterialChanges, InvalidChangesAreRefused) {
  const std::pair<const char*, const char*> cases[] = {
      {"pant=lambert", "no material 'pant'; it has paint, "},
      {"paint=lambrt", "there is no 'lambrt'; there are lambert, "},
      {"paint=conductor:alpa=1", "alpa: the material has no such parameter; it has alpha, "},
      {"paint=conductor:ior=1.5", "ior: the material has no such parameter"},
      {"paint=conductor:alpha=3", "3 is not a number from 0 to 1"},
      {"paint=conductor:alpha=x", "'x' is not a number"},
      {"paint=conductor:alpha=", "'' is not a number"},
      {"paint=conductor:alpha", "'alpha' is not KEY=VALUE"},
      {"paint=conductor:", "'' is not KEY=VALUE"},
      {"paint=conductor:reflectance=0.1/0.2", "takes 3 values, not 2"},
      {"paint=lambert:color_texture=9", "texture does not exist"},
      {"paint=", "names no BSDF and no parameter"},
      {"paint", "is not NAME=BSDF"},
      {"", "is not NAME=BSDF"},
      {"both=:reflectance=1", "is a mixture"},
  };
  for (const auto& [change, why] : cases) {
    Scene scene = Painted();
    const std::string message = Refusal([&, change = change] { ChangeMaterials({change}, scene); });
    EXPECT_NE(message.find(why), std::string::npos) << change << ": " << message;
    EXPECT_EQ(message.rfind("material", 0), 0u) << message;
  }
}

TEST(MaterialChanges, ValuesOutOfRangeAreRefused) {
  Scene scene = Painted();
  ChangeMaterials({"paint=coated-diffuse:coat_asymmetry=-0.5,normal_scale=-2"}, scene);
  EXPECT_EQ(scene.materials[0].coat_asymmetry, -0.5f);
  EXPECT_EQ(scene.materials[0].normal_scale, -2);
  for (const char* const change :
       {"paint=coated-diffuse:coat_asymmetry=-1.5", "paint=conductor:alpha=-0.25",
        "paint=lambert:emission=-1", "a=b=:ior=0", "paint=lambert:opacity=1.5"}) {
    Scene same = Painted();
    EXPECT_NE(Refusal([&] { ChangeMaterials({change}, same); }).find("is not a number from"),
              std::string::npos)
        << change;
  }
}

}  // namespace
}  // namespace skywave
