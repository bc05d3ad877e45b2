// Tests the sums behind the layers of variance, and the layers of light groups.
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <string>
#include <vector>

#include "base/error.h"
#include "scene/builtin/builtin.h"
#include "scene/shapes/shapes.h"
#include "tests/support/film_layers.h"
#include "tests/support/painted_scene.h"
#include "tests/support/targets.h"
#include "wavefront/film/aovs.h"
#include "wavefront/render.h"

namespace skywave {
namespace {

enum LightsOfRoom { kEnvironment = 1, kLamp = 2, kPoint = 4, kSun = 8 };

Scene LitRoom(int lights) {
  Scene scene = PaintedScene();
  const std::uint32_t lamp = AddLambert(scene, "the lamp", glm::vec3(0.2f));
  if (lights & kLamp) scene.materials[lamp].emission = {3, 2, 1};
  Place(scene, Sphere(0.3f, 4), lamp, {0.2f, 1.3f, -0.4f});
  if (lights & kPoint) scene.lights.push_back({.emission = {1, 2, 3}, .position = {-1, 2, 1}});
  if (lights & kSun) {
    scene.lights.push_back({.name = "sun.1",
                            .kind = LocalLightKind::kDistant,
                            .emission = {0.5f, 0.4f, 0.3f},
                            .direction = glm::normalize(glm::vec3(-1, 2, 0.5f))});
  }
  if (!(lights & kEnvironment)) scene.environments.clear();
  return scene;
}

constexpr std::pair<const char*, int> kRoomGroups[] = {
    {"environment", kEnvironment}, {"point", kPoint}, {"sun_1", kSun}, {"the_lamp", kLamp}};

// The sums agree to the last unit of the film: no light is lost, counted twice or rounded
// differently.
TEST(LightGroups, AddUpToThePicture) {
  for (const Integrator integrator : {Integrator::kPath, Integrator::kDirect}) {
    for (const int lights :
         {kEnvironment | kLamp | kPoint | kSun, kLamp | kSun, int(kEnvironment)}) {
      JobRequest request = SmallRequest(37, 29, 5);
      request.integrator = integrator;
      request.options.light_samples = 2;
      const Film film = Render(MakeJob(LitRoom(lights), request, "lights"));
      const auto sums = film.sums(), groups = film.light_group_sums();
      ASSERT_EQ(groups.size() % sums.size(), 0u);
      for (std::size_t i = 0; i < sums.size(); ++i) {
        std::uint64_t sum = 0;
        for (std::size_t at = i; at < groups.size(); at += sums.size()) sum += groups[at];
        ASSERT_EQ(sum, sums[i]) << i;
      }
    }
  }
}

// The group of a light equals the picture lit by that light alone.
TEST(LightGroups, AreWhatTheirLightMakesAlone) {
  constexpr int kRuns = 10;
  for (const Integrator integrator : {Integrator::kPath, Integrator::kDirect}) {
    JobRequest request = SmallRequest(12, 9, 96);
    request.integrator = integrator;
    const auto mean_of = [](const std::vector<float>& values) {
      double sum = 0;
      for (const float value : values) sum += value;
      return sum / double(values.size());
    };
    const RenderJob all = MakeJob(LitRoom(kEnvironment | kLamp | kPoint | kSun), request, "lights");
    for (const auto& [name, light] : kRoomGroups) {
      const RenderJob alone = MakeJob(LitRoom(light), request, "lights");
      std::vector<double> differences;
      double level = 0;
      for (std::uint32_t run = 0; run < kRuns; ++run) {
        FrameView one = alone.frame(), every = all.frame();
        one.options.seed = 100 + run, every.options.seed = 200 + run;
        const std::string channel = std::string("lights-") + name + ".R";
        const double expected = mean_of(ByName(Render(alone, one).ResolveAovs(96)).at(channel));
        const double found = mean_of(ByName(Render(all, every).ResolveAovs(96)).at(channel));
        differences.push_back(found - expected), level += expected / kRuns;
      }
      double mean = 0, square = 0;
      for (const double d : differences) mean += d / kRuns, square += d * d / kRuns;
      const double error = std::sqrt((square - mean * mean) / (kRuns - 1));
      // Student's t of 9 degrees of freedom exceeds 5 in one of 1400 cases of 8; the second test
      // ensures that the first is meaningful.
      EXPECT_LT(std::abs(mean), 5 * error) << name << " " << level;
      EXPECT_LT(5 * error, 0.2 * level) << name;
    }
  }
}

TEST(LightGroups, AreBoundedInNumber) {
  Scene scene = LitRoom(kEnvironment);
  for (int i = 0; i < 40; ++i) {
    scene.lights.push_back({.name = "l" + std::to_string(i % 36),
                            .emission = glm::vec3(1),
                            .position = {0.1f * float(i), 2, 1}});
  }
  const Layers layers = Resolve(MakeJob(scene, SmallRequest(4, 3, 1), "lights"));
  EXPECT_EQ(layers.size(), 3 * kMaxLightGroups);
  EXPECT_TRUE(layers.contains("lights-l29.G"));
  EXPECT_TRUE(layers.contains("lights-others.G"));
  EXPECT_FALSE(layers.contains("lights-l30.G"));
}

TEST(AovFilm, VarianceIsExactFromTheFaintestToTheBrightest) {
  for (const float brightest : {0.0f, 1.0f, 1e6f, 1e18f}) {
    Film film(2, 1, brightest, *ParseAovs("variance"), 1);
    const float large = std::max(1.0f, brightest);
    // The mean is large and the spread small, so sums of squares in floating point would be
    // useless.
    const float values[] = {large, std::nextafter(large, 2 * large), large};
    const soa::Table<PathColumns> paths(4);
    RenderStats stats;
    for (const float value : values) {
      for (std::uint32_t pixel : {0u, 1u}) {
        paths->pixel[pixel] = pixel;
        paths->r[pixel] = pixel == 0 ? value : 60 * large;
        paths->g[pixel] = paths->b[pixel] = 0;
      }
      film.Add(paths, 2, stats);
    }
    const Layers layers = ByName(film.ResolveAovs(3));
    const double step = double(values[1]) - values[0];
    EXPECT_NEAR(layers.at("variance.R")[0] / (step * step / 3), 1, 1e-5) << brightest;
    EXPECT_EQ(layers.at("variance.R")[1], 0);
    EXPECT_EQ(layers.at("variance.G")[0], 0);
  }
}

// Adds sample `number` of pixel 0, with `red` in the red channel and none in the others.
void AddSample(Film& film, std::uint32_t number, float red) {
  const soa::Table<PathColumns> path(1);
  RenderStats stats;
  path->pixel[0] = 0, path->sample[0] = number;
  path->r[0] = red, path->g[0] = path->b[0] = 0;
  film.Add(path, 1, stats);
}

// The first eight samples belong to the halves by pairs in the order 0, 1, 1, 0, and the next ones
// by blocks of four in the order 1, 0.
TEST(AovFilm, HalvesHaveTheirOwnMeanAndVariance) {
  const AovSet layers = *ParseAovs("half,half-variance");
  const auto value = [](std::uint32_t sample) { return float(sample * sample) / 16; };
  double sum = 0, squares = 0;
  for (const std::uint32_t sample : {2, 3, 4, 5, 8, 9, 10, 11}) {
    sum += value(sample), squares += double(value(sample)) * value(sample);
  }
  for (const bool has_signs : {false, true}) {
    const FilmLayout layout = {.area = {1, 1, {0, 0, 1, 1}},
                               .brightest_radiance = 32,
                               .aovs = layers,
                               .world_extent = 1,
                               .has_signs = has_signs};
    const float sign = has_signs ? -1 : 1;
    Film film(layout), first(layout), last(layout);
    for (std::uint32_t sample = 0; sample < 16; ++sample) {
      AddSample(film, sample, sign * value(sample));
      AddSample(sample < 7 ? first : last, sample, sign * value(sample));
    }
    first.Merge(last);
    for (const Film* const one : {&film, &first}) {
      const Layers channels = ByName(one->ResolveAovs(16));
      EXPECT_EQ(channels.at("half.N")[0], 8);
      EXPECT_NEAR(channels.at("half.R")[0], sign * sum / 8, 1e-6 * sum);
      EXPECT_EQ(channels.at("half.G")[0], 0);
      EXPECT_NEAR(channels.at("half-variance.R")[0] / ((squares - sum * sum / 8) / 7), 1, 1e-6);
      EXPECT_EQ(channels.at("half-variance.B")[0], 0);
    }
  }
}

// What objects change may be negative in films whose samples are not.
TEST(AovFilm, ChangesHaveSignsAndTheirOwnNoise) {
  const AovSet layers = *ParseAovs("difference") | PartAovs();
  const auto value = [](std::uint32_t sample) {
    return (sample % 3 == 0 ? -1.0f : 0.25f) * sample;
  };
  double sum = 0, squares = 0, half = 0, half_squares = 0;
  Film film(1, 1, 32, layers, 1), first(1, 1, 32, layers, 1), last(1, 1, 32, layers, 1);
  for (std::uint32_t sample = 0; sample < 16; ++sample) {
    const double x = value(sample);
    sum += x, squares += x * x;
    if (IsInSecondHalf(sample)) half += x, half_squares += x * x;
    for (Film* const one : {&film, sample < 7 ? &first : &last}) {
      AddSample(*one, sample, 2);
      const soa::Table<PathColumns> path(1);
      path->pixel[0] = 0, path->sample[0] = sample;
      path->r[0] = value(sample), path->g[0] = path->b[0] = 0;
      one->AddLightPart(LightPart::kChange, path, 1);
    }
  }
  ASSERT_LT(sum, 0);
  first.Merge(last);
  for (const Film* const one : {&film, &first}) {
    const Layers channels = ByName(one->ResolveAovs(16));
    EXPECT_NEAR(channels.at("difference.R")[0], sum / 16, 1e-6);
    EXPECT_NEAR(channels.at("difference-half.R")[0], half / 8, 1e-6);
    EXPECT_NEAR(channels.at("difference-variance.R")[0], (squares - sum * sum / 16) / 15, 1e-5);
    EXPECT_NEAR(channels.at("difference-half-variance.R")[0], (half_squares - half * half / 8) / 7,
                1e-5);
    EXPECT_EQ(channels.at("difference.G")[0], 0);
    EXPECT_EQ(channels.at("objects-variance.R")[0], 0);
  }
}

// As many first samples as a denoiser asks for, and any power of two from there on, have equal
// halves.
TEST(AovFilm, HalvesAreEqualAtPowersOfTwo) {
  Film film(1, 1, 1, *ParseAovs("half"), 1);
  for (std::uint32_t sample = 0; sample < 1024; ++sample) {
    AddSample(film, sample, 1);
    const std::uint32_t count = sample + 1;
    if (count < 4 || (count & sample) != 0) continue;
    EXPECT_EQ(ByName(film.ResolveAovs(count)).at("half.N")[0], count / 2) << count;
  }
}

TEST(AovFilm, VarianceOfTheBrightestSamplesDoesNotOverflow) {
  // Doubling gives half as many samples as the sums of the film can hold.
  Film film(1, 1, 1, *ParseAovs("variance"), 1);
  const float limit = float(film.unit() * 0x1p52);
  const soa::Table<PathColumns> paths(1);
  RenderStats stats;
  paths->r[0] = limit, paths->g[0] = limit / 2, paths->b[0] = 0;
  film.Add(paths, 1, stats);
  paths->g[0] = 0;
  film.Add(paths, 1, stats);
  for (int doubling = 1; doubling < 11; ++doubling) film.Merge(Film(film));
  const Layers layers = ByName(film.ResolveAovs(2048));
  EXPECT_EQ(layers.at("variance.R")[0], 0);
  EXPECT_NEAR(layers.at("variance.G")[0] / (limit * double(limit) / 16), 2048.0 / 2047, 1e-6);
}

// Fixed light samples are of the map, whose group does not depend on lamps. The paths are the same.
TEST(LightGroups, FixedLightsAreOfTheEnvironment) {
  JobRequest request = SmallRequest(12, 9, 16);
  request.integrator = Integrator::kDirect;
  request.strategy = "median-cut:lights=16";
  const auto environment = [&](int lights) {
    const Layers layers = Resolve(MakeJob(LitRoom(lights), request, "lights"));
    double sum = 0;
    for (const float value : layers.at("lights-environment.R")) sum += value;
    return sum;
  };
  const double alone = environment(kEnvironment);
  EXPECT_GT(alone, 0);
  EXPECT_NEAR(environment(kEnvironment | kLamp | kPoint | kSun) / alone, 1, 0.01);
}

}  // namespace
}  // namespace skywave
