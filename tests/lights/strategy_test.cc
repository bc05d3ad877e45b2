// One suite for all strategies (tests/support/strategy_subjects.h): the promises of a strategy
// decide which checks it undergoes.

#include "lights/strategies/strategy.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <memory>
#include <vector>

#include "base/error.h"
#include "tests/support/adversarial_maps.h"
#include "tests/support/map_cells.h"
#include "tests/support/shade_points.h"
#include "tests/support/statistics.h"
#include "tests/support/strategy_subjects.h"
#include "tests/support/targets.h"
#include "tests/support/taught_visibility.h"

namespace skywave {
namespace {

struct Case {
  std::size_t subject, map, orientation;
};
// Returns every strategy on every map. Orientations take turns, so that every strategy and every
// map meet all of them.
std::vector<Case> Cases() {
  std::vector<Case> cases;
  for (std::size_t subject = 0; subject < Subjects().size(); ++subject) {
    for (std::size_t map = 0; map < AdversarialMaps().size(); ++map) {
      cases.push_back({subject, map, (subject + map) % Orientations().size()});
    }
  }
  return cases;
}

class StrategyOnMap : public testing::TestWithParam<Case> {
 protected:
  StrategyOnMap()
      : subject_(Subjects()[GetParam().subject]),
        map_(MapFor(subject_, AdversarialMaps()[GetParam().map].latlong,
                    Orientations()[GetParam().orientation])),
        strategy_(Make(subject_, map_)) {}

  static double Level() { return SidakLevel(Cases().size() * 2); }
  soa::Table<LightColumns> Draw(const SurfaceColumns& surfaces, std::uint32_t seed) const {
    soa::Table<LightColumns> out(kSamples);
    strategy_->Sample(LambertPoints(surfaces, kSamples), RandomUniforms(kSamples, seed), kSamples,
                      {}, out);
    return out;
  }

  // Cells of the map for the midpoint rule.
  MapCells Cells() const { return MapCells(map_, subject_.own_borders ? 2048 : 256); }
  // Densities that are constant within a texel of the map are summed exactly.
  double QuadratureError() const {
    return subject_.own_borders ? 1e-2 : subject_.whole_sphere ? 1e-5 : 2e-4;
  }

  void DensityIntegratesToOne(const MapCells& cells, const SeenCells& seen) const;
  void DensityIsPositiveWhereThereIsLight(const MapCells& cells, const SeenCells& seen) const;
  void DirectionsFollowTheDensity(const MapCells& cells, const SeenCells& seen) const;
  void EstimatesAreUnbiased(const MapCells& cells, const SeenCells& seen) const;

  const Subject& subject_;
  const EnvironmentMap map_;
  const std::unique_ptr<EnvStrategy> strategy_;
};

// The next four are checks of one test, because the cells of a map and what is seen in them take
// most of its time.
void StrategyOnMap::DensityIntegratesToOne(const MapCells& cells, const SeenCells& seen) const {
  double integral = 0;
  for (std::size_t i = 0; i < cells.size(); ++i) {
    ASSERT_GE(seen.pdf[i], 0) << "cell " << i;
    integral += seen.pdf[i] * cells.solid_angle(i);
  }
  if (subject_.for_reflection && integral == 0) {
    for (std::size_t i = 0; i < cells.size(); ++i) {
      const bool light = seen.r[i] + seen.g[i] + seen.b[i] > 0;
      ASSERT_FALSE(light && Dot(cells.directions()[i], kNormal) > 0) << "cell " << i;
    }
    return;
  }
  EXPECT_NEAR(integral, 1, QuadratureError());
}

void StrategyOnMap::DensityIsPositiveWhereThereIsLight(const MapCells& cells,
                                                       const SeenCells& seen) const {
  EXPECT_TRUE(strategy_->complete());
  for (std::size_t i = 0; i < cells.size(); ++i) {
    if (!subject_.whole_sphere && Dot(cells.directions()[i], kNormal) < 1e-6) continue;
    const float light = seen.r[i] + seen.g[i] + seen.b[i];
    ASSERT_TRUE(seen.pdf[i] > 0 || light == 0) << "cell " << i << " with radiance " << light;
  }
}

void StrategyOnMap::DirectionsFollowTheDensity(const MapCells& cells, const SeenCells& seen) const {
  const auto surfaces = SurfacesWith(kNormal, kSamples);
  std::vector<double> expected(MapCells::kAcross * MapCells::kDown), observed(expected.size());
  for (std::size_t i = 0; i < cells.size(); ++i) {
    expected[cells.BinOfCell(i)] += kSamples * double(seen.pdf[i]) * cells.solid_angle(i);
  }
  const auto samples = Draw(surfaces, 11);
  for (std::uint32_t i = 0; i < kSamples; ++i) {
    if (subject_.for_reflection && !(samples->pdf[i] > 0)) continue;
    ++observed[cells.BinOf(Get(i, samples->dir_x, samples->dir_y, samples->dir_z))];
  }
  EXPECT_TRUE(MatchesExpected(observed, expected, Level(), 1e-3 * kSamples));
}

void StrategyOnMap::EstimatesAreUnbiased(const MapCells& cells, const SeenCells& seen) const {
  const auto surfaces = SurfacesWith(kNormal, kSamples);
  const auto samples = Draw(surfaces, 14);
  for (const bool reflected : {false, true}) {
    const auto response = [&](Vec w) { return reflected ? std::max(0.0, Dot(w, kNormal)) : 1.0; };
    double integral = 0, second = 0;
    for (std::size_t i = 0; i < cells.size(); ++i) {
      const double density = seen.pdf[i];
      if (density <= 0) continue;
      const double f = response(cells.directions()[i]) * Weighted(seen.r[i], seen.g[i], seen.b[i]);
      integral += f * cells.solid_angle(i);
      second += f * f / density * cells.solid_angle(i);
    }
    Moments moments;
    for (std::uint32_t i = 0; i < kSamples; ++i) {
      if (!(samples->pdf[i] > 0)) continue;
      moments.Add(response(Get(i, samples->dir_x, samples->dir_y, samples->dir_z)) *
                  Weighted(samples->r[i], samples->g[i], samples->b[i]) / samples->pdf[i]);
    }
    // If too few samples count (a sun that uniform samples rarely hit), the mean is not normally
    // distributed.
    if (second > 0 && kSamples * integral * integral < 50 * second) continue;
    const double variance = std::max(0.0, second - integral * integral);
    // Cells at the horizon are counted as a whole or not at all.
    const double rounding =
        (reflected || !subject_.whole_sphere ? 1e-3 : QuadratureError()) * integral;
    EXPECT_TRUE(
        AgreesWith(moments.mean(), std::sqrt(variance / kSamples), integral, Level(), rounding))
        << (reflected ? "radiance times cosine" : "radiance");
  }
}

TEST_P(StrategyOnMap, DensityIsThatOfTheSamples) {
  if (!subject_.has_density) GTEST_SKIP();
  const MapCells cells = Cells();
  const SeenCells seen = See(*strategy_, cells, 1);
  {
    SCOPED_TRACE("the density integrates to one");
    DensityIntegratesToOne(cells, seen);
  }
  if (subject_.complete) {
    SCOPED_TRACE("the density is positive where there is light");
    DensityIsPositiveWhereThereIsLight(cells, seen);
  }
  {
    SCOPED_TRACE("directions follow the density");
    DirectionsFollowTheDensity(cells, seen);
  }
  if (subject_.unbiased) {
    SCOPED_TRACE("estimates are unbiased");
    EstimatesAreUnbiased(cells, seen);
  }
}

// The sum of all densities of the plan is the weight against which BSDF samples compete.
TEST_P(StrategyOnMap, DensitiesOfThePlanAddUpToItsSamples) {
  if (!strategy_->unbiased() || !strategy_->shines_on_bsdf_samples() || !subject_.whole_sphere) {
    GTEST_SKIP();
  }
  constexpr std::uint32_t kRequested = 3;
  const MapCells cells = Cells();
  const SeenCells seen = See(*strategy_, cells, kRequested);
  double integral = 0;
  for (std::size_t i = 0; i < cells.size(); ++i) integral += seen.pdf[i] * cells.solid_angle(i);
  const std::uint32_t samples = strategy_->Plan(kRequested).total();
  EXPECT_NEAR(integral, samples, QuadratureError() * samples);
}

// Strategies of lights and random samples together have a density for the latter. BSDF samples are
// weighted against it, so it is the same from both sides.
TEST_P(StrategyOnMap, RandomSamplesAmongLightsAreWhatEvaluationSees) {
  if (subject_.has_density || !strategy_->shines_on_bsdf_samples()) GTEST_SKIP();
  constexpr std::uint32_t kRequested = 3, kRows = 2000;
  const auto surfaces = SurfacesWith(kNormal, kRows);
  const std::uint32_t all = strategy_->Plan(kRequested).total();
  std::uint32_t exceptions = 0;
  for (std::uint32_t index = 0; index < all; ++index) {
    soa::Table<LightColumns> samples(kRows);
    strategy_->Sample(LambertPoints(surfaces, kRows), RandomUniforms(kRows, 200 + index), kRows,
                      {.index = index, .requested = kRequested}, samples);
    std::vector<Vec> directions(kRows);
    for (std::uint32_t i = 0; i < kRows; ++i) {
      directions[i] = Get(i, samples->dir_x, samples->dir_y, samples->dir_z);
    }
    const auto seen = Evaluate(*strategy_, surfaces, directions, kRequested);
    for (std::uint32_t i = 0; i < kRows; ++i) {
      const float pdf = samples->pdf[i];
      if (!(pdf > 0) || std::isinf(pdf)) continue;
      double u, v;
      MapPosition(map_.map_from_world, directions[i], u, v);
      const int row = std::min(int(v * map_.latlong->height), map_.latlong->height - 1);
      // Cells that are picked by differences of sums have the rounding of these.
      const double of_sums =
          subject_.for_reflection
              ? kRequested * 0x1p-25 / RowSolidAngle(map_.latlong->width, map_.latlong->height, row)
              : 0;
      const double precision = std::max(1e-5f, subject_.precision);
      if (std::fabs(pdf - seen->light_pdf[i]) <= precision * pdf + of_sums) continue;
      ++exceptions;
      ASSERT_LT(BorderDistance(map_.latlong->width, map_.latlong->height, u, v), kRounding)
          << "sample " << index << ", row " << i << ": drawn with " << pdf << ", seen with "
          << seen->light_pdf[i];
    }
  }
  EXPECT_LE(exceptions, all * kRows / 500);
}

TEST_P(StrategyOnMap, SamplesAreWhatEvaluationSees) {
  if (!subject_.has_density) GTEST_SKIP();
  soa::Table<SurfaceColumns> surfaces(kSamples);
  Random random(12);
  for (std::uint32_t i = 0; i < kSamples; ++i) {
    PutSurface(random.Direction(), i, surfaces);
  }
  const auto samples = Draw(surfaces, 13);
  std::vector<Vec> directions(kSamples);
  for (std::uint32_t i = 0; i < kSamples; ++i) {
    directions[i] = Get(i, samples->dir_x, samples->dir_y, samples->dir_z);
    ASSERT_NEAR(Length(directions[i]), 1, 2e-6) << "row " << i;
    if (subject_.for_reflection && samples->pdf[i] == 0) continue;
    // At the horizon a density may vanish.
    if (subject_.whole_sphere) {
      ASSERT_GT(samples->pdf[i], 0) << "row " << i;
    }
    ASSERT_TRUE(std::isfinite(samples->pdf[i]) && samples->pdf[i] >= 0) << "row " << i;
    for (const float value : {samples->r[i], samples->g[i], samples->b[i]}) {
      ASSERT_TRUE(std::isfinite(value) && value >= 0) << "row " << i << ": " << value;
    }
  }
  const auto seen = Evaluate(*strategy_, surfaces, directions);
  const Image image = HeldMap(map_);
  std::uint32_t exceptions = 0;
  for (std::uint32_t i = 0; i < kSamples; ++i) {
    if (subject_.for_reflection && samples->pdf[i] == 0) continue;
    double u, v;
    MapPosition(map_.map_from_world, directions[i], u, v);
    const bool at_border = BorderDistance(image.width, image.height, u, v) < kRounding;
    const float* texel = image.Pixel(std::clamp(int(u * image.width), 0, image.width - 1),
                                     std::clamp(int(v * image.height), 0, image.height - 1));
    const float density_error = std::fabs(samples->pdf[i] - seen->light_pdf[i]);
    // A cosine has an absolute precision, near the horizon too.
    const bool same = density_error <= subject_.precision * samples->pdf[i] +
                                           (subject_.whole_sphere ? 0 : 2e-7f) &&
                      samples->r[i] == seen->radiance_r[i] &&
                      samples->g[i] == seen->radiance_g[i] && samples->b[i] == seen->radiance_b[i];
    const bool right =
        samples->r[i] == texel[0] && samples->g[i] == texel[1] && samples->b[i] == texel[2];
    if (same && right) continue;
    ++exceptions;
    ASSERT_TRUE(at_border || subject_.own_borders)
        << "row " << i << " at u = " << u << ", v = " << v << " (" << u * image.width << ", "
        << v * image.height << "): drawn with " << samples->pdf[i] << " and radiance "
        << samples->r[i] << ", seen with " << seen->light_pdf[i] << " and " << seen->radiance_r[i]
        << ", texel " << texel[0];
  }
  EXPECT_LE(exceptions, kSamples / 500);
}

// Where the tables do not depend on how the map lies, they serve a map that lies otherwise, and
// outlive the strategy that they were made for.
TEST_P(StrategyOnMap, IsTheSameWithTablesOfAnotherOrientation) {
  const std::size_t other = (GetParam().orientation + 1) % Orientations().size();
  std::unique_ptr<EnvStrategy> turned;
  {
    const EnvironmentMap map = MapFor(subject_, map_.latlong, Orientations()[other]);
    turned = Make(subject_, map)->Turned(map_);
  }
  if (!turned) GTEST_SKIP();
  EXPECT_EQ(turned->name(), strategy_->name());
  EXPECT_EQ(turned->table_bytes(), strategy_->table_bytes());
  EXPECT_EQ(turned->complete(), strategy_->complete());
  constexpr std::uint32_t kRows = 1000;
  const auto surfaces = SurfacesWith(kNormal, kRows);
  soa::Table<LightColumns> drawn[2] = {soa::Table<LightColumns>(kRows),
                                       soa::Table<LightColumns>(kRows)};
  const EnvStrategy* const strategies[] = {strategy_.get(), turned.get()};
  for (int i = 0; i < 2; ++i) {
    strategies[i]->Sample(LambertPoints(surfaces, kRows), RandomUniforms(kRows, 5), kRows, {},
                          drawn[i]);
  }
  std::vector<Vec> directions;
  for (std::uint32_t i = 0; i < kRows; ++i) {
    directions.push_back(Get(i, drawn[0]->dir_x, drawn[0]->dir_y, drawn[0]->dir_z));
    ASSERT_EQ(drawn[0]->dir_x[i], drawn[1]->dir_x[i]) << i;
    ASSERT_EQ(drawn[0]->dir_y[i], drawn[1]->dir_y[i]) << i;
    ASSERT_EQ(drawn[0]->pdf[i], drawn[1]->pdf[i]) << i;
    ASSERT_EQ(drawn[0]->g[i], drawn[1]->g[i]) << i;
  }
  const auto seen = Evaluate(*strategy_, surfaces, directions);
  const auto seen_by_turned = Evaluate(*turned, surfaces, directions);
  for (std::uint32_t i = 0; i < kRows; ++i) {
    ASSERT_EQ(seen->light_pdf[i], seen_by_turned->light_pdf[i]) << i;
    ASSERT_EQ(seen->radiance_r[i], seen_by_turned->radiance_r[i]) << i;
  }
}

// All samples of the plan together, each divided by its density (directional lights by 1), must
// give the light of the map, and for unbiased strategies also the light of any part of it.
TEST_P(StrategyOnMap, ThePlanAddsUpToTheMap) {
  constexpr std::uint32_t kRequested = 2;
  const LightPlan plan = strategy_->Plan(kRequested);
  EXPECT_EQ(strategy_->unbiased(), subject_.unbiased);
  if (plan.total() == 0 || !subject_.complete) GTEST_SKIP();
  // A light has the energy of its cell, but not that of any response to it.
  if (!subject_.unbiased && !subject_.whole_sphere) GTEST_SKIP();
  const Image image = HeldMap(map_);
  double exact[2] = {}, whole = 0;
  const MapCells cells(map_);  // densities do not matter
  // Both responses vanish where the strategy has no samples.
  const auto share = [&](Vec w) {
    return subject_.whole_sphere ? 1 : std::max(0.0, Dot(w, kNormal));
  };
  const auto response = [&](Vec w) { return share(w) * (0.5 + std::max(0.0, Dot(w, kNormal))); };
  for (std::uint32_t i = 0; i < cells.size(); ++i) {
    double u, v;
    MapPosition(map_.map_from_world, cells.directions()[i], u, v);
    const float* texel = image.Pixel(std::clamp(int(u * image.width), 0, image.width - 1),
                                     std::clamp(int(v * image.height), 0, image.height - 1));
    const double light = Weighted(texel[0], texel[1], texel[2]) * cells.solid_angle(i);
    exact[0] += light * share(cells.directions()[i]);
    exact[1] += light * response(cells.directions()[i]);
    const float* original =
        map_.latlong->Pixel(std::clamp(int(u * image.width), 0, image.width - 1),
                            std::clamp(int(v * image.height), 0, image.height - 1));
    whole += Weighted(original[0], original[1], original[2]) * cells.solid_angle(i) *
             share(cells.directions()[i]);
  }
  constexpr std::uint32_t kRows = 4096;
  const auto surfaces = SurfacesWith(kNormal, kRows);
  std::vector<double> sums[2];
  for (auto& sum : sums) sum.resize(kRows);
  for (std::uint32_t index = 0; index < plan.total(); ++index) {
    soa::Table<LightColumns> out(kRows);
    strategy_->Sample(LambertPoints(surfaces, kRows), RandomUniforms(kRows, 100 + index), kRows,
                      {.index = index, .requested = kRequested}, out);
    for (std::uint32_t i = 0; i < kRows; ++i) {
      if (!(out->pdf[i] > 0)) continue;
      const double worth = std::isinf(out->pdf[i]) ? 1 : 1 / double(out->pdf[i]);
      const double light = Weighted(out->r[i], out->g[i], out->b[i]) * worth;
      const Vec direction = Get(i, out->dir_x, out->dir_y, out->dir_z);
      ASSERT_NEAR(Length(direction), 1, 2e-6) << "sample " << index << ", row " << i;
      sums[0][i] += light * share(direction);
      sums[1][i] += light * response(direction);
    }
  }
  // Lights carry the energy of the map, random samples the energy that packing has kept.
  for (const int kind : {0, 1}) {
    if (kind == 1 && !subject_.unbiased) continue;
    Moments moments;
    for (const double sum : sums[kind]) moments.Add(sum);
    // If hardly any sample finds the light (a sun under uniform samples), the mean is not normally
    // distributed.
    if (moments.standard_error() > 0.03 * exact[kind]) continue;
    EXPECT_TRUE(AgreesWith(moments.mean(), moments.standard_error(), exact[kind], Level(),
                           2e-4 * exact[kind] + std::fabs(whole - exact[0])))
        << (kind == 0 ? "light" : "light times a response");
  }
}

std::string CaseName(const testing::TestParamInfo<Case>& info) {
  return NameOf(Subjects()[info.param.subject]) + "_" + AdversarialMaps()[info.param.map].name +
         "_" + Orientations()[info.param.orientation].name;
}

INSTANTIATE_TEST_SUITE_P(All, StrategyOnMap, testing::ValuesIn(Cases()), CaseName);

}  // namespace
}  // namespace skywave
