// Tests the control variate of irradiance: what is subtracted at samples is, on average, what is
// added for certain, whatever the BSDF, the map and the strategy.
#include <gtest/gtest.h>

#include <cmath>

#include "kernels/accumulate.h"
#include "lights/strategies/strategy.h"
#include "lights/tables/vector_irradiance.h"
#include "tests/support/adversarial_maps.h"
#include "tests/support/bsdf_cases.h"
#include "tests/support/map_cells.h"
#include "tests/support/same_bits.h"
#include "tests/support/shade_points.h"
#include "tests/support/statistics.h"
#include "tests/support/targets.h"

namespace skywave {
namespace {

const Vec kShading = Unit({0.36, 0.8, 0.48});
const Vec kGeometric = Unit({-0.3, 0.9, 0.3});  // 40 degrees from it

// Returns control.out for light samples of which there are none: minus the integral.
Vec Integral(const MaterialCase& material, const VectorIrradiance& table, Vec normal) {
  ShadingRows rows(material, 1, normal, AtAngle(normal, 0.7));
  soa::Table<LightColumns> lights(1);
  soa::Table<ControlColumns> out(1);
  Put(normal, 0, lights->dir_x, lights->dir_y, lights->dir_z);
  lights->pdf[0] = 0;
  rows.kernels.evaluate_controlled_lights(
      rows.surfaces, rows.materials(), 1, {},
      {.irradiance = table.view(), .with_integral = true, .out = out}, lights);
  return {-double(out->r[0]), -double(out->g[0]), -double(out->b[0])};
}

// Near the horizon the integral leaves out light that is up to twice as high as kHorizonSine.
TEST(ControlVariate, IntegralIsTheIrradianceButForTheHorizon) {
  const MaterialCase white = {"white", BsdfKind::kLambert, {.color = {1, 1, 1}}};
  for (const NamedMap& named : AdversarialMaps()) {
    for (const NamedOrientation& orientation : Orientations()) {
      SCOPED_TRACE(named.name + " " + orientation.name);
      const EnvironmentMap map = {named.latlong, orientation.map_from_world};
      const VectorIrradiance table(map);
      const Image held = HeldMap(map);
      const MapCells cells(map, 512);
      const int finer = int(
          std::lround(std::sqrt(double(cells.size()) / double(held.width) / double(held.height))));
      Random random(31);
      for (int trial = 0; trial < 8; ++trial) {
        const Vec normal = trial == 0 ? Vec{0, 1, 0} : random.Direction();
        double most = 0, least = 0;
        for (std::size_t i = 0; i < cells.size(); ++i) {
          const int x = int(i % std::size_t(held.width * finer)) / finer;
          const int y = int(i / std::size_t(held.width * finer)) / finer;
          const double cosine = Dot(cells.directions()[i], normal);
          const double light = held.Pixel(x, y)[0] * std::max(cosine, 0.0) * cells.solid_angle(i);
          most += light;
          if (cosine > 2.1 * kHorizonSine) least += light;
        }
        const double found = Integral(white, table, normal).x * kPi;
        EXPECT_GE(found, least * 0.999 - 1e-6) << "normal " << trial;
        EXPECT_LE(found, most * 1.001 + 1e-6) << "normal " << trial;
      }
    }
  }
}

TEST(ControlVariate, BlackMapsAddNothing) {
  const EnvironmentMap map = {Image(8, 4), Orientations()[0].map_from_world};
  const MaterialCase white = {"white", BsdfKind::kLambert, {.color = {1, 1, 1}}};
  EXPECT_EQ(Integral(white, VectorIrradiance(map), kShading).x, 0);
}

class ControlOfBsdf : public testing::TestWithParam<std::uint32_t> {};

// Light samples and scattered rays subtract the control under multiple importance sampling; the
// first light sample adds its integral. On average nothing is left, on either side of a surface
// that transmits and where the shading normal is not that of the triangle.
TEST_P(ControlOfBsdf, AddedAndSubtractedPartsCancelOnAverage) {
  constexpr std::uint32_t kSamples = 200000;
  const MaterialCase& material = ExampleOf(BsdfKind(GetParam()));
  const double level = SidakLevel(kFirstDeltaBsdf * 6);
  for (const char* name : {"Noise", "Sun"}) {
    const EnvironmentMap map = {AdversarialMap(name), Orientations()[1].map_from_world};
    const VectorIrradiance table(map);
    const auto strategy = MakeStrategy("importance:compensate=1", map);
    ShadingRows rows(material, kSamples, kShading, AtAngle(kShading, 0.8));
    for (std::uint32_t i = 0; i < kSamples; ++i) {
      rows.Set(i, kShading, kGeometric, AtAngle(kShading, 0.8));
      rows.surfaces->path[i] = i;
    }
    const LambertPoints points(rows.surfaces, kSamples);
    soa::Table<LightColumns> lights(kSamples);
    soa::Table<ControlColumns> control(kSamples);
    soa::Table<PathColumns> paths(kSamples);
    strategy->Sample(points, RandomUniforms(kSamples, 17), kSamples, {}, lights);
    LightControl known = {.irradiance = table.view(), .with_integral = true, .out = control};
    rows.kernels.evaluate_controlled_lights(rows.surfaces, rows.materials(), kSamples, {}, known,
                                            lights);
    SubtractControl(control, rows.surfaces->path, kSamples, paths);

    soa::Table<RayColumns> rays(kSamples);
    const std::uint32_t n =
        rows.kernels.scatter(rows.surfaces, rows.materials(), ScatterRows(kSamples, 19).view(),
                             kSamples, {.control = &known}, rays, 0);
    soa::Table<EscapeColumns> seen(kSamples);
    for (std::uint32_t i = 0; i < n; ++i) {
      Put(RayDirection(rays, i), i, seen->dir_x, seen->dir_y, seen->dir_z);
      seen->throughput_r[i] = -control->r[i];
      seen->throughput_g[i] = -control->g[i];
      seen->throughput_b[i] = -control->b[i];
      seen->pdf[i] = rays->pdf[i], seen->path[i] = rays->path[i], seen->from[i] = rays->from[i];
    }
    strategy->EvaluateEscaped(points, n, 1, seen);
    AddEscapedRadiance(seen, n, {}, paths);
    for (const float* channel : {paths->r, paths->g, paths->b}) {
      Moments moments;
      double largest = 0;
      for (std::uint32_t i = 0; i < kSamples; ++i) {
        moments.Add(channel[i]);
        largest = std::max(largest, std::abs(double(channel[i])));
      }
      EXPECT_TRUE(AgreesWith(moments.mean(), moments.standard_error(), 0, level, 1e-6 * largest))
          << material.name << " under " << name;
    }
  }
}

INSTANTIATE_TEST_SUITE_P(Dense, ControlOfBsdf, testing::Range(0u, kFirstDeltaBsdf));

TEST(ControlVariate, HasTheSameBitsOnEveryTarget) {
  constexpr std::uint32_t kRows = 501;
  const EnvironmentMap map = {AdversarialMap("Noise"), Orientations()[1].map_from_world};
  const VectorIrradiance table(map);
  const auto strategy = MakeStrategy("importance", map);
  for (std::uint32_t kind = 0; kind < kFirstDeltaBsdf; ++kind) {
    ShadingRows rows(ExampleOf(BsdfKind(kind)), kRows, kShading, AtAngle(kShading, 0.8));
    Random random(23);
    for (std::uint32_t i = 0; i < kRows; ++i) {
      const Vec normal =
          i < 3 ? Vec{i == 0 ? 1.0 : 0, i == 1 ? -1.0 : 0, i == 2 ? 1.0 : 0} : random.Direction();
      rows.Set(i, normal, normal, AtAngle(normal, 0.6));
    }
    const LambertPoints points(rows.surfaces, kRows);
    ExpectSameOnEveryTarget([&] {
      soa::Table<LightColumns> lights(kRows);
      soa::Table<ControlColumns> control(kRows);
      strategy->Sample(points, RandomUniforms(kRows, 3), kRows, {}, lights);
      const LightControl known = {
          .irradiance = table.view(), .with_integral = true, .out = control};
      rows.kernels.evaluate_controlled_lights(rows.surfaces, rows.materials(), kRows, {}, known,
                                              lights);
      auto bits = ColumnBits(control.columns(), kRows);
      soa::Table<RayColumns> rays(kRows);
      const std::uint32_t n =
          rows.kernels.scatter(rows.surfaces, rows.materials(), ScatterRows(kRows, 5).view(), kRows,
                               {.roulette = true, .control = &known}, rays, 0);
      const auto scattered = ColumnBits(control.columns(), n);
      bits.insert(bits.end(), scattered.begin(), scattered.end());
      return bits;
    });
  }
}

TEST(ControlVariate, EveryDiffusePartIsControlled) {
  const EnvironmentMap map = {AdversarialMap("Noise"), Orientations()[1].map_from_world};
  const VectorIrradiance table(map);
  for (std::uint32_t kind = 0; kind < kFirstDeltaBsdf; ++kind) {
    const MaterialCase& material = ExampleOf(BsdfKind(kind));
    const bool diffuse =
        material.kind == BsdfKind::kLambert || material.kind == BsdfKind::kOrenNayar ||
        material.kind == BsdfKind::kDiffuseTransmission || material.kind == BsdfKind::kPhong ||
        material.kind == BsdfKind::kMetallicRoughness ||
        material.kind == BsdfKind::kGlossyDiffuse || material.kind == BsdfKind::kFresnelBlend ||
        material.kind == BsdfKind::kCoatedMetallicRoughness ||
        material.kind == BsdfKind::kLayeredMetallicRoughness ||
        material.kind == BsdfKind::kCoatedDiffuseTransmission ||
        material.kind == BsdfKind::kCoatedDiffuse;
    EXPECT_EQ(Integral(material, table, kShading).x > 0, diffuse) << material.name;
  }
}

// On a normal along an axis of the map nothing is left out, not even at the horizon.
TEST(ControlVariate, IsWholeOnTheAxesOfTheMap) {
  Image white(64, 32);
  std::fill(white.rgb.begin(), white.rgb.end(), 1.0f);
  const EnvironmentMap map = {white, Orientations()[0].map_from_world};
  const VectorIrradiance table(map);
  const MaterialCase matt = {"white", BsdfKind::kLambert, {.color = {1, 1, 1}}};
  for (const Vec axis : {Vec{1, 0, 0}, Vec{0, 1, 0}, Vec{0, 0, 1}}) {
    EXPECT_NEAR(Integral(matt, table, axis).x, 1, 1e-4);
    EXPECT_NEAR(Integral(matt, table, -axis).x, 1, 1e-4);
  }
}

}  // namespace
}  // namespace skywave
