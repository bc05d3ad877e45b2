// Tests the layer of the objects behind the first one.
#include "wavefront/film/hidden_objects.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <string>
#include <vector>

#include "job/picture.h"
#include "job/session.h"
#include "scene/shapes/mesh.h"
#include "tests/support/film_layers.h"
#include "tests/support/render_scenes.h"

namespace skywave {
namespace {

constexpr int kSize = 24;

// From above, along -y.
Scene SceneFromAbove() {
  Scene scene;
  AddLambert(scene, "matt", glm::vec3(0.5f));
  SetConstantLight(scene, 1);
  scene.camera = LookAtCamera({0, 20, 0.01f}, {0, 0, 0}, {0, 0, -1}, 10, false);
  return scene;
}

RenderJob JobOfIds(const Scene& scene) {
  JobRequest request = SmallRequest(kSize, kSize, 1);
  request.options.filter = PixelFilter::kBox;
  request.options.filter_radius = 0.5f;
  return MakeJob(scene, request, "object-id,hidden-id");
}

Layers Ids(const Scene& scene) { return Resolve(JobOfIds(scene)); }

Scene SheetsFromAbove(int count) {
  Scene scene = SceneFromAbove();
  for (int sheet = 0; sheet < count; ++sheet) {
    Place(scene, Quad(4), 0, glm::vec3(0, -sheet, 0));
  }
  return scene;
}

// Returns the numbers of the meshes behind a pixel, that of object-id first.
std::vector<float> IdsAt(const Layers& layers, std::size_t pixel) {
  std::vector<float> ids = {layers.at("object-id.V")[pixel]};
  for (std::uint32_t k = 1; k <= kHiddenObjects; ++k) {
    ids.push_back(layers.at("hidden-id." + std::to_string(k))[pixel]);
  }
  return ids;
}

TEST(HiddenObjects, AreTheNextOnesInTheirOrder) {
  const Layers all = Ids(SheetsFromAbove(10)), three = Ids(SheetsFromAbove(3));
  for (std::size_t pixel = 0; pixel < kSize * kSize; ++pixel) {
    ASSERT_EQ(IdsAt(all, pixel), (std::vector<float>{1, 2, 3, 4, 5, 6, 7, 8})) << pixel;
    ASSERT_EQ(IdsAt(three, pixel), (std::vector<float>{1, 2, 3, 0, 0, 0, 0, 0})) << pixel;
  }
}

// Balls have two sides, and cut each other. Some stand in the world as instances.
TEST(HiddenObjects, AreThereWhereTheyWouldBeSeenAlone) {
  Scene scene = SceneFromAbove();
  const glm::vec3 places[] = {{-.5f, 0, .2f}, {.3f, -1, -.4f}, {.1f, .5f, .3f}, {-.2f, -3, 0}};
  for (const glm::vec3& place : places) Place(scene, Sphere(0.6f, 12), 0, place);
  Object& object = scene.objects.emplace_back();
  object.meshes.push_back(Sphere(0.5f, 12));
  for (const glm::vec3& place : {glm::vec3(.9f, -2, .5f), glm::vec3(-.8f, 1, -.7f)}) {
    Instance instance;
    instance.world_from_object[3] = place;
    scene.instances.push_back(instance);
  }
  const Layers layers = Ids(scene);
  int overlaps = 0;
  for (std::size_t mesh = 0; mesh <= std::size(places); ++mesh) {
    Scene alone = scene;
    if (mesh < std::size(places)) {
      alone.meshes = {scene.meshes[mesh]};
      alone.objects.clear(), alone.instances.clear();
    } else {
      alone.meshes.clear();
    }
    const Layers expected = Ids(alone);
    for (std::size_t pixel = 0; pixel < kSize * kSize; ++pixel) {
      const std::vector<float> ids = IdsAt(layers, pixel);
      ASSERT_EQ(std::count(ids.begin(), ids.end(), float(mesh + 1)),
                expected.at("object-id.V")[pixel] > 0 ? 1 : 0)
          << "mesh " << mesh << ", pixel " << pixel;
      overlaps += ids[2] > 0;
    }
  }
  EXPECT_GT(overlaps, 100);
}

TEST(HiddenObjects, AreNotedWhereThereMayBeMore) {
  const auto notes = [](int sheets) {
    const RenderJob job = JobOfIds(SheetsFromAbove(sheets));
    const PictureIdentity identity = IdentityOf(job, {}, false);
    const RenderedFilm rendered = RunSession(job, identity, {});
    return ResolvePicture(rendered.film, rendered.samples, job.options().aovs, identity,
                          rendered.part)
        .notes;
  };
  EXPECT_TRUE(notes(7).empty());
  ASSERT_EQ(notes(10).size(), 1u);
  EXPECT_NE(notes(10)[0].find("hidden-id: 576 pixels"), std::string::npos) << notes(10)[0];
}

TEST(HiddenObjects, AreNotAmongAllLayers) { EXPECT_EQ(AllAovs() & *ParseAovs("hidden-id"), 0u); }

}  // namespace
}  // namespace skywave
