// Tests every BSDF with every transport of light and with strategies that ask for BSDFs: compares
// pictures of bidirectional paths and of light paths with those of camera paths, in one small scene
// per BSDF.
#include <gtest/gtest.h>

#include <cmath>
#include <numbers>
#include <set>
#include <string>
#include <vector>

#include "scene/shapes/mesh.h"
#include "tests/support/bsdf_cases.h"
#include "tests/support/picture_estimate.h"
#include "tests/support/render_scenes.h"
#include "tests/support/statistics.h"
#include "wavefront/render.h"

namespace skywave {
namespace {

constexpr int kRuns = 12;

// Returns one of each BSDF, including a measured one, and a mixture of two.
const std::vector<Material>& Tested() {
  static const std::vector<Material> list = [] {
    std::vector<Material> all = OneOfEachBsdf();
    // With narrower coats, light paths would show nothing except rare flares.
    for (Material& material : all) material.coat_alpha = 0.2f;
    all.push_back({.name = "measured",
                   .bsdf = BsdfKind::kMeasured,
                   .reflectance = glm::vec3(1),
                   .alpha = 0.3f});
    for (const Material& material : BeyondTheBuiltinOnes()) all.push_back(material);
    all.push_back({.name = "mixture", .mixture = Mixture{1, 3, 0.4f}});
    return all;
  }();
  return list;
}
bool IsDelta(const Material& material) { return std::uint32_t(material.bsdf) >= kFirstDeltaBsdf; }

// Returns a floor, a faceted ball and a tile with leaning shading normals, both of the tested
// material, under a smooth environment. At the rim of smooth balls, paths from the two ends would
// use different normals (design.md); the tile leans too little for that.
Scene SceneOf(std::size_t tested) {
  Scene scene;
  scene.materials = Tested();
  scene.measured.push_back({SyntheticMeasuredTable(), 0.3f, 0.5f});
  const auto material = std::uint32_t(tested);
  Place(scene, Quad(1.6f), AddLambert(scene, "floor", {0.7f, 0.6f, 0.5f}), glm::vec3(0));
  Place(scene, Facetted(Sphere(0.5f, 5)), material, {-0.45f, 0.55f, 0});
  Mesh tile = Quad(0.4f);
  tile.normals.assign(tile.positions.size(), glm::normalize(glm::vec3(0.25f, 1, 0.1f)));
  Place(scene, tile, material, {0.7f, 0.3f, 0.2f});
  SetLight(scene, SkyWithSun(64, 32, 1, 0.5));
  scene.camera = LookAtCamera({0.4f, 2.6f, 3.2f}, {0, 0.35f, 0}, {0, 1, 0}, 38, false);
  return scene;
}

PictureEstimate Estimate(const Scene& scene, Integrator integrator, int samples, std::uint32_t seed,
                         const std::string& strategy = "importance") {
  JobRequest request = SmallRequest(24, 18, std::uint32_t(samples));
  request.integrator = integrator;
  request.strategy = strategy;
  request.max_depth = 4;
  return MeanOfBlocks(EstimateFromEngine(RenderJob(scene, request), kRuns, seed), 3);
}
double Level() { return SidakLevel(7 * Tested().size() + 2); }

class TransportBsdfs : public testing::TestWithParam<std::size_t> {};

TEST_P(TransportBsdfs, PicturesMatchPathTracing) {
  Scene scene = SceneOf(GetParam());
  const PictureEstimate paths = Estimate(scene, Integrator::kPath, 64, 1000);
  EXPECT_TRUE(SamePicture(Estimate(scene, Integrator::kBdpt, 24, 100), paths, Level())) << "bdpt";
  if (IsDelta(Tested()[GetParam()])) {
    // Light paths are not seen through these materials, only the light that they cast on the floor.
    scene.camera = LookAtCamera({0.1f, 1.2f, 1.2f}, {0.1f, 0, 1.1f}, {0, 1, 0}, 25, false);
    const PictureEstimate floor = Estimate(scene, Integrator::kPath, 64, 1000);
    EXPECT_TRUE(SamePicture(Estimate(scene, Integrator::kLight, 64, 500), floor, Level()))
        << "light";
  } else {
    EXPECT_TRUE(SamePicture(Estimate(scene, Integrator::kLight, 64, 500), paths, Level()))
        << "light";
  }
}

// Strategies that ask what the surface reflects or lets through, and light paths that start by
// another strategy than the default, where they may.
TEST_P(TransportBsdfs, PicturesMatchOtherStrategies) {
  const Scene scene = SceneOf(GetParam());
  const PictureEstimate paths = Estimate(scene, Integrator::kPath, 64, 1000);
  for (const char* strategy : {"product", "ris"}) {
    EXPECT_TRUE(SamePicture(Estimate(scene, Integrator::kPath, 64, 100, strategy), paths, Level()))
        << strategy;
  }
  for (const char* strategy : {"warp", "uniform", "presampled"}) {
    EXPECT_TRUE(SamePicture(Estimate(scene, Integrator::kBdpt, 24, 300, strategy), paths, Level()))
        << "bdpt, " << strategy;
  }
}

// A floor of hills is seen from low above: many of its normals face away from the eye, which a path
// from a light cannot know when it hits them. The image is coarse because light paths look textures
// up unfiltered.
TEST(Transport, HillsFaceTheEye) {
  Scene scene;
  Image hills(8, 8);
  for (int y = 0; y < 8; ++y) {
    for (int x = 0; x < 8; ++x) {
      float* const normal = hills.Pixel(x, y);
      normal[0] = float(0.5 + 0.25 * std::sin(x * std::numbers::pi / 2));
      normal[1] = float(0.5 + 0.25 * std::cos(y * std::numbers::pi / 2)), normal[2] = 0.9f;
    }
  }
  scene.images = {hills};
  scene.textures = {{.image = 0, .use = TextureUse::kNormals}};
  const std::uint32_t floor = AddLambert(scene, "floor", glm::vec3(0.8f));
  scene.materials[floor].normal_texture = 0;
  Place(scene, Quad(1.5f), floor, glm::vec3(0));
  Place(scene, Facetted(Sphere(0.3f, 4)), AddLambert(scene, "ball", glm::vec3(0.6f)), {0, 0.5f, 0});
  SetLight(scene, SkyWithSun(64, 32, 1, 0.5));
  scene.camera = LookAtCamera({0.2f, 0.5f, 2.6f}, {0, 0.1f, 0}, {0, 1, 0}, 44, false);
  const PictureEstimate paths = Estimate(scene, Integrator::kPath, 64, 1000);
  EXPECT_TRUE(SamePicture(Estimate(scene, Integrator::kBdpt, 24, 100), paths, Level())) << "bdpt";
  EXPECT_TRUE(SamePicture(Estimate(scene, Integrator::kLight, 64, 500), paths, Level())) << "light";
}

INSTANTIATE_TEST_SUITE_P(Each, TransportBsdfs, testing::Range(std::size_t{0}, Tested().size()),
                         [](const auto& test) {
                           std::string name = Tested()[test.param].name;
                           std::erase(name, ' ');
                           return name + std::to_string(test.param);
                         });

TEST(Transport, EveryBsdfIsTested) {
  std::set<BsdfKind> kinds;
  for (const Material& material : Tested()) kinds.insert(material.bsdf);
  EXPECT_EQ(kinds.size(), kBsdfKinds);
}

}  // namespace
}  // namespace skywave
