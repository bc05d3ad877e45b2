// The formats of a scene's infinite lights, and of maps that a request asks for.
#include <gtest/gtest.h>

#include <string>
#include <vector>

#include "base/error.h"
#include "image/image.h"
#include "job/environment.h"
#include "tests/support/temporary_folder.h"

namespace skywave {
namespace {

// 128 of 255 are 0.2158605 of white (IEC 61966-2-1).
TEST(MapFormats, SceneLightsTakeTextureFormats) {
  const TemporaryFolder folder;
  const std::string path = folder.Path("map.png");
  WritePng(path, 2, 1, {128, 255, 0, 255, 128, 0});
  Scene scene;
  EnvironmentLight light;
  light.map_path = path;
  light.scale = {2, 1, 1};
  scene.environments.push_back(light);
  std::vector<std::string> notes;
  const EnvironmentLight loaded = LoadEnvironment(scene, {}, notes);
  ASSERT_TRUE(loaded.map);
  const std::vector<float> expected = {0.431721f, 1, 0, 2, 0.2158605f, 0};
  ASSERT_EQ(loaded.map->rgb.size(), expected.size());
  for (std::size_t i = 0; i < expected.size(); ++i) {
    EXPECT_NEAR(loaded.map->rgb[i], expected[i], 1e-6) << i;
  }
}

TEST(MapFormats, RequestedMapsTakeRadianceFormatsOnly) {
  const TemporaryFolder folder;
  WritePng(folder.Path("map.png"), 2, 1, {128, 255, 0, 255, 128, 0});
  JobRequest request;
  request.environment.path = folder.Path("map.png");
  std::vector<std::string> notes;
  try {
    LoadEnvironment({}, request, notes);
    ADD_FAILURE();
  } catch (const InputError& error) {
    EXPECT_NE(std::string(error.what()).find("neither OpenEXR"), std::string::npos) << error.what();
  }
}

}  // namespace
}  // namespace skywave
