// An infinite light of one colour, as light samples find it.
#include <gtest/gtest.h>

#include <string>
#include <vector>

#include "job/environment.h"
#include "lights/maps/environment_map.h"
#include "lights/tables/inversion_table.h"
#include "lights/tables/texels.h"

namespace skywave {
namespace {

// Colours that no single texel of nine bits holds: like a blackbody of 2000 K, mostly blue, grey.
constexpr glm::vec3 kColours[] = {{1, 0.37f, 0.0093f}, {0.011f, 0.0351f, 7}, {0.3f, 0.3f, 0.3f}};

EnvironmentMap ConstantSky(const glm::vec3& colour) {
  Scene scene;
  EnvironmentLight light;
  light.scale = colour;
  scene.environments.push_back(light);
  std::vector<std::string> notes;
  return {*LoadEnvironment(scene, {}, notes).map, {1, 0, 0, 0, 1, 0, 0, 0, 1}};
}

TEST(ConstantSky, KeepsTheColourOfItsLight) {
  for (const glm::vec3& colour : kColours) {
    const EnvironmentMap map = ConstantSky(colour);
    for (std::size_t i = 0; i < map.latlong->rgb.size(); ++i) {
      ASSERT_EQ(map.latlong->rgb[i], colour[int(i % 3)]) << i;
    }
    const std::array<double, 3> held = SphereMean(Texels(map).Held());
    for (int c = 0; c < 3; ++c) EXPECT_NEAR(held[c] / colour[c], 1, 1e-3) << colour[c];
  }
}

// Else all light samples would go where rounding leaves a texel above the mean.
TEST(ConstantSky, LeavesNothingToBsdfSamples) {
  for (const glm::vec3& colour : kColours) {
    const EnvironmentMap map = ConstantSky(colour);
    double compensate = 1;
    EXPECT_EQ(BaseLuminance(Texels(map), compensate), 0) << colour[0];
    EXPECT_EQ(compensate, 0) << colour[0];
  }
}

// A sun of a hundredth of all light is no rounding.
TEST(ConstantSky, WithASunIsCompensated) {
  Image image = ConstantSky(glm::vec3(1)).latlong;
  ASSERT_EQ(image.width, 32);
  const float sun = float(0.01 * 12.566 / RowSolidAngle(32, 16, 5));
  for (int c = 0; c < 3; ++c) image.rgb[3 * (5 * 32 + 9) + std::size_t(c)] += sun;
  const EnvironmentMap map = {std::move(image), {1, 0, 0, 0, 1, 0, 0, 0, 1}};
  double compensate = 1;
  EXPECT_NEAR(BaseLuminance(Texels(map), compensate), 1.01, 1e-3);
  EXPECT_EQ(compensate, 1);
}

}  // namespace
}  // namespace skywave
