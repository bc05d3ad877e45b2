// Tests links of lights: what a light loses on some surfaces is what it has on the others.
#include <gtest/gtest.h>

#include <cmath>
#include <functional>
#include <string>
#include <vector>

#include "tests/support/film_layers.h"
#include "tests/support/refused.h"
#include "tests/support/render_scenes.h"
#include "wavefront/policies/control_pilot.h"

namespace skywave {
namespace {

constexpr std::uint32_t kSamples = 32;

// A floor with a matt, a metal and a glass ball under a sky, a sun and a lamp that the camera does
// not see.
Scene LitScene() {
  Scene scene;
  Place(scene, Quad(3), AddLambert(scene, "floor", {0.6f, 0.5f, 0.4f}), glm::vec3(0));
  Place(scene, Sphere(0.5f), AddLambert(scene, "red", {0.8f, 0.1f, 0.1f}), {-0.9f, 0.5f, 0});
  Place(scene, Sphere(0.4f), AddMetal(scene, "Cu", 0.3f), {0.2f, 0.4f, 0.5f});
  scene.materials.back().name = "copper";
  scene.materials.push_back({.name = "glass", .bsdf = BsdfKind::kDielectric});
  scene.materials.back().reflectance = glm::vec3(1);
  Place(scene, Sphere(0.4f), std::uint32_t(scene.materials.size() - 1), {1.2f, 0.4f, 0});
  Place(scene, Sphere(0.01f), AddLambert(scene, "nothing", glm::vec3(0)), {0, 5, 9});
  const std::uint32_t lamp = AddLambert(scene, "lamp", glm::vec3(0.5f));
  scene.materials[lamp].emission = {5, 6, 8};
  scene.materials[lamp].emits_on_both_sides = true;
  Place(scene, Quad(0.7f), lamp, {-0.5f, 3.5f, 1});
  SetLight(scene, SkyWithSun(32, 16, 12, 0.3));
  scene.lights = {SlantingSun()};
  scene.lights.back().name = "sun";
  scene.camera = LookAtCamera({0, 1.6f, 4}, {0, 0.3f, 0}, {0, 1, 0}, 40, false);
  scene.meshes[0].name = "ground mesh";
  return scene;
}

Image Rendered(const Scene& scene, JobRequest request) {
  request.background = Background::kTransparent;
  const RenderJob job(scene, request);
  return Render(job).Resolve(request.samples_per_pixel.value());
}

JobRequest Request(const std::string& integrator) {
  JobRequest request = SmallRequest(28, 20, kSamples);
  request.integrator = integrator == "direct" ? Integrator::kDirect : Integrator::kPath;
  request.options.light_samples = integrator == "direct" ? 2 : 1;
  request.options.mis = integrator != "without mis";
  return request;
}

class Links : public testing::TestWithParam<std::string> {};

// Every path is there in both pictures, with the light of some of its surfaces in the one and of
// the others in the other: sample by sample they add up to the picture without links.
TEST_P(Links, ThePicturesOfSomeSurfacesAndOfTheOthersAddUp) {
  const Scene scene = LitScene();
  const Image plain = Rendered(scene, Request(GetParam()));
  for (const std::string light : {"environment", "sun", "lamp"}) {
    for (const std::string names : {"red,glass", "ground mesh", "copper"}) {
      JobRequest some = Request(GetParam()), others = some, without = some;
      some.links = {light + ":" + names};
      others.links = {light + ":!" + names};
      without.links = {light + ":nothing"};
      const Image a = Rendered(scene, some), b = Rendered(scene, others),
                  c = Rendered(scene, without);
      double gained = 0, lost = 0;
      for (std::size_t i = 0; i < plain.rgb.size(); ++i) {
        // Each of both has all of the other lights, which `without` has as well.
        ASSERT_NEAR(a.rgb[i] + b.rgb[i], plain.rgb[i] + c.rgb[i], 2e-5f * (1 + plain.rgb[i]))
            << light << " " << names << " " << i;
        gained += double(a.rgb[i] - c.rgb[i]), lost += double(plain.rgb[i] - a.rgb[i]);
      }
      EXPECT_GT(gained, 0.5) << light << " " << names;
      EXPECT_GT(lost, 0.5) << light << " " << names;
    }
  }
}

TEST_P(Links, LightsThatAreLinkedToEverythingChangeNoBit) {
  const Scene scene = LitScene();
  JobRequest all = Request(GetParam());
  const Image plain = Rendered(scene, all);
  all.links = {"environment:floor,red,copper,glass,lamp", "sun:!nothing", "lamp:!nothing"};
  EXPECT_EQ(Rendered(scene, all).rgb, plain.rgb);
}
// A light that shines on nothing might as well not be there.
TEST_P(Links, ALightThatShinesOnNothingIsNotThere) {
  const auto mean = [](const Image& image) {
    double sum = 0;
    for (const float value : image.rgb) sum += double(value);
    return sum / double(image.rgb.size());
  };
  const auto without = [](Scene scene, const std::string& light) {
    if (light == "environment") scene.environments.clear();
    if (light == "sun") scene.lights.clear();
    if (light == "lamp") scene.materials[scene.meshes.back().material].emission = glm::vec3(0);
    return scene;
  };
  for (const std::string light : {"environment", "sun", "lamp"}) {
    JobRequest request = Request(GetParam());
    request.samples_per_pixel = 512;
    const double expected = mean(Rendered(without(LitScene(), light), request));
    const double all = mean(Rendered(LitScene(), request));
    request.links = {light + ":nothing"};
    EXPECT_NEAR(mean(Rendered(LitScene(), request)), expected, 0.02 * expected) << light;
    EXPECT_GT(all, 1.05 * expected) << light;
  }
}
INSTANTIATE_TEST_SUITE_P(All, Links, testing::Values("path", "direct", "without mis"),
                         [](const auto& of) { return of.param.substr(0, of.param.find(' ')); });

TEST(LinksOfLamps, AreNotThoseOfTheCamera) {
  Scene scene = LitScene();
  scene.materials[scene.meshes.back().material].reflectance = glm::vec3(0);
  scene.camera = LookAtCamera({0, 0.5f, 3}, {-0.5f, 3.5f, 1}, {0, 1, 0}, 30, false);
  JobRequest request = Request("path");
  const Image plain = Rendered(scene, request);
  request.links = {"lamp:red"};
  const Image linked = Rendered(scene, request);
  int seen = 0;
  for (std::size_t i = 2; i < plain.rgb.size(); i += 3) {
    if (plain.rgb[i] < 7.9f) continue;
    ++seen;
    EXPECT_EQ(linked.rgb[i], plain.rgb[i]);
  }
  EXPECT_GT(seen, 3);
}

// Returns the mean of the lower half of a picture, which shows the floor.
glm::dvec3 MeanOfFloor(const Image& image) {
  glm::dvec3 mean(0);
  for (int y = image.height / 2; y < image.height; ++y) {
    for (int x = 0; x < image.width; ++x) {
      for (int c = 0; c < 3; ++c) mean[c] += double(image.Pixel(x, y)[c]);
    }
  }
  return mean / double(image.width * (image.height / 2));
}

// A black wall stands between the camera and the light of one side.
Scene ShadowedFloor(bool with_wall) {
  Scene scene;
  Place(scene, Quad(6), AddLambert(scene, "floor", glm::vec3(0.5f)), glm::vec3(0));
  const std::uint32_t wall = AddLambert(scene, "wall", glm::vec3(0));
  if (with_wall) Place(scene, Facetted(RoundedBox({0.1f, 1, 2}, 0.01f, 1)), wall, {-2.2f, 1, 0});
  const std::uint32_t lamp = AddLambert(scene, "lamp", glm::vec3(0));
  scene.materials[lamp].emission = {30, 20, 10};
  scene.materials[lamp].emits_on_both_sides = true;
  Place(scene, Quad(0.5f), lamp, {-3, 2.5f, 0});
  SetLight(scene, SkyWithSun(32, 16, 12, 0.3));
  scene.camera = LookAtCamera({0, 3, 0.01f}, {0, 0, 0}, {0, 1, 0}, 30, false);
  scene.lights = {SlantingSun()};
  scene.lights.back().name = "sun";
  return scene;
}

TEST(ShadowLinks, WhatThrowsNoShadowOfALightMightAsWellNotBeThere) {
  JobRequest request = SmallRequest(16, 16, 1024);
  const glm::dvec3 empty = MeanOfFloor(Rendered(ShadowedFloor(false), request));
  const glm::dvec3 shadowed = MeanOfFloor(Rendered(ShadowedFloor(true), request));
  request.shadow_links = {"environment:!wall", "lamp:floor", "sun:!wall"};
  const glm::dvec3 linked = MeanOfFloor(Rendered(ShadowedFloor(true), request));
  for (int c = 0; c < 3; ++c) {
    EXPECT_NEAR(linked[c], empty[c], 0.01 * empty[c]);
    EXPECT_LT(shadowed[c], 0.9 * empty[c]);
  }
  // Each light has its own: that of one does not change the others.
  glm::dvec3 gained(0);
  for (const std::string light : {"environment", "lamp", "sun"}) {
    request.shadow_links = {light + ":!wall"};
    gained += MeanOfFloor(Rendered(ShadowedFloor(true), request)) - shadowed;
  }
  for (int c = 0; c < 3; ++c) EXPECT_NEAR(gained[c], empty[c] - shadowed[c], 0.015 * empty[c]);
}

// These lights are estimated by light samples alone, which has the same mean.
TEST(ShadowLinks, OfAllSurfacesThrowAllShadows) {
  JobRequest request = SmallRequest(16, 16, 1024);
  const Scene scene = ShadowedFloor(true);
  const glm::dvec3 plain = MeanOfFloor(Rendered(scene, request));
  request.shadow_links = {"environment:wall,floor", "lamp:wall,floor,lamp"};
  const glm::dvec3 linked = MeanOfFloor(Rendered(scene, request));
  for (int c = 0; c < 3; ++c) EXPECT_NEAR(linked[c], plain[c], 0.01 * plain[c]);
}

TEST(BadLinks, AreRefusedByName) {
  const Scene scene = LitScene();
  struct Bad {
    std::string link, word;
  };
  for (const Bad& bad :
       {Bad{"sunn:red", "there are sun"}, Bad{"sun:redd", "there are red"}, Bad{"sun", "LIGHT:"},
        Bad{":red", "LIGHT:"}, Bad{"sun:red,", "LIGHT:"}, Bad{"sun:!", "LIGHT:"}}) {
    JobRequest request = Request("path");
    request.links = {bad.link};
    ExpectRefused(scene, request, bad.word);
    request.links = {};
    request.shadow_links = {bad.link};
    ExpectRefused(scene, request, bad.word);
  }
  JobRequest twice = Request("path");
  twice.links = {"sun:red", "sun:copper"};
  ExpectRefused(scene, twice, "two of these links");
  JobRequest request = Request("path");
  request.links = {"sun:red"};
  for (const auto& [change, word] :
       std::vector<std::pair<std::function<void(JobRequest&)>, std::string>>{
           {[](JobRequest& r) { r.integrator = Integrator::kVcm; }, "path"},
           {[](JobRequest& r) { r.options.bsdf_samples = 2; }, "split"},
           {[](JobRequest& r) {
              r.options.of<ControlOptions>().control = ControlVariate::kIrradiance;
            },
            "control"},
           {[](JobRequest& r) {
              r.shadow_links = {"sun:red"};
              r.catchers = {"floor"};
            },
            "catchers"}}) {
    JobRequest changed = request;
    change(changed);
    ExpectRefused(scene, changed, word);
  }
}

}  // namespace
}  // namespace skywave
