// Tests the emission stage: rays of environment and lamps together carry the power of both,
// whatever strategy samples the environment.
#include "wavefront/stages/light_stages.h"

#include <gtest/gtest.h>

#include <cmath>
#include <numbers>

#include "lights/strategies/strategy.h"
#include "tests/support/random_rows.h"
#include "tests/support/render_scenes.h"
#include "tests/support/shade_points.h"
#include "tests/support/statistics.h"

namespace skywave {
namespace {

constexpr std::uint32_t kWave = 2048;

Scene LitFloor(bool map, bool lamps) {
  Scene scene;
  Place(scene, Quad(2), AddLambert(scene, "floor", glm::vec3(0.5f)), glm::vec3(0));
  scene.camera = LookAtCamera({0, 3, 3}, {0, 0, 0}, {0, 1, 0}, 40, false);
  if (map) SetLight(scene, SkyWithSun(32, 16, 50, 0.3));
  scene.portals = PortalsAroundTheOrigin();
  if (!lamps) return scene;
  const std::uint32_t lamp = AddLambert(scene, "lamp", glm::vec3(0));
  scene.materials[lamp].emission = {6, 5, 4};
  Place(scene, Quad(0.5f), lamp, {0, 2, 0});
  scene.lights = {{.emission = {2, 3, 1}, .position = {-1.5f, 2, 1}},
                  {.kind = LocalLightKind::kDistant,
                   .emission = {0.3f, 0.5f, 0.4f},
                   .direction = glm::normalize(glm::vec3(1, 2, 1.5f))}};
  return scene;
}

// Returns the power in the green channel, computed by hand: area integrals of cosines and of the
// map's texels.
double PowerOf(const Scene& scene, bool map, bool lamps, double radius) {
  const double disk = kPi * radius * radius;
  double power = lamps ? kPi * 5 * 1 + 4 * kPi * 3 + disk * 0.5 : 0;
  if (!map) return power;
  const Image& image = *scene.environments[0].map;
  for (int y = 0; y < image.height; ++y) {
    const double solid_angle =
        2 * kPi / image.width *
        (std::cos(kPi * y / image.height) - std::cos(kPi * (y + 1) / image.height));
    for (int x = 0; x < image.width; ++x) power += disk * solid_angle * image.Pixel(x, y)[1];
  }
  return power;
}

JobRequest Request() {
  JobRequest request = SmallRequest(16, 12, 1);
  request.integrator = Integrator::kLight;
  return request;
}

struct LightWave {
  LightWave(const FrameView& frame, std::uint64_t first, std::uint32_t n) : worker(kWave) {
    worker.tables.Add<LightPathTables>(kWave);
    StageClock clock(worker.stats);
    StartLightPaths(frame.options, first, n, worker.paths);
    EmitRays(frame, n, worker.rays[0], worker, clock);
  }
  Worker worker;
};

void ExpectPower(const RenderJob& job, double power, std::size_t tests) {
  const FrameView frame = job.frame();
  // The waves have different seeds because points of one sequence are not independent of each
  // other.
  Moments means;
  for (std::uint32_t seed = 0; seed < 40; ++seed) {
    FrameView view = frame;
    view.options.seed = seed;
    const LightWave wave(view, 0, kWave);
    double sum = 0;
    for (std::uint32_t i = 0; i < kWave; ++i) {
      if (wave.worker.rays[0]->t_far[i] >= 0) sum += wave.worker.rays[0]->throughput_g[i];
    }
    means.Add(sum / kWave);
  }
  EXPECT_TRUE(
      AgreesWith(means.mean(), means.standard_error(), power, SidakLevel(tests), 1e-4 * power));
}

TEST(EmitRays, CarriesThePowerOfAllLights) {
  for (const auto& [map, lamps] : {std::pair{true, false}, {false, true}, {true, true}}) {
    SCOPED_TRACE(testing::Message() << "map " << map << ", lamps " << lamps);
    const Scene scene = LitFloor(map, lamps);
    const RenderJob job(scene, Request());
    ExpectPower(job, PowerOf(scene, map, lamps, job.frame().sphere.radius), 12);
  }
}

TEST(EmitRays, CarriesThePowerOfTheMapByEveryStrategyThatCan) {
  const Scene scene = LitFloor(true, true);
  const RenderJob of_map(scene, Request());
  std::size_t able = 0;
  for (const StrategyFactory& factory : Strategies()) {
    for (const char* const values : {"", ":pick=power"}) {
      JobRequest request = Request();
      request.strategy = std::string(factory.name) + values;
      const bool picks = std::any_of(factory.parameters.begin(), factory.parameters.end(),
                                     [](const auto& p) { return p.key == "pick"; });
      if (*values != 0 && !picks) continue;
      if (!CanEmit(*MakeStrategy(request.strategy, *of_map.frame().map))) continue;
      SCOPED_TRACE(request.strategy);
      request.integrator = Integrator::kLight;
      const RenderJob job(scene, request);
      ExpectPower(job, PowerOf(scene, true, true, job.frame().sphere.radius), 12);
      ++able;
    }
  }
  // These are importance, warp, alias, uniform and presampled, seven sorts of lights, and hybrid.
  EXPECT_EQ(able, 13u);
}

// On a wide floor too, a surface knows its position accurately enough for small objects on it: rays
// from the environment begin no higher than the scene.
TEST(IntersectLightPathSurfaces, LightOfTheEnvironmentStartsNearby) {
  Scene scene = LitFloor(true, false);
  scene.meshes[0] = Quad(200);
  Place(scene, Sphere(0.5f, 4), 0, {0, 0.5f, 0});
  const RenderJob job(scene, Request());
  const FrameView frame = job.frame();
  LightWave wave(frame, 0, kWave);
  Worker& w = wave.worker;
  StageClock clock(w.stats);
  IntersectLightPathSurfaces(frame, w.rays[0], kWave, 1, w, clock);
  std::uint32_t above = 0;
  for (std::uint32_t i = 0; i < w.ranges.total(); ++i) {
    if (w.surfaces->wo_y[i] < 0.1f) continue;
    const float height = w.surfaces->t[i] * w.surfaces->wo_y[i];
    ASSERT_LT(height, 1.5f) << "row " << i;
    EXPECT_LT(w.surfaces->lift[i], 0x1p-18f * 400) << "row " << i;
    ++above;
  }
  EXPECT_GT(above, kWave / 8);
}

// The paths of a frame are numbered: a wave may begin anywhere, and numbers beyond 2^32 give other
// paths.
TEST(StartLightPaths, NumbersThePathsOfTheFrame) {
  const RenderJob job(LitFloor(true, true), Request());
  const FrameView frame = job.frame();
  const LightWave whole(frame, 1000, 300), part(frame, 1017, 200);
  const auto bits = [](const LightWave& wave, std::uint32_t begin, std::uint32_t n) {
    auto of = ColumnBits(Slice(wave.worker.of<LightPathTables>().emission.columns(), begin), n);
    const RayColumns rays = Slice(wave.worker.rays[0].columns(), begin);
    for (std::uint32_t i = 0; i < n; ++i) {
      for (const float f : {rays.org_x[i], rays.dir_y[i], rays.throughput_b[i], rays.pdf[i]}) {
        of.push_back(std::bit_cast<std::uint32_t>(f));
      }
    }
    return of;
  };
  EXPECT_EQ(bits(whole, 17, 200), bits(part, 0, 200));
  const LightWave beyond(frame, 1000 + (std::uint64_t{1} << 32), 300);
  EXPECT_NE(bits(whole, 0, 300), bits(beyond, 0, 300));
}

}  // namespace
}  // namespace skywave
