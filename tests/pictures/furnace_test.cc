// Renders the white furnace: an object that absorbs nothing vanishes in constant light.
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <ostream>
#include <string>

#include "scene/shapes/mesh.h"
#include "tests/support/picture_estimate.h"
#include "tests/support/render_scenes.h"
#include "tests/support/statistics.h"

namespace skywave {
namespace {

#if defined(__SANITIZE_ADDRESS__) || defined(SKYWAVE_CHECKS)
constexpr int kRuns = 4;
#else
constexpr int kRuns = 8;
#endif
constexpr float kRadiance = 0.75f;

struct FurnaceCase {
  std::string name;
  Material material;
  bool smooth;
  // The allowed deviations from 1, beyond noise, of the mean over the ball and of any block of 4 x
  // 4 pixels. They are 0 except as explained at Cases().
  double mean_error, block_error;
};
void PrintTo(const FurnaceCase& test, std::ostream* out) { *out << test.name; }

Material White(BsdfKind bsdf, float alpha = 0.1f) {
  return {.bsdf = bsdf, .reflectance = glm::vec3(1), .alpha = alpha, .ior = 1.5f};
}

class Furnace : public testing::TestWithParam<FurnaceCase> {};

// Returns a ball that fills most of the film.
Scene FurnaceOf(const FurnaceCase& test) {
  Scene scene;
  // The first two are the parts of the mixtures.
  scene.materials = {White(BsdfKind::kLambert), White(BsdfKind::kMirror), test.material};
  const Mesh ball = Sphere(1, 12);
  Place(scene, test.smooth ? ball : Facetted(ball), 2, glm::vec3(0));
  SetConstantLight(scene, kRadiance);
  scene.camera = LookAtCamera({0, 0, 4}, glm::vec3(0), {0, 1, 0}, 32, false);
  return scene;
}

TEST_P(Furnace, BallVanishes) {
  const FurnaceCase& test = GetParam();
  for (const char* const strategy : {"importance", "cosine"}) {
    SCOPED_TRACE(strategy);
    JobRequest request = SmallRequest(24, 24, 64);
    // Total internal reflection keeps some light in faceted glass for thousands of bounces: 0.25 %
    // of the picture takes more than 100.
    request.max_depth = 4000;
    request.strategy = strategy;
    const RenderJob job(FurnaceOf(test), request);
    const PictureEstimate picture = EstimateFromEngine(job, kRuns, 5);
    const double level = SidakLevel(1000);
    for (const int side : {4, 24}) {
      const double allowed = kRadiance * (side == 4 ? test.block_error : test.mean_error);
      const PictureEstimate blocks = MeanOfBlocks(picture, side);
      for (std::size_t i = 0; i < blocks.mean.size(); ++i) {
        const double error = std::sqrt(blocks.variance[i]);
        const double excess = std::max(0.0, std::fabs(blocks.mean[i] - kRadiance) - allowed - 2e-6);
        if (excess == 0) continue;
        EXPECT_GT(error > 0 ? StudentPValue(excess / error, blocks.freedom[i]) : 0, level)
            << side << " pixels, block " << i / 3 << ": " << blocks.mean[i] / kRadiance << " +- "
            << error / kRadiance << ", allowed " << allowed / kRadiance;
      }
    }
  }
}

// Light is lost for these reasons (the bounds are measured deviations, rounded up):
// - Smooth normals: directions above the plane of the interpolated normal but below the triangle's,
//   or vice versa, reflect nothing (kernels/bsdf/bsdf.h), mostly at silhouettes. The test
//   SmoothNormals.LoseLessOnFinerMeshes shows that the mesh is the cause.
// - Conductors: the table of the albedo is interpolated, and the multiple-scattering lobe returns
//   too little or too much by the same amount, at worst near alpha = 0.05, between two rows.
std::vector<FurnaceCase> Cases() {
  constexpr double kSmoothMean = 2.5e-4, kSmoothBlock = 8e-4;
  std::vector<FurnaceCase> cases;
  for (const bool smooth : {false, true}) {
    const std::string shading = smooth ? "Smooth" : "Flat";
    const double mean = smooth ? kSmoothMean : 0, block = smooth ? kSmoothBlock : 0;
    cases.push_back({"Lambert" + shading, White(BsdfKind::kLambert), smooth, mean, block});
    cases.push_back({"Mirror" + shading, White(BsdfKind::kMirror), smooth, 0, 0});
    cases.push_back({"Glass" + shading, White(BsdfKind::kDielectric), smooth, 0, 0});
    cases.push_back({"Clay" + shading, White(BsdfKind::kOrenNayar, 1), smooth, mean, block});
    Material sheet = White(BsdfKind::kDiffuseTransmission);
    sheet.reflectance = glm::vec3(0.4f), sheet.second_color = glm::vec3(0.6f);
    cases.push_back({"Sheet" + shading, sheet, smooth, mean, block});
    cases.push_back({"Shade" + shading, White(BsdfKind::kCoatedDiffuseTransmission, 0.3f), smooth,
                     mean + 2e-3, block + 4e-3});
    Material mixed;
    mixed.mixture = Mixture{0, 1, 0.4f};
    cases.push_back({"Mixture" + shading, mixed, smooth, mean, block});
    mixed.mixture = Mixture{0, 1, -0.0f};  // nothing of the second
    cases.push_back({"MixtureOfOne" + shading, mixed, smooth, mean, block});
    cases.push_back({"Pane" + shading, White(BsdfKind::kThinDielectric), smooth, 0, 0});
    for (const int percent : {1, 5, 10, 20, 40, 70, 100}) {
      const bool narrow = percent <= 10;
      cases.push_back({"Conductor" + std::to_string(percent) + shading,
                       White(BsdfKind::kConductor, float(percent) / 100), smooth,
                       mean + (narrow ? 2e-3 : 5e-4), block + (narrow ? 4e-3 : 1e-3)});
    }
    for (const int percent : {10, 30, 60, 100}) {
      cases.push_back({"RoughGlass" + std::to_string(percent) + shading,
                       White(BsdfKind::kRoughDielectric, float(percent) / 100), smooth, mean + 2e-3,
                       block + 4e-3});
      cases.push_back({"RoughPane" + std::to_string(percent) + shading,
                       White(BsdfKind::kRoughThinDielectric, float(percent) / 100), smooth,
                       mean + 2e-3, block + 4e-3});
      Material brushed = White(BsdfKind::kAnisotropicConductor, float(percent) / 100);
      brushed.alpha_across = 0.5f;
      cases.push_back({"Brushed" + std::to_string(percent) + shading, brushed, smooth, mean + 5e-3,
                       block + 1e-2});
    }
  }
  return cases;
}

INSTANTIATE_TEST_SUITE_P(White, Furnace, testing::ValuesIn(Cases()),
                         [](const auto& test) { return test.param.name; });

// A slab with the index of air absorbs according to the length of the path through it (Beer and
// Lambert).
TEST(AbsorbingGlass, AbsorbsByItsThickness) {
  const glm::vec3 absorption(0.7f, 0, 2.5f);
  for (const BsdfKind bsdf : {BsdfKind::kDielectric, BsdfKind::kLambert}) {
    Scene scene;
    Material glass = White(bsdf);
    glass.ior = 1, glass.absorption = absorption;
    scene.materials = {glass};
    const Mesh face = Facetted(Quad(9));
    Place(scene, face, 0, {0, 0.4f, 0});
    Mesh below = face;
    FlipOrientation(below);
    Place(scene, below, 0, {0, -0.4f, 0});
    SetConstantLight(scene, kRadiance);
    scene.camera = LookAtCamera({0, 3, 4}, glm::vec3(0), {0, 1, 0}, 0.01f, false);
    const RenderJob job(scene, SmallRequest(4, 4, 16));
    const PictureEstimate whole = MeanOfBlocks(EstimateFromEngine(job, 2, 5), 4);
    for (int c = 0; c < 3; ++c) {
      // The central ray crosses 0.8 at a slope of 3 in 5.
      const double passes = bsdf == BsdfKind::kLambert ? 1 : std::exp(-absorption[c] * 0.8 * 5 / 3);
      EXPECT_NEAR(whole.mean[c] / kRadiance, passes, bsdf == BsdfKind::kLambert ? 0.05 : 1e-3);
    }
  }
}

TEST(SmoothNormals, LoseLessOnFinerMeshes) {
  double before = 1;
  for (const int frequency : {3, 6, 12, 24}) {
    Scene scene;
    scene.materials.push_back(White(BsdfKind::kLambert));
    Place(scene, Sphere(1, frequency), 0, glm::vec3(0));
    SetConstantLight(scene, kRadiance);
    scene.camera = LookAtCamera({0, 0, 4}, glm::vec3(0), {0, 1, 0}, 28, false);
    JobRequest request = SmallRequest(24, 24, 64);
    request.strategy = "cosine";  // exact except for the losses
    const RenderJob job(scene, request);
    const PictureEstimate whole = MeanOfBlocks(EstimateFromEngine(job, kRuns, 5), 24);
    const double loss = 1 - whole.mean[0] / kRadiance;
    EXPECT_GE(loss, 0) << frequency;
    EXPECT_LT(loss, 0.5 * before) << frequency;
    before = loss;
  }
  EXPECT_LT(before, 1e-4);
}

}  // namespace
}  // namespace skywave
