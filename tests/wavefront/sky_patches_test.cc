// Tests the patches of a sky: numbers and sizes are those of their authors, and the layers of a
// picture are what a map with one bright patch brings.
#include "wavefront/film/sky_patches.h"

#include <gtest/gtest.h>

#include <cmath>
#include <numbers>
#include <string>
#include <vector>

#include "tests/support/film_layers.h"
#include "tests/support/refused.h"
#include "tests/support/render_scenes.h"
#include "wavefront/film/light_groups.h"
#include "wavefront/policies/control_pilot.h"

namespace skywave {
namespace {

// North is +y and up +z.
std::uint32_t PatchAt(SkyDivision division, double altitude, double azimuth) {
  const double h = altitude * std::numbers::pi / 180, a = azimuth * std::numbers::pi / 180;
  return PatchOf({.division = division}, float(std::cos(h) * std::sin(a)),
                 float(std::cos(h) * std::cos(a)), float(std::sin(h)));
}

TEST(SkyPatches, AreNumberedAsTregenzaAndRadianceDo) {
  constexpr SkyDivision kDivision = SkyDivision::kTregenza;
  EXPECT_EQ(CountPatches(kDivision), 146u);
  EXPECT_EQ(PatchAt(kDivision, -1, 77), 0u);
  EXPECT_EQ(PatchAt(kDivision, 6, 0), 1u);    // due north, in the middle of its patch
  EXPECT_EQ(PatchAt(kDivision, 6, 5.9), 1u);  // 12 degrees wide
  EXPECT_EQ(PatchAt(kDivision, 6, -5.9), 1u);
  EXPECT_EQ(PatchAt(kDivision, 6, 6.1), 2u);     // on to the east
  EXPECT_EQ(PatchAt(kDivision, 6, 90), 1u + 8);  // 7.5 patches: the ninth begins at 90
  EXPECT_EQ(PatchAt(kDivision, 11.9, 348), 30u);
  EXPECT_EQ(PatchAt(kDivision, 12.1, 0), 31u);
  EXPECT_EQ(PatchAt(kDivision, 30, 0), 61u);     // rows of 24 from 24 degrees on
  EXPECT_EQ(PatchAt(kDivision, 83.9, 0), 139u);  // the row of 6
  EXPECT_EQ(PatchAt(kDivision, 84.1, 200), 145u);
  EXPECT_EQ(PatchAt(kDivision, 90, 0), 145u);
}

TEST(SkyPatches, OfReinhartHalveTheSides) {
  constexpr SkyDivision kDivision = SkyDivision::kReinhart;
  EXPECT_EQ(CountPatches(kDivision), 578u);
  constexpr double kRow = 90 / 14.5;
  EXPECT_EQ(PatchAt(kDivision, 0.5 * kRow, 0), 1u);
  EXPECT_EQ(PatchAt(kDivision, 0.5 * kRow, 6), 2u);
  EXPECT_EQ(PatchAt(kDivision, 1.5 * kRow, 0), 61u);
  EXPECT_EQ(PatchAt(kDivision, 13.9 * kRow, 0), 577u - 12);
  EXPECT_EQ(PatchAt(kDivision, 14.1 * kRow, 0), 577u);
  EXPECT_EQ(CountPatches(SkyDivision::kNone), 0u);
  EXPECT_EQ(PatchAt(SkyDivision::kNone, 50, 50), 0u);
}

// The share of each patch among directions of equal density is its solid angle over the sphere's.
TEST(SkyPatches, CoverTheSkyByTheirSolidAngles) {
  for (const SkyDivision division : {SkyDivision::kTregenza, SkyDivision::kReinhart}) {
    constexpr int kSide = 2000;
    std::vector<double> share(CountPatches(division));
    for (int i = 0; i < kSide; ++i) {
      const double z = (i + 0.5) / kSide;
      for (int k = 0; k < kSide; ++k) {
        const double phi = 2 * std::numbers::pi * (k + 0.5) / kSide, r = std::sqrt(1 - z * z);
        share[PatchOf({.division = division}, float(r * std::cos(phi)), float(r * std::sin(phi)),
                      float(z))] += 1.0 / kSide / kSide;
      }
    }
    const double rows = 7 * double(division);
    const double height = std::numbers::pi / 2 / (rows + 0.5);
    EXPECT_EQ(share[0], 0);
    EXPECT_NEAR(share[1], std::sin(height) / (30 * double(division)), 0.03 * share[1]);
    EXPECT_NEAR(share.back(), 1 - std::cos(height / 2), 0.03 * share.back());
    for (std::size_t i = 1; i < share.size(); ++i) EXPECT_GT(share[i], 0.3 / double(share.size()));
  }
}

// A floor below a sky that is bright in one patch: what its layer brings with a white sky is what
// that sky brings, in the mean over the picture.
TEST(SkyPatches, LayersAreTheLightOfTheirPatches) {
  Scene scene;
  const std::uint32_t floor = AddLambert(scene, "floor", glm::vec3(0.5f));
  Place(scene, Quad(5), floor, glm::vec3(0));
  Place(scene, Sphere(0.5f), floor, {0, 0.5f, 0});
  scene.camera = LookAtCamera({0, 6, 0.5f}, {0, 0, 0}, {0, 1, 0}, 40, false);
  SetConstantLight(scene, 1);
  JobRequest request = SmallRequest(16, 12, 4096);  // few samples see one patch of 146
  request.sky_patches = SkyDivision::kTregenza;
  const Layers white = Resolve(RenderJob(scene, request));
  ASSERT_EQ(white.size(), 3u * 146);
  const auto mean = [&](const Layers& layers, const std::string& name) {
    double sum = 0;
    for (const float value : layers.at(name)) sum += value;
    return sum / double(layers.at(name).size());
  };
  double all = 0;
  for (const auto& [name, values] : white) all += name.back() == 'G' ? mean(white, name) : 0;
  EXPECT_GT(all, 0.3);
  // A map whose texels are 1 in one patch; its middle is in the north, its right half in the east.
  for (const std::uint32_t patch : {3u, 40u, 100u, 145u}) {
    Image map(360, 180);
    for (int y = 0; y < 180; ++y) {
      for (int x = 0; x < 360; ++x) {
        const std::uint32_t at = PatchAt(SkyDivision::kTregenza, 89.5 - y, x + 0.5 - 180);
        for (int c = 0; c < 3; ++c) map.Pixel(x, y)[c] = at == patch;
      }
    }
    Scene lit = scene;
    SetLight(lit, map);
    JobRequest plain = SmallRequest(16, 12, 64);
    const RenderJob job(lit, plain);
    const Image image = Render(job).Resolve(64);
    double expected = 0;
    for (std::size_t i = 1; i < image.rgb.size(); i += 3) expected += image.rgb[i] / (16 * 12.0);
    char name[32];
    std::snprintf(name, sizeof name, "lights-sky-%03u.G", patch);
    // The map's texels round the borders of the patch, and the white sky is sampled everywhere.
    EXPECT_NEAR(mean(white, name), expected, 0.06 * expected) << patch;
  }
}

TEST(SkyPatches, DoNotGoWithAControlVariate) {
  JobRequest request = SmallRequest(8, 6, 1);
  request.sky_patches = SkyDivision::kTregenza;
  request.options.of<ControlOptions>().control = ControlVariate::kIrradiance;
  Scene scene;
  Place(scene, Quad(5), AddLambert(scene, "floor", glm::vec3(0.5f)), glm::vec3(0));
  SetConstantLight(scene, 1);
  ExpectRefused(scene, request, "control");
}

}  // namespace
}  // namespace skywave
