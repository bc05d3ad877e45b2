// Tests holdouts: the picture is empty where the camera sees them first, and elsewhere it is as
// ever.
#include <gtest/gtest.h>

#include <bit>
#include <string>
#include <vector>

#include "scene/builtin/builtin.h"
#include "tests/support/film_layers.h"
#include "tests/support/refused.h"
#include "tests/support/render_scenes.h"

namespace skywave {
namespace {

constexpr std::uint32_t kSamples = 16;

struct Rendered {
  Image image;
  Layers layers;
};

Rendered Render(JobRequest request, const std::vector<std::string>& holdouts) {
  request.holdouts = holdouts;
  request.background = Background::kTransparent;
  request.options.aovs = *ParseAovs("crypto-material,direct");
  const RenderJob job(BuiltinScene("spheres"), request);
  const Film film = Render(job);
  return {film.Resolve(kSamples), ByName(film.ResolveAovs(kSamples))};
}

class Holdouts : public testing::TestWithParam<std::string> {};

JobRequest RequestOf(const std::string& integrator) {
  JobRequest request = SmallRequest(48, 36, kSamples);
  request.camera.lens_radius = 0.05f;
  request.integrator = integrator == "split" ? Integrator::kPath : *Parse<Integrator>(integrator);
  if (integrator == "split") request.options.bsdf_samples = 2;
  return request;
}

// Samples of other surfaces take the same paths: pixels without holdouts keep their bits, and those
// of holdouts alone have nothing.
TEST_P(Holdouts, OnlyWhatTheCameraSeesOfThemIsMissing) {
  const Rendered with = Render(RequestOf(GetParam()), {});
  const Rendered without = Render(RequestOf(GetParam()), {"red", "mirror"});
  const std::uint32_t red = MatteId("red"), mirror = MatteId("mirror");
  int empty = 0, equal = 0, edges = 0;
  for (std::size_t pixel = 0; pixel < with.layers.at("alpha.A").size(); ++pixel) {
    double held = 0;
    for (int layer = 0; layer < 3; ++layer) {
      const std::string name = "crypto_material0" + std::to_string(layer) + ".";
      for (const std::string id_and_share : {"RG", "BA"}) {
        const auto id = std::bit_cast<std::uint32_t>(with.layers.at(name + id_and_share[0])[pixel]);
        if (id == red || id == mirror) held += with.layers.at(name + id_and_share[1])[pixel];
      }
    }
    const float alpha = without.layers.at("alpha.A")[pixel];
    ASSERT_NEAR(alpha, with.layers.at("alpha.A")[pixel] - held, 1e-6) << pixel;
    for (std::size_t c = 0; c < 3; ++c) {
      const float now = without.image.rgb[3 * pixel + c], before = with.image.rgb[3 * pixel + c];
      const float direct = without.layers.at(std::string("direct.") + "RGB"[c])[pixel];
      ASSERT_LE(now, before * 1.0001f);
      ASSERT_LE(direct, now * 1.0001f);
      if (alpha == 0) {
        ASSERT_EQ(now, 0) << pixel;
      }
      if (held == 0) {
        ASSERT_EQ(now, before) << pixel;
      }
    }
    empty += held == 1, equal += held == 0, edges += held > 0 && held < 1;
  }
  EXPECT_GT(empty, 20);
  EXPECT_GT(equal, 500);
  EXPECT_GT(edges, 20);
}
INSTANTIATE_TEST_SUITE_P(All, Holdouts, testing::Values("path", "direct", "split"),
                         [](const auto& of) { return of.param; });

// A hole in a picture with the map behind it is black, not a window on the map.
TEST(HoldoutBackground, ShowsNothingOfTheMap) {
  JobRequest request = SmallRequest(48, 36, kSamples);
  request.holdouts = {"red", "floor"};
  request.background = Background::kMap;
  request.options.aovs = *ParseAovs("coverage");
  const RenderJob job(BuiltinScene("spheres"), request);
  const Film film = Render(job);
  EXPECT_EQ(film.Resolve(kSamples).Pixel(24, 34)[0], 0);
  EXPECT_EQ(film.ResolveAovs(kSamples)[0].values[34 * 48 + 24], 0);
  EXPECT_GT(film.Resolve(kSamples).Pixel(24, 1)[0], 0);
}

// A lamp that is a holdout lights the scene, and is not seen.
TEST(HoldoutLamps, ShineUnseen) {
  Scene scene;
  const std::uint32_t floor = AddLambert(scene, "floor", glm::vec3(0.5f));
  const std::uint32_t lamp = AddLambert(scene, "lamp", glm::vec3(0));
  scene.materials[lamp].emission = glm::vec3(5);
  Place(scene, Quad(4), floor, glm::vec3(0));
  Place(scene, Sphere(0.5f), lamp, {0, 1, 0});
  scene.camera = LookAtCamera({0, 1.5f, 6}, {0, 0.8f, 0}, {0, 1, 0}, 40, false);
  for (const std::uint32_t depth : {0u, 2u}) {
    JobRequest request = SmallRequest(24, 24, kSamples);
    request.holdouts = {"lamp"};
    request.max_depth = depth;
    if (depth == 0) request.background = Background::kMap;  // no surface, no alpha
    const RenderJob job(scene, request);
    const Film film = Render(job);
    const Image image = film.Resolve(kSamples);
    const Layers layers = ByName(film.ResolveAovs(kSamples));
    EXPECT_EQ(image.Pixel(12, 9)[0], 0) << "the middle of the lamp";
    if (depth == 0) continue;
    EXPECT_EQ(layers.at("alpha.A")[24 * 9 + 12], 0);
    request.holdouts.clear();
    const RenderJob seen(scene, request);
    const Image with_lamp = Render(seen).Resolve(kSamples);
    EXPECT_EQ(image.Pixel(12, 20)[0], with_lamp.Pixel(12, 20)[0]) << "the floor below it";
    EXPECT_GT(image.Pixel(12, 20)[0], 0);
  }
}

TEST(HoldoutOptions, GoWithIntegratorsThatBeginAtTheCamera) {
  for (const Integrator integrator : {Integrator::kBdpt, Integrator::kLight, Integrator::kPhoton}) {
    JobRequest request = SmallRequest(8, 8, 1);
    request.holdouts = {"red"};
    request.integrator = integrator;
    ExpectRefused(BuiltinScene("spheres"), request, std::string(ToString(integrator)));
  }
}

}  // namespace
}  // namespace skywave
