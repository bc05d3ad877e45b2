// Renders scenes far from (0, 0, 0) of their files' worlds, at 10^4 times their size, where floats
// are a thousandth of it apart: their pictures are those of the same scenes at (0, 0, 0), and their
// places those of the file.
#include <fmt/format.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <functional>
#include <string>

#include "image/image.h"
#include "job/job.h"
#include "job/portals.h"
#include "scene/reader.h"
#include "tests/support/film_layers.h"
#include "tests/support/gltf_document.h"
#include "tests/support/temporary_folder.h"

namespace skywave {
namespace {

const glm::dvec3 kFar = {20011.3, -10007.7, 30003.1};

std::string Text(const glm::dvec3& p) {
  return fmt::format("{:.17g} {:.17g} {:.17g}", p.x, p.y, p.z);
}

// A file of every kind of thing that has a place. `at` is where its middle is.
std::string PbrtText(const glm::dvec3& at) {
  return fmt::format(R"(
LookAt {} {} 0 1 0
Camera "perspective" "float fov" 40
WorldBegin
LightSource "infinite" "rgb L" [1 1 1]
LightSource "point" "rgb I" [2 2 1] "point3 from" [{}]
ObjectBegin "ball"
  Material "diffuse"
  Shape "sphere" "float radius" 0.2
ObjectEnd
Translate {}
LightSource "point" "rgb I" [1 2 2] "point3 from" [-1 2 -2]
Texture "cubes" "spectrum" "checkerboard" "integer dimension" 3
  "rgb tex1" [0.1 0.2 0.9] "rgb tex2" [0.9 0.7 0.1]
Material "diffuse" "texture reflectance" "cubes"
Shape "trianglemesh" "point3 P" [-1.3 0 -1.3 1.3 0 -1.3 1.3 0 1.3 -1.3 0 1.3]
  "integer indices" [0 2 1 0 3 2]
AttributeBegin
  Translate 0.3 0.4 -0.2
  Shape "sphere" "float radius" 0.3
AttributeEnd
Translate -0.5 0.3 0.1
ObjectInstance "ball"
)",
                     Text(at + glm::dvec3(1, 2, -3)), Text(at + glm::dvec3(0, 0.2, 0)),
                     Text(at + glm::dvec3(1, 2, 1)), Text(at));
}

// A roof over a floor.
const glm::dvec3 kCorners[] = {{-1, 0, -1},  {1, 0, -1},     {1, 0, 1},      {-1, 0, 1},
                               {-.5, .3, 0}, {.4, .45, -.6}, {.45, .35, .55}};
constexpr int kFaces[][3] = {{0, 2, 1}, {0, 3, 2}, {4, 6, 5}};

std::string ObjText(const glm::dvec3& at) {
  std::string text = "# a roof\n";
  for (const glm::dvec3& corner : kCorners) text += "v  " + Text(at + corner) + " # corner\n";
  for (const auto& face : kFaces) {
    text += fmt::format("f {} {} {}\n", face[0] + 1, face[1] + 1, face[2] + 1);
  }
  return text;
}

std::string PlyText(const glm::dvec3& at) {
  std::string text = fmt::format(
      "ply\nformat ascii 1.0\nelement vertex {}\nproperty double x\nproperty double y\n"
      "property double z\nelement face {}\nproperty list uchar int vertex_indices\nend_header\n",
      std::size(kCorners), std::size(kFaces));
  for (const glm::dvec3& corner : kCorners) text += Text(at + corner) + "\n";
  for (const auto& face : kFaces) text += fmt::format("3 {} {} {}\n", face[0], face[1], face[2]);
  return text;
}

// The floor is in the node of a parent, and the roof in two places.
std::string GltfText(const glm::dvec3& at) {
  GltfDocument document;
  const auto add_mesh = [&](std::size_t first_face, std::size_t faces) {
    std::vector<float> places;
    for (std::size_t f = first_face; f < first_face + faces; ++f) {
      for (const int corner : kFaces[f]) {
        for (int axis = 0; axis < 3; ++axis) places.push_back(float(kCorners[corner][axis]));
      }
    }
    document.json["meshes"].push_back(
        {{"primitives", {{{"attributes", {{"POSITION", document.Add(places, "VEC3")}}}}}}});
  };
  add_mesh(0, 2), add_mesh(2, 1);
  document.json["nodes"] = {{{"translation", {at.x, at.y, at.z}}, {"children", {1, 2, 3}}},
                            {{"mesh", 0}},
                            {{"mesh", 1}},
                            {{"mesh", 1}, {"translation", {0.2, 0.2, 0.1}}}};
  document.json["scenes"] = {{{"nodes", {0}}}};
  return document.text();
}

struct FarScene {
  const char* file;
  std::string (*text)(const glm::dvec3& at);
  bool has_camera;
};
constexpr FarScene kScenes[] = {{"a.pbrt", PbrtText, true},
                                {"a.obj", ObjText, false},
                                {"a.ply", PlyText, false},
                                {"a.gltf", GltfText, false}};

constexpr int kSize = 48;

class FarScenes : public testing::TestWithParam<FarScene> {
 protected:
  JobRequest RequestAt(const glm::dvec3& at, InstanceUse instances = InstanceUse::kAuto) const {
    JobRequest request;
    request.scene = folder_.Write(GetParam().file, GetParam().text(at));
    request.read.instances = instances;
    request.width = request.height = kSize;
    request.samples_per_pixel = 16;
    request.strategy = "cosine";
    request.max_depth = 3;
    request.options.aovs = ParseAovs("position,depth").value();
    if (GetParam().has_camera) return request;
    request.environment.path = folder_.Path("white.pfm");
    Image white(4, 2);
    std::fill(white.rgb.begin(), white.rgb.end(), 1.0f);
    WritePfm(request.environment.path, white);
    request.camera.eye = at + glm::dvec3(1, 2, 3);
    request.camera.target = at + glm::dvec3(0, 0.2, 0);
    return request;
  }

  TemporaryFolder folder_;
};

double RmsOfDifferences(const Image& a, const Image& b) {
  double sum = 0;
  for (std::size_t i = 0; i < a.rgb.size(); ++i) sum += std::pow(double(a.rgb[i] - b.rgb[i]), 2);
  return std::sqrt(sum / double(a.rgb.size()));
}

TEST_P(FarScenes, LookAsTheyDoAtTheOrigin) {
  for (const InstanceUse use : {InstanceUse::kCopy, InstanceUse::kShare}) {
    const RenderJob near(RequestAt(glm::dvec3(0), use)), far(RequestAt(kFar, use));
    const Image expected = Render(near).Resolve(16), picture = Render(far).Resolve(16);
    EXPECT_LE(RmsOfDifferences(picture, expected), 0.002) << GetParam().file;
    EXPECT_GT(*std::max_element(expected.rgb.begin(), expected.rgb.end()), 0.2);
  }
}

TEST_P(FarScenes, HaveThePlacesOfTheirFiles) {
  const RenderJob near(RequestAt(glm::dvec3(0))), far(RequestAt(kFar));
  const Layers expected = Resolve(near), layers = Resolve(far);
  int hits = 0;
  for (std::size_t i = 0; i < std::size_t(kSize) * kSize; ++i) {
    const double depth = double(expected.at("depth.Z")[i]);
    if (depth > 10 || layers.at("depth.Z")[i] > 10) continue;
    ++hits;
    EXPECT_NEAR(layers.at("depth.Z")[i], depth, 0.05);
    int axis = 0;
    for (const char* const channel : {"position.X", "position.Y", "position.Z"}) {
      EXPECT_NEAR(layers.at(channel)[i], double(expected.at(channel)[i]) + kFar[axis++], 0.05);
    }
  }
  EXPECT_GT(hits, kSize * kSize / 4);

  const Scene scene = ReadScene(folder_.Path(GetParam().file));
  const Bounds bounds = BoundsInWorld(scene, TriangleBounds(scene));
  EXPECT_LT(glm::length(PlaceInScene(scene, kFar)), 2);
  EXPECT_NEAR(bounds.low.x, kFar.x - (GetParam().has_camera ? 1.3 : 1), 0.01);
  EXPECT_NEAR(bounds.high.z, kFar.z + (GetParam().has_camera ? 1.3 : 1), 0.01);
}

INSTANTIATE_TEST_SUITE_P(Formats, FarScenes, testing::ValuesIn(kScenes),
                         [](const auto& scene) { return std::string(scene.param.file + 2); });

// The file of a scene that is not far is read once, and its numbers are kept.
TEST(NearScenes, KeepTheirOrigin) {
  const TemporaryFolder folder;
  const Scene scene = ReadScene(folder.Write("a.obj", ObjText({30, -20, 50})));
  EXPECT_EQ(scene.origin, glm::dvec3(0));
  EXPECT_EQ(scene.meshes[0].positions[0], glm::vec3(29, -20, 49));
}

TEST(FarPortals, StandWhereTheirNumbersSay) {
  const TemporaryFolder folder;
  Scene scene = ReadScene(folder.Write("a.obj", ObjText(kFar)));
  std::string corners;
  for (const glm::dvec3& corner :
       {glm::dvec3(-1, 2, -1), glm::dvec3(1, 2, -1), glm::dvec3(1, 2, 1), glm::dvec3(-1, 2, 1)}) {
    const glm::dvec3 p = kFar + corner;
    corners += fmt::format("{}{},{},{}", corners.empty() ? "" : ",", p.x, p.y, p.z);
  }
  AddPortals({corners}, scene);
  ASSERT_EQ(scene.portals.size(), 1u);
  const glm::vec3 expected = PlaceInScene(scene, kFar + glm::dvec3(0, 2, 0));
  EXPECT_NEAR(scene.portals[0].corner.y, expected.y, 1e-4);
  EXPECT_LT(std::abs(scene.portals[0].corner.x), 2);
}

}  // namespace
}  // namespace skywave
