// Tests lights with a shape against the oracle's factors in double: samples, rays that leave them,
// densities and power.
#include "kernels/lights/light_shapes.h"

#include <gtest/gtest.h>

#include <cmath>
#include <vector>

#include "kernels/light_paths/arrival.h"
#include "kernels/light_paths/emission.h"
#include "scene/local_lights.h"
#include "tests/support/oracle_lights.h"
#include "tests/support/random_rows.h"
#include "tests/support/render_scenes.h"
#include "tests/support/statistics.h"
#include "tests/support/targets.h"

namespace skywave {
namespace {

constexpr std::uint32_t kSamples = 40000;
const double kLevel = SidakLevel(24);
const SceneSphere kSphere = {.center = {0, 0, 0}, .radius = 5};

glm::dvec3 Of(Vec v) { return {v.x, v.y, v.z}; }
Vec OnSphere(double z, double turn) {
  const double sine = std::sqrt(std::max(1 - z * z, 0.0));
  return {sine * std::cos(2 * kPi * turn), sine * std::sin(2 * kPi * turn), z};
}

// Each case is one shaped light alone: those of ShapedLights, then a round spot as a shape.
constexpr std::uint32_t kCases = 4;
std::string NameOfCase(const testing::TestParamInfo<std::uint32_t>& test) {
  constexpr const char* kNames[] = {"Stretched", "Goniometric", "Projection", "Round"};
  return kNames[test.param];
}

class ShapedLight : public testing::TestWithParam<std::uint32_t> {
 protected:
  ShapedLight()
      : scene_(SceneOf(GetParam())),
        geometry_(scene_, "test", 1),
        lights_(scene_, geometry_, "test", 2, 0),
        view_(lights_.view()) {}

  static Scene SceneOf(std::uint32_t index) {
    Scene scene;
    Place(scene, Quad(1), AddLambert(scene, "dark", glm::vec3(0.5f)), glm::vec3(0));
    std::vector<PunctualLight> lights = ShapedLights(scene);
    lights.push_back(lights[0]);
    lights.back().form->world_from_light = glm::mat3(2);
    scene.lights = {lights[index]};
    return scene;
  }

  const PunctualLight& light() const { return scene_.lights[0]; }
  glm::dvec3 Factor(Vec direction) const {
    return OracleLightFactor(light(), scene_.images, Of(direction));
  }
  // Returns whether the factor is the same around a direction, where no rounding decides.
  bool IsSteady(Vec direction) const {
    for (const Vec& step :
         {Vec{1, 0, 0}, Vec{-1, 0, 0}, Vec{0, 1, 0}, Vec{0, -1, 0}, Vec{0, 0, 1}, Vec{0, 0, -1}}) {
      const glm::dvec3 change = Factor(direction + 1e-5 * step) - Factor(direction);
      if (glm::length(change) > 0.01) return false;
    }
    return true;
  }

  Scene scene_;
  Geometry geometry_;
  LocalLights lights_;
  LocalLightView view_;
};

// Returns surfaces at a distance of 2 from the light, in these directions.
soa::Table<SurfaceColumns> SurfacesAround(const PunctualLight& light,
                                          const std::vector<Vec>& directions) {
  const auto n = std::uint32_t(directions.size());
  soa::Table<SurfaceColumns> surfaces(n);
  for (std::uint32_t i = 0; i < n; ++i) {
    const Vec at = Vec{light.position.x, light.position.y, light.position.z} + 2 * directions[i];
    Put(at, i, surfaces->org_x, surfaces->org_y, surfaces->org_z);
    surfaces->lift[i] = 0;
  }
  return surfaces;
}

std::vector<Vec> RandomDirections(std::uint32_t n, std::uint32_t seed) {
  Random random(seed);
  std::vector<Vec> directions;
  for (std::uint32_t i = 0; i < n; ++i) {
    directions.push_back(OnSphere(random.Between(-1, 1), random.Between(0, 1)));
  }
  return directions;
}

TEST_P(ShapedLight, SamplesMatchTheOracle) {
  ForEachTarget([&] {
    const std::vector<Vec> directions = RandomDirections(2048, 31);
    const auto surfaces = SurfacesAround(light(), directions);
    const auto uniforms = RandomUniforms(2048, 32);
    soa::Table<LightColumns> out(2048);
    const soa::Table<ReachColumns> reach(2048);
    SampleLocalLights(view_, view_.alone, surfaces, uniforms, 2048, 1, out, reach);
    std::uint32_t lit = 0, compared = 0;
    for (std::uint32_t i = 0; i < 2048; ++i) {
      if (!IsSteady(directions[i])) continue;
      const glm::dvec3 expected = Factor(directions[i]) * glm::dvec3(light().emission) / 4.0;
      ASSERT_NEAR(out->r[i], expected.x, 3e-4 * expected.x + 1e-4) << i;
      ASSERT_NEAR(out->g[i], expected.y, 3e-4 * expected.y + 1e-4) << i;
      ASSERT_NEAR(out->b[i], expected.z, 3e-4 * expected.z + 1e-4) << i;
      lit += expected.x > 0, ++compared;
    }
    EXPECT_GT(lit, 50u);
    EXPECT_GT(compared, 1900u);
  });
}

struct Rays {
  explicit Rays(std::uint32_t n) : rays(n), emission(n), places(n) {}
  Vec Direction(std::uint32_t i) const { return Get(i, rays->dir_x, rays->dir_y, rays->dir_z); }
  soa::Table<RayColumns> rays;
  soa::Table<EmissionColumns> emission;
  soa::Table<HitColumns> places;
};
Rays Emit(const LocalLightView& view, std::uint32_t seed) {
  Rays out(kSamples);
  EmitFromLocalLights(view, view.alone, kSphere, RandomUniforms(kSamples, seed),
                      RandomUniforms(kSamples, seed + 1), kSamples, out.rays, out.emission,
                      out.places);
  return out;
}

TEST_P(ShapedLight, RaysCarryTheOraclesEmission) {
  ForEachTarget([&] {
    const Rays out = Emit(view_, 41);
    for (std::uint32_t i = 0; i < kSamples; ++i) {
      const Vec d = out.Direction(i);
      ASSERT_NEAR(Length(d), 1, 1e-5);
      ASSERT_EQ(out.emission->delta[i], kDeltaPosition);
      ASSERT_EQ(out.emission->light_pdf[i], 1);
      ASSERT_EQ(out.emission->pdf[i], out.rays->pdf[i]);
      ASSERT_EQ(out.places->geom[i], kNoHit);
      if (!IsSteady(d)) continue;
      const double flux = Factor(d).y * double(light().emission.y) / double(out.emission->pdf[i]);
      ASSERT_NEAR(out.rays->throughput_g[i], flux, 1e-3 * flux + 1e-3) << i;
    }
  });
}

// The flux of the rays, the power by which lights are picked, and an integral of the oracle's
// factors over the sphere agree.
TEST_P(ShapedLight, HasThePowerOfItsIntegral) {
  constexpr int kSide = 1500;
  double integral = 0, luminance = 0;
  for (int y = 0; y < kSide; ++y) {
    for (int x = 0; x < kSide; ++x) {
      const glm::vec3 sent(Factor(OnSphere(2 * (y + 0.5) / kSide - 1, (x + 0.5) / kSide)) *
                           glm::dvec3(light().emission));
      integral += double(sent.y), luminance += double(Luminance(&sent.x));
    }
  }
  const double cell = 4 * kPi / (double(kSide) * kSide);
  const LocalLightTotal& total = lights_.totals()[std::size_t(LocalLightKind::kShaped)];
  EXPECT_NEAR(total.power, luminance * cell, 1e-3 * luminance * cell);
  if (GetParam() == 3) {
    const double sr = SpotSolidAngle(light());
    EXPECT_NEAR(total.power, double(Luminance(&light().emission.x)) * sr, 1e-4 * total.power);
  }
  const Rays out = Emit(view_, 51);
  Moments flux;
  for (std::uint32_t i = 0; i < kSamples; ++i) flux.Add(out.rays->throughput_g[i]);
  EXPECT_TRUE(AgreesWith(flux.mean(), flux.standard_error(), integral * cell, kLevel, 2e-3));
}

// The density with which bidirectional paths weight a connection is that of the rays: integrated
// over cells of the sphere it is how many of them go there.
TEST_P(ShapedLight, RaysFollowTheDensityOfArrivals) {
  constexpr int kRows = 12, kColumns = 16, kPoints = 60;
  const Rays out = Emit(view_, 61);
  std::vector<double> observed(kRows * kColumns), expected(kRows * kColumns);
  const auto cell = [](double z, double turn) {
    const int row = std::min(int((z + 1) / 2 * kRows), kRows - 1);
    return std::size_t(row * kColumns + std::min(int(turn * kColumns), kColumns - 1));
  };
  for (std::uint32_t i = 0; i < kSamples; ++i) {
    const Vec d = out.Direction(i);
    const double turn = std::atan2(d.y, d.x) / (2 * kPi);
    ++observed[cell(d.z, turn - std::floor(turn))];
  }
  constexpr int kAcross = kColumns * kPoints, kDown = kRows * kPoints;
  for (int y = 0; y < kDown; ++y) {
    std::vector<Vec> directions;
    for (int x = 0; x < kAcross; ++x) {
      directions.push_back(OnSphere(2 * (y + 0.5) / kDown - 1, (x + 0.5) / kAcross));
    }
    const auto surfaces = SurfacesAround(light(), directions);
    const auto uniforms = RandomUniforms(kAcross, 62);
    soa::Table<LightColumns> samples(kAcross);
    const soa::Table<ReachColumns> reach(kAcross);
    SampleLocalLights(view_, view_.alone, surfaces, uniforms, kAcross, 1, samples, reach);
    std::vector<float> arrival(kAcross + 64);
    SampleArrivals(view_, view_.alone, surfaces, uniforms->u, samples, kAcross, arrival.data());
    for (std::size_t x = 0; x < std::size_t(kAcross); ++x) {
      // The distance of 2 divides by 4.
      const double share = 4 * double(arrival[x]) * 4 * kPi / (double(kDown) * kAcross);
      expected[std::size_t(y / kPoints * kColumns) + x / kPoints] += kSamples * share;
    }
  }
  double sum = 0;
  for (const double e : expected) sum += e;
  EXPECT_NEAR(sum, kSamples, 0.003 * kSamples);
  EXPECT_TRUE(MatchesExpected(observed, expected, kLevel));
}

// What a light path draws goes where there is light: no ray is closed but for a cone's rim.
TEST_P(ShapedLight, ImagesWasteNoRays) {
  if (light().form->mapping == LightMapping::kCone) return;
  const Rays out = Emit(view_, 71);
  for (std::uint32_t i = 0; i < kSamples; ++i) ASSERT_GT(out.rays->t_far[i], 0) << i;
}

TEST_P(ShapedLight, IsTheSameOnEveryTarget) {
  ExpectSameOnEveryTarget([&] {
    const Rays out = Emit(view_, 81);
    return ColumnBits(out.rays.columns(), kSamples);
  });
}

INSTANTIATE_TEST_SUITE_P(All, ShapedLight, testing::Range(0u, kCases), NameOfCase);

}  // namespace
}  // namespace skywave
