// Tests which lights surfaces take samples of: all selections give the same picture, and where each
// local light takes a sample, nothing is left to chance.
#include <fmt/format.h>
#include <gtest/gtest.h>

#include <string>
#include <vector>

#include "base/error.h"
#include "tests/support/matt_room.h"
#include "tests/support/picture_estimate.h"
#include "tests/support/room_lights.h"
#include "tests/support/statistics.h"
#include "wavefront/integrator.h"
#include "wavefront/render.h"

namespace skywave {
namespace {

constexpr int kRuns = 12;
const double kLevel = SidakLevel(16);

JobRequest Request(Integrator integrator, LightSelection selection) {
  JobRequest request = SmallRequest(24, 18, 8);
  request.integrator = integrator;
  request.max_depth = integrator == Integrator::kDirect ? 1 : 3;
  request.options.light_selection = selection;
  return request;
}

// A floor under three point lights of unequal power, with a ball on it.
Scene Lamps(std::uint32_t wanted) {
  const std::vector<PunctualLight> all = {{.emission = {40, 2, 2}, .position = {-3, 4, 1}},
                                          {.emission = {1, 9, 1}, .position = {2, 3, 2}},
                                          {.emission = {2, 2, 5}, .position = {0, 6, -4}}};
  Scene scene;
  Place(scene, Quad(9), AddLambert(scene, "floor", glm::vec3(0.6f)), glm::vec3(0));
  Place(scene, Sphere(0.8f, 4), AddLambert(scene, "ball", glm::vec3(0.7f)), {0, 0.8f, 0});
  for (std::size_t i = 0; i < all.size(); ++i) {
    if (((wanted >> i) & 1) != 0) scene.lights.push_back(all[i]);
  }
  scene.camera = LookAtCamera({0, 3, 6}, {0, 0.5f, 0}, {0, 1, 0}, 45, false);
  return scene;
}

Image Render(const Scene& scene, const JobRequest& request) {
  const RenderJob job(scene, request);
  Film film = job.MakeFilm();
  RenderFrame(job.frame(), film);
  return film.Resolve(request.options.samples_per_pixel);
}

// A sample of each of several point lights is the sum of what they give alone, at each sample of a
// pixel: no light is drawn by chance.
TEST(LightSelection, ASampleOfEachLightIsTheSumOfTheLights) {
  JobRequest request = Request(Integrator::kDirect, LightSelection::kAll);
  request.options.samples_per_pixel = 1;
  const Image together = Render(Lamps(7), request);
  const Image one = Render(Lamps(1), request), two = Render(Lamps(2), request),
              four = Render(Lamps(4), request);
  double sum = 0;
  for (std::size_t i = 0; i < together.rgb.size(); ++i) {
    ASSERT_NEAR(together.rgb[i], one.rgb[i] + two.rgb[i] + four.rgb[i],
                1e-5f * (1e-3f + together.rgb[i]))
        << "value " << i;
    sum += together.rgb[i];
  }
  EXPECT_GT(sum, 10);
}

// The room has a map, a lamp and a ball of a hundred triangles that shine, and a point light; BSDF
// samples hit lamp and ball.
TEST(LightSelection, EverySelectionMatchesTheOracle) {
  for (const Integrator integrator : {Integrator::kDirect, Integrator::kPath}) {
    for (const LightSelection selection : {LightSelection::kPower, LightSelection::kOne,
                                           LightSelection::kTree, LightSelection::kAll}) {
      for (const bool mis : {true, false}) {
        SCOPED_TRACE(std::string(ToString(selection)) + (mis ? "" : " without MIS"));
        const Scene scene =
            MattRoom(Of(BsdfKind::kConductor), kEnvironment | kLamp | kBall | kPoint);
        JobRequest request = Request(integrator, selection);
        request.options.mis = mis;
        request.options.light_samples = integrator == Integrator::kDirect ? 2 : 1;
        const RenderJob job(scene, request);
        EXPECT_TRUE(SamePicture(MeanOfBlocks(EstimateFromEngine(job, kRuns, 100), 3),
                                MeanOfBlocks(EstimateFromOracle(scene, job, 4 * kRuns), 3),
                                kLevel));
      }
    }
  }
}

// A choice among three lights and a map, by power or all alike.
TEST(LightSelection, OneOfThemIsAnyOfThemEquallyOften) {
  Scene scene = Lamps(7);
  const auto chances = [&](LightSelection selection) {
    const RenderJob job(scene, Request(Integrator::kDirect, selection));
    const LightChoice local = job.frame().light_shares().local;
    std::vector<double> each;
    for (int i = 0; i < 3; ++i) {
      each.push_back((local.first[i + 1] - local.first[i]) / double(kChoiceUnits));
    }
    return each;
  };
  for (const double chance : chances(LightSelection::kOne)) EXPECT_NEAR(chance, 1 / 3.0, 1e-6);
  EXPECT_GT(chances(LightSelection::kPower)[0], 0.4);
  SetConstantLight(scene, 0.01f);
  for (const double chance : chances(LightSelection::kOne)) EXPECT_NEAR(chance, 0.25, 1e-6);
  const RenderJob all(scene, Request(Integrator::kDirect, LightSelection::kAll));
  EXPECT_EQ(all.frame().light_shares().total(), 4u);
}

// Fixed light samples come before those of the local lights, drawn ones after them.
TEST(LightSelection, AllGoesWithStrategiesOfFixedSamples) {
  const Scene scene = MattRoom(Of(BsdfKind::kConductor), kEnvironment | kLamp | kPoint);
  JobRequest request = Request(Integrator::kPath, LightSelection::kAll);
  const auto estimate = [&](const char* strategy) {
    request.strategy = strategy;
    return MeanOfBlocks(EstimateFromEngine(RenderJob(scene, request), kRuns, 300), 3);
  };
  EXPECT_TRUE(SamePicture(estimate("hybrid:lights=8,inside=1"), estimate("importance"), kLevel));
}

// Light paths leave lights by power, and their weights know no other way to pick one.
TEST(LightSelection, IntegratorsWithLightPathsTakeLightsByPowerAlone) {
  const Scene scene = Lamps(7);
  for (const Integrator integrator : ValuesOf<Integrator>()) {
    for (const LightSelection selection : ValuesOf<LightSelection>()) {
      SCOPED_TRACE(fmt::format("{} {}", ToString(integrator), ToString(selection)));
      const bool taken =
          selection == LightSelection::kPower || !Describe(integrator).has_light_paths();
      // As the integrator of the request, and as one that converge compares with it.
      const auto refuses = [&](const auto& make) {
        try {
          make();
        } catch (const OptionError& error) {
          EXPECT_NE(std::string(error.what()).find("light-selection"), std::string::npos)
              << error.what();
          return true;
        }
        return false;
      };
      EXPECT_EQ(refuses([&] { RenderJob(scene, Request(integrator, selection)); }), !taken);
      const RenderJob job(scene, Request(Integrator::kPath, selection));
      EXPECT_EQ(refuses([&] { job.MakeMethod("importance", integrator); }), !taken);
    }
  }
}

TEST(LightSelection, TooManyLightsForASampleOfEachAreNamed) {
  Scene scene = Lamps(7);
  scene.lights.resize(kMostOfEach + 1, scene.lights[0]);
  EXPECT_NO_THROW(RenderJob(scene, Request(Integrator::kDirect, LightSelection::kOne)));
  try {
    RenderJob(scene, Request(Integrator::kDirect, LightSelection::kAll));
    ADD_FAILURE() << "4097 lights were accepted";
  } catch (const OptionError& error) {
    EXPECT_NE(std::string(error.what()).find("the scene has 4097"), std::string::npos)
        << error.what();
  }
  scene.lights.pop_back();
  EXPECT_NO_THROW(RenderJob(scene, Request(Integrator::kDirect, LightSelection::kAll)));
}

}  // namespace
}  // namespace skywave
