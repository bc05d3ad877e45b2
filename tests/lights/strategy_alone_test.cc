// Tests of strategies that need no map of their own: bits, stratification, and what the list
// promises.
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <vector>

#include "base/error.h"
#include "kernels/sampler.h"
#include "lights/light_sets/strata.h"
#include "lights/strategies/strategy.h"
#include "tests/support/adversarial_maps.h"
#include "tests/support/map_cells.h"
#include "tests/support/shade_points.h"
#include "tests/support/statistics.h"
#include "tests/support/strategy_subjects.h"
#include "tests/support/targets.h"
#include "tests/support/taught_visibility.h"

namespace skywave {
namespace {

class StrategyAlone : public testing::TestWithParam<std::size_t> {
 protected:
  const Subject& subject_ = Subjects()[GetParam()];
};

TEST_P(StrategyAlone, BitsDoNotDependOnTarget) {
  for (const NamedMap& named : AdversarialMaps()) {
    const EnvironmentMap map = MapFor(subject_, named.latlong, Orientations()[1]);
    const auto strategy = Make(subject_, map);
    if (strategy->Plan(1).total() == 0) continue;
    const auto surfaces = SurfacesWith(kNormal, kFullWave);
    const auto uniforms = RandomUniforms(kFullWave, 21);
    ExpectSameOnEveryTarget([&] {
      soa::Table<LightColumns> out(kFullWave);
      strategy->Sample(LambertPoints(surfaces, kFullWave), uniforms, kFullWave, {}, out);
      std::vector<Vec> directions(kFullWave);
      for (std::uint32_t i = 0; i < kFullWave; ++i) {
        directions[i] = Get(i, out->dir_x, out->dir_y, out->dir_z);
      }
      auto bits = ColumnBits(out.columns(), kFullWave);
      const auto seen = Evaluate(*strategy, surfaces, directions);
      const auto more = ColumnBits(seen.columns(), kFullWave);
      bits.insert(bits.end(), more.begin(), more.end());
      return bits;
    });
  }
}

TEST_P(StrategyAlone, RowsDoNotDependOnTheirNumber) {
  const EnvironmentMap map = {AdversarialMap("Noise"), Orientations()[1].map_from_world,
                              PortalsAroundTheOrigin()};
  const auto strategy = Make(subject_, map);
  if (strategy->Plan(1).total() == 0) GTEST_SKIP();
  const auto surfaces = SurfacesWith(kNormal, kFullWave);
  const auto uniforms = RandomUniforms(kFullWave, 22);
  soa::Table<LightColumns> full(kFullWave);
  strategy->Sample(LambertPoints(surfaces, kFullWave), uniforms, kFullWave, {}, full);
  ForEachTarget([&] {
    for (const std::uint32_t n : kRowCounts) {
      // Garbage after row n must neither be read as a row nor crash a gather.
      soa::Table<UniformColumns> some(kFullWave);
      soa::Table<SurfaceColumns> some_surfaces(kFullWave);
      soa::Table<LightColumns> out(kFullWave);
      FillWithGarbage(some.columns(), kFullWave);
      FillWithGarbage(some_surfaces.columns(), kFullWave);
      FillWithGarbage(out.columns(), kFullWave);
      for (std::uint32_t i = 0; i < n; ++i) {
        some->u[i] = uniforms->u[i], some->v[i] = uniforms->v[i];
        PutSurface(kNormal, i, some_surfaces);
      }
      strategy->Sample(LambertPoints(some_surfaces, n), some, n, {}, out);
      // the BSDF writes this column
      for (std::uint32_t i = 0; i < n; ++i) out->t_far[i] = full->t_far[i];
      EXPECT_EQ(ColumnBits(out.columns(), n), ColumnBits(full.columns(), n)) << n << " rows";

      soa::Table<EscapeColumns> rows(kFullWave);
      FillWithGarbage(rows.columns(), kFullWave);
      for (std::uint32_t i = 0; i < n; ++i) {
        Put(Get(i, full->dir_x, full->dir_y, full->dir_z), i, rows->dir_x, rows->dir_y,
            rows->dir_z);
        rows->pdf[i] = i % 3 == 0 ? 0.0f : 1.0f;
        rows->from[i] = i;
      }
      strategy->EvaluateEscaped(LambertPoints(some_surfaces, n), n, 1, rows);
      for (std::uint32_t i = 0; i < n; ++i) {
        ASSERT_TRUE(std::isfinite(rows->radiance_r[i])) << "row " << i << " of " << n;
        if (i % 3 != 0 && subject_.has_density) {
          ASSERT_TRUE(std::isfinite(rows->light_pdf[i])) << "row " << i << " of " << n;
        }
      }
    }
  });
}

// A smooth function of a direction. Its mean over the samples, unlike that of radiance / pdf, is
// well behaved for every density.
double Smooth(Vec direction) { return std::exp(Dot(kNormal, direction)); }

// Returns the root mean square, over `seeds` pixels, of the error of the mean of Smooth over n
// samples.
double MeanError(const EnvStrategy& strategy, const SurfaceColumns& surfaces, std::uint32_t n,
                 std::uint32_t seeds, double exact) {
  double squares = 0;
  soa::Table<PathColumns> paths(n);
  soa::Table<UniformColumns> uniforms(n);
  soa::Table<LightColumns> out(n);
  for (std::uint32_t seed = 0; seed < seeds; ++seed) {
    for (std::uint32_t i = 0; i < n; ++i) {
      paths->seed[i] = PixelSeed(seed, 7, 3);
      paths->sample[i] = i;
    }
    DrawUniforms(paths, nullptr, n, SamplePair(0, SampleUse::kLight), {}, uniforms);
    strategy.Sample(LambertPoints(surfaces, n), uniforms, n, {}, out);
    double sum = 0;
    for (std::uint32_t i = 0; i < n; ++i) {
      sum += Smooth(Get(i, out->dir_x, out->dir_y, out->dir_z));
    }
    squares += (sum / n - exact) * (sum / n - exact);
  }
  return std::sqrt(squares / seeds);
}

TEST_P(StrategyAlone, KeepsStratification) {
  if (!subject_.stratified || !subject_.has_density) GTEST_SKIP();
  Image image(256, 128);
  for (int y = 0; y < image.height; ++y) {
    for (int x = 0; x < image.width; ++x) {
      const double level = (1.2 + std::cos(2 * kPi * x / 256.0)) * std::sin(kPi * (y + 0.5) / 128);
      image.Pixel(x, y)[0] = float(level), image.Pixel(x, y)[1] = float(2 * level);
      image.Pixel(x, y)[2] = float(level);
    }
  }
  const EnvironmentMap map = {image, Orientations()[1].map_from_world, PortalsAroundTheOrigin()};
  const auto strategy = Make(subject_, map);
  const auto surfaces = SurfacesWith(kNormal, 4096);
  const MapCells cells(map, subject_.own_borders ? 2048 : 1024);
  const SeenCells seen = See(*strategy, cells, 1);
  double exact = 0;
  for (std::size_t i = 0; i < cells.size(); ++i) {
    exact += Smooth(cells.directions()[i]) * seen.pdf[i] * cells.solid_angle(i);
  }
  const double coarse = MeanError(*strategy, surfaces, 64, 64, exact);
  const double fine = MeanError(*strategy, surfaces, 4096, 64, exact);
  RecordProperty("error_64", std::to_string(coarse));
  RecordProperty("error_4096", std::to_string(fine));
  // Independent points would give a factor of 8.
  EXPECT_GT(coarse / fine, 16) << coarse << " with 64 samples, " << fine << " with 4096";
}

INSTANTIATE_TEST_SUITE_P(All, StrategyAlone, testing::Range(std::size_t{0}, Subjects().size()),
                         [](const testing::TestParamInfo<std::size_t>& alone) {
                           return NameOf(Subjects()[alone.param]);
                         });

TEST(Strategies, EveryStrategyIsTested) {
  for (const StrategyFactory& factory : Strategies()) {
    const bool listed = std::any_of(Subjects().begin(), Subjects().end(), [&](const Subject& s) {
      return s.specification.substr(0, s.specification.find(':')) == factory.name;
    });
    EXPECT_TRUE(listed) << factory.name << " has no line in Subjects()";
    EXPECT_FALSE(factory.description.empty());
    const EnvironmentMap map = {AdversarialMap("Ramp"), Orientations()[0].map_from_world,
                                PortalsAroundTheOrigin()};
    const auto strategy = MakeStrategy(std::string(factory.name), map);
    EXPECT_EQ(strategy->name(), factory.name);
    EXPECT_GE(strategy->table_bytes(), 48u * 24u * 4u);
  }
}

TEST(Strategies, CompensationGivesUpCompleteness) {
  const EnvironmentMap sun = {AdversarialMap("Sun"), Orientations()[0].map_from_world};
  EXPECT_FALSE(MakeStrategy("importance:compensate=1", sun)->complete());
  EXPECT_TRUE(MakeStrategy("importance:compensate=0", sun)->complete());
  // A constant map has nothing above its mean, so it is sampled unchanged.
  const EnvironmentMap flat = {AdversarialMap("Constant"), Orientations()[0].map_from_world};
  EXPECT_TRUE(MakeStrategy("importance:compensate=1", flat)->complete());
}

// Of n light samples and one BSDF sample, each technique leaves the other one's part of the mean.
TEST(Strategies, CompensationIsSharedByLightSamples) {
  const EnvironmentMap map = {AdversarialMap("Noise"), Orientations()[1].map_from_world, {}};
  const MapCells cells(map);
  const auto same = [&](const StrategyUse& use, const char* specification) {
    const SeenCells seen = See(*MakeStrategy("importance", map, use), cells, 1);
    return seen.pdf == See(*MakeStrategy(specification, map), cells, 1).pdf;
  };
  EXPECT_TRUE(same({.mis = true}, "importance:compensate=1"));
  EXPECT_TRUE(same({.mis = true, .light_samples = 4}, "importance:compensate=0.25"));
  EXPECT_TRUE(same({.mis = false, .light_samples = 4}, "importance:compensate=0"));
  EXPECT_TRUE(same({.mis = true, .starts_light_paths = true}, "importance:compensate=0"));
  EXPECT_FALSE(same({.mis = true}, "importance:compensate=0"));
}

// Whatever draws from the rest of the map finds its light, and none of the part that lights stand
// for: the integral of radiance times cosine over B, found texel by texel.
TEST(Strategies, TheRestOfAHybridHasTheLightOfItsStratum) {
  constexpr std::uint32_t kRows = 40000, kRequested = 2;
  const auto surfaces = SurfacesWith(kNormal, kRows);
  for (const char* const name : {"Noise", "Sun", "Ramp"}) {
    const EnvironmentMap map = {AdversarialMap(name), Orientations()[1].map_from_world, {}};
    const Image held = HeldMap(map);
    const SphereMap sphere = MakeSphereMap(held);
    const Image b = StratumImage(sphere, StrataByFraction(sphere, 0.4), false);
    double exact = 0;
    const MapCells cells(map);
    for (std::size_t i = 0; i < cells.size(); ++i) {
      double u, v;
      MapPosition(map.map_from_world, cells.directions()[i], u, v);
      const float* texel = b.Pixel(std::clamp(int(u * b.width), 0, b.width - 1),
                                   std::clamp(int(v * b.height), 0, b.height - 1));
      exact += Weighted(texel[0], texel[1], texel[2]) * cells.solid_angle(i) *
               std::max(0.0, Dot(cells.directions()[i], kNormal));
    }
    for (const char* const rest :
         {"rest=importance", "rest=product,rest-cells=30",
          "rest=presampled,rest-samples=30,rest-mode=jittered,rest-from=variance-cut"}) {
      for (const char* const pick : {"all", "power"}) {
        SCOPED_TRACE(std::string(name) + " " + rest + " " + pick);
        const auto strategy = MakeStrategy(
            std::string("hybrid:lights=8,strata=p,p=0.4,pick=") + pick + "," + rest, map);
        std::vector<double> sums(kRows);
        const LightPlan plan = strategy->Plan(kRequested);
        for (std::uint32_t index = plan.fixed; index < plan.total(); ++index) {
          soa::Table<LightColumns> out(kRows);
          strategy->Sample(LambertPoints(surfaces, kRows), RandomUniforms(kRows, 7 + index), kRows,
                           {.index = index, .requested = kRequested}, out);
          for (std::uint32_t i = 0; i < kRows; ++i) {
            if (!(out->pdf[i] > 0) || std::isinf(out->pdf[i])) continue;
            const Vec direction = Get(i, out->dir_x, out->dir_y, out->dir_z);
            sums[i] += Weighted(out->r[i], out->g[i], out->b[i]) / double(out->pdf[i]) *
                       std::max(0.0, Dot(direction, kNormal));
          }
        }
        Moments moments;
        for (const double sum : sums) moments.Add(sum);
        EXPECT_LT(moments.standard_error(), 0.03 * exact);
        EXPECT_TRUE(AgreesWith(moments.mean(), moments.standard_error(), exact, SidakLevel(18),
                               1e-3 * exact));
      }
    }
  }
}

// The cells of B do not depend on who places the lights of A, if they have a source of their own.
TEST(Strategies, TheRestOfAHybridHasASourceOfItsOwn) {
  constexpr std::uint32_t kRows = 64, kLights = 8;
  const EnvironmentMap map = {AdversarialMap("Noise"), Orientations()[0].map_from_world, {}};
  const auto surfaces = SurfacesWith(kNormal, kRows);
  const auto drawn = [&](const std::string& values) {
    const auto strategy =
        MakeStrategy("hybrid:lights=8,strata=p,rest=presampled,rest-samples=20," + values, map);
    soa::Table<LightColumns> out(kRows);
    strategy->Sample(LambertPoints(surfaces, kRows), RandomUniforms(kRows, 3), kRows,
                     {.index = kLights}, out);
    std::vector<float> x(out->dir_x, out->dir_x + kRows);
    return x;
  };
  EXPECT_EQ(drawn("from=median-cut,rest-from=penrose"), drawn("from=penrose"));
  EXPECT_NE(drawn("from=median-cut,rest-from=penrose"), drawn("from=median-cut"));
  EXPECT_EQ(drawn("from=median-cut,rest-from=same"), drawn("from=median-cut"));
}

TEST(Strategies, UnknownNamesAndKeysAreRefused) {
  const EnvironmentMap map = {AdversarialMap("OneByOne"), Orientations()[0].map_from_world};
  for (const char* specification : {"",
                                    "aliases",
                                    "importance:",
                                    "penrose:lights=0",
                                    "penrose:lights=two",
                                    "penrose:from=penrose",
                                    "hybrid:inside=1,pick=power",
                                    "hybrid:rest=product,inside=1",
                                    "hybrid:rest-from=no",
                                    "hybrid:lights=auto:0.1,file=set.json",
                                    "median-cut:longest=v",
                                    "hybrid:rest-cells=300",
                                    "hybrid:strata=q",
                                    "median-cut:lights=3.5",
                                    "importance:compensate",
                                    "importance:compensate=2",
                                    "importance:compensate=",
                                    "importance:exponent=2",
                                    "uniform:compensate=1",
                                    "importance:compensate=1,",
                                    "importance:,compensate=1",
                                    ":compensate=1"}) {
    if (std::string(specification) == "importance:" ||
        std::string(specification) == "importance:compensate=1,") {
      EXPECT_NO_THROW(MakeStrategy(specification, map)) << specification;
      continue;
    }
    try {
      MakeStrategy(specification, map);
      ADD_FAILURE() << "'" << specification << "' was accepted";
    } catch (const InputError& error) {
      EXPECT_EQ(error.exit_code(), kExitUsage) << specification;
    }
  }
}

}  // namespace
}  // namespace skywave
