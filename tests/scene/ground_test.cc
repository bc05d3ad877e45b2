// Tests the plane under a scene: its position, its orientation and its visibility.
#include "scene/shapes/ground.h"

#include <gtest/gtest.h>

#include "job/job.h"
#include "wavefront/render.h"

namespace skywave {
namespace {

Scene SmallTriangle(char up_axis, bool left_handed) {
  Scene scene;
  scene.up_axis = up_axis;
  scene.left_handed = left_handed;
  scene.materials.push_back({.name = "default"});
  scene.meshes.push_back(
      {.positions = {{1, 2, 3}, {2, 3, 4}, {1, 3, 5}}, .triangles = {{0, 1, 2}}});
  scene.environments.push_back({.world_from_map = EnvironmentFrame(up_axis, left_handed, 0)});
  return scene;
}

TEST(Ground, LiesUnderTheBoundsAndFacesUp) {
  for (const char up : {'x', 'y', 'z'}) {
    for (const bool left_handed : {false, true}) {
      SCOPED_TRACE(std::string("up ") + up + (left_handed ? ", left-handed" : ""));
      Scene scene = SmallTriangle(up, left_handed);
      const Bounds bounds = SceneBounds(scene, "t");
      AddGround(scene, bounds);
      ASSERT_EQ(scene.meshes.size(), 2u);
      const Mesh& ground = scene.meshes[1];
      EXPECT_EQ(scene.materials.at(ground.material).name, "ground");
      const int axis = up - 'x';
      for (const glm::vec3& p : ground.positions) {
        EXPECT_LT(p[axis], bounds.low[axis]);
        EXPECT_GT(p[axis], bounds.low[axis] - 0.01f);
      }
      ASSERT_EQ(ground.triangles.size(), 2u);
      for (const glm::uvec3& t : ground.triangles) {
        const glm::vec3 normal =
            glm::normalize(glm::cross(ground.positions[t.y] - ground.positions[t.x],
                                      ground.positions[t.z] - ground.positions[t.x]));
        EXPECT_NEAR(normal[axis], 1, 1e-5f);
      }
      const Bounds with = SceneBounds(scene, "t");
      for (int i = 0; i < 3; ++i) {
        if (i == axis) continue;
        EXPECT_LT(with.low[i], bounds.low[i] - 10);
        EXPECT_GT(with.high[i], bounds.high[i] + 10);
      }
    }
  }
}

// In constant radiance 1 the environment is 1 and the plane 0.4 of it. The camera of the picture is
// the same with and without the plane.
TEST(Ground, FillsTheLowerPartOfThePicture) {
  JobRequest request;
  request.scene = "t";
  request.width = 32, request.height = 32;
  request.samples_per_pixel = 16;
  request.options.threads = 1;
  const auto render = [&](bool ground) {
    request.ground = ground ? Ground::kGrey : Ground::kNone;
    const RenderJob job(SmallTriangle('z', false), request);
    Film film = job.MakeFilm();
    RenderFrame(job.frame(), film);
    return film.Resolve(16);
  };
  const Image with = render(true), without = render(false);
  EXPECT_NEAR(without.Pixel(16, 31)[0], 1, 1e-3);
  EXPECT_NEAR(with.Pixel(16, 31)[0], 0.4, 0.02);
  EXPECT_NEAR(with.Pixel(16, 0)[0], 1, 1e-3);
}

}  // namespace
}  // namespace skywave
