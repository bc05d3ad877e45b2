// One suite for all strategies: the promises of a strategy decide which checks it undergoes. A line
// in Subjects() adds a new strategy; a missing line fails EveryStrategyIsTested.

#include "lights/strategies/strategy.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <memory>
#include <tuple>
#include <vector>

#include "base/error.h"
#include "kernels/sampler.h"
#include "tests/support/adversarial_maps.h"
#include "tests/support/map_cells.h"
#include "tests/support/shade_points.h"
#include "tests/support/statistics.h"
#include "tests/support/targets.h"
#include "tests/support/taught_visibility.h"

namespace skywave {
namespace {

struct Subject {
  std::string specification;
  // Directions have a density that EvaluateEscaped reports, so histograms and integrals are
  // checked.
  bool has_density = true;
  // The mean of radiance * g / pdf is the integral of radiance * g where the density is positive.
  bool unbiased = true;
  // The density is positive wherever there is light to reflect (see EnvStrategy::complete).
  bool complete = true;
  // The density is positive below the horizon of the surface too.
  bool whole_sphere = true;
  // The mapping is monotone in both uniforms: well-distributed points stay well distributed.
  bool stratified = true;
  // There are no samples where a surface reflects none of the map's light.
  bool for_reflection = false;
  // Densities have borders of their own, beside those of the map's texels.
  bool own_borders = false;
  // A strategy that learns has been taught.
  bool taught = false;
  // Relative difference between densities from two formulae.
  float precision = 2e-6f;
};

const std::vector<Subject>& Subjects() {
  static const std::vector<Subject> subjects = {
      {.specification = "importance"},
      {.specification = "importance:compensate=1", .complete = false},
      {.specification = "importance:compensate=0.25", .complete = false},
      {.specification = "auto"},
      {.specification = "uniform"},
      {.specification = "cosine", .whole_sphere = false},
      {.specification = "warp"},
      {.specification = "alias", .stratified = false},
      {.specification = "presampled:lights=40", .stratified = false},
      {.specification = "presampled:lights=40,from=polyomino", .stratified = false},
      {.specification = "presampled:lights=40,mode=fixed", .has_density = false, .unbiased = false},
      // Cells are selected by differences of sums but evaluated by the terms of the sums.
      {.specification = "product:cells=30",
       .whole_sphere = false,
       .stratified = false,
       .for_reflection = true,
       .precision = 1e-3f},
      {.specification = "portal:texels=64", .own_borders = true},
      {.specification = "visibility:cells=40", .complete = false},
      {.specification = "visibility:cells=40",
       .complete = false,
       .stratified = false,
       .taught = true},
      {.specification = "visibility:cells=40,compensate=0", .stratified = false, .taught = true},
      {.specification = "ris", .has_density = false, .whole_sphere = false},
      {.specification = "bsdf", .has_density = false, .complete = false},
      {.specification = "median-cut:lights=20", .has_density = false, .unbiased = false},
      {.specification = "variance-cut:lights=20", .has_density = false, .unbiased = false},
      {.specification = "penrose:lights=20", .has_density = false, .unbiased = false},
      {.specification = "polyomino:lights=20", .has_density = false, .unbiased = false},
      {.specification = "penrose:lights=40,cluster=F2,clusters=12,pick=power",
       .has_density = false,
       .unbiased = false},
      {.specification = "median-cut:lights=40,cluster=F1,clusters=10",
       .has_density = false,
       .unbiased = false},
      {.specification = "polyomino:lights=40,cluster=F3,separation=30",
       .has_density = false,
       .unbiased = false},
      {.specification = "presampled:lights=40,cluster=F2,clusters=9", .stratified = false},
      {.specification = "hybrid:lights=20", .has_density = false, .unbiased = false},
      {.specification = "hybrid:lights=20,strata=lights,angle=25,cluster=F2,clusters=8,inside=1",
       .has_density = false},
      {.specification = "hybrid:lights=20,from=median-cut,inside=1", .has_density = false},
      {.specification = "hybrid:lights=20,from=polyomino,strata=p,p=1,inside=1",
       .has_density = false},
      {.specification = "hybrid:lights=20,strata=p,p=0.4,pick=power",
       .has_density = false,
       .unbiased = false},
      {.specification = "hybrid:lights=20,strata=p,p=0.4,pick=power,rest=presampled",
       .has_density = false,
       .unbiased = false},
      {.specification = "hybrid:lights=20,strata=lights,rest=presampled,rest-samples=30",
       .has_density = false,
       .unbiased = false},
  };
  return subjects;
}

std::unique_ptr<EnvStrategy> Make(const Subject& subject, const EnvironmentMap& map) {
  auto strategy = MakeStrategy(subject.specification, map);
  if (!subject.taught) return strategy;
  return Teach(dynamic_cast<const VisibilityStrategy&>(*strategy));
}

// Returns a map to test a subject on. Only the subject that draws by portals gets some: `auto`
// would spend a second on their tables in every test, and then draws as `importance` does.
EnvironmentMap MapFor(const Subject& subject, const Image& latlong,
                      const NamedOrientation& orientation) {
  EnvironmentMap map = {latlong, orientation.map_from_world, {}};
  if (subject.own_borders) map.portals = PortalsAroundTheOrigin();
  return map;
}

std::string NameOf(const Subject& subject) {
  std::string name = subject.specification + (subject.taught ? " taught" : "");
  for (char& c : name) c = std::isalnum(static_cast<unsigned char>(c)) ? c : '_';
  return name;
}

const Vec kNormal = Unit({0.3, 0.8, 0.5});
constexpr std::uint32_t kSamples = 40000;
constexpr double kRounding = 2e-6;  // error of a direction and of its transformation to the map
                                    // [rad]

// Evaluates rays along `directions` that compete with light samples; ray i left row i of
// `surfaces`.
soa::Table<EscapeColumns> Evaluate(const EnvStrategy& strategy, const SurfaceColumns& surfaces,
                                   const std::vector<Vec>& directions, float light_samples = 1) {
  const auto count = std::uint32_t(directions.size());
  soa::Table<EscapeColumns> rows(count);
  for (std::uint32_t i = 0; i < count; ++i) {
    Put(directions[i], i, rows->dir_x, rows->dir_y, rows->dir_z);
    rows->pdf[i] = 1;
    rows->from[i] = i;
  }
  const LambertPoints points(surfaces, count);
  soa::Table<LightColumns> samples(count);
  strategy.Sample(points, RandomUniforms(count, 1), count, {}, samples);
  strategy.EvaluateEscaped(points, count, light_samples, rows);
  return rows;
}

// What a ray through the middle of each cell of a map sees that competes with light samples of one
// surface.
struct SeenCells {
  std::vector<float> pdf, r, g, b;
};

SeenCells See(const EnvStrategy& strategy, const MapCells& cells, float samples) {
  constexpr std::size_t kRows = 1 << 15;  // at a time, so that they stay in the cache
  const auto surfaces = SurfacesWith(kNormal, 1);
  const LambertPoints points(surfaces, 1);
  soa::Table<LightColumns> sample(1);
  strategy.Sample(points, RandomUniforms(1, 1), 1, {}, sample);
  soa::Table<EscapeColumns> rows(kRows);
  SeenCells seen;
  for (std::vector<float>* column : {&seen.pdf, &seen.r, &seen.g, &seen.b}) {
    column->reserve(cells.size());
  }
  for (std::size_t begin = 0; begin < cells.size(); begin += kRows) {
    const auto count = std::uint32_t(std::min(kRows, cells.size() - begin));
    for (std::uint32_t i = 0; i < count; ++i) {
      Put(cells.directions()[begin + i], i, rows->dir_x, rows->dir_y, rows->dir_z);
      rows->pdf[i] = 1;
      rows->from[i] = 0;
    }
    strategy.EvaluateEscaped(points, count, samples, rows);
    seen.pdf.insert(seen.pdf.end(), rows->light_pdf, rows->light_pdf + count);
    seen.r.insert(seen.r.end(), rows->radiance_r, rows->radiance_r + count);
    seen.g.insert(seen.g.end(), rows->radiance_g, rows->radiance_g + count);
    seen.b.insert(seen.b.end(), rows->radiance_b, rows->radiance_b + count);
  }
  return seen;
}

using Case = std::tuple<std::size_t, std::size_t, std::size_t>;

class StrategyOnMap : public testing::TestWithParam<Case> {
 protected:
  StrategyOnMap()
      : subject_(Subjects()[std::get<0>(GetParam())]),
        map_(MapFor(subject_, AdversarialMaps()[std::get<1>(GetParam())].latlong,
                    Orientations()[std::get<2>(GetParam())])),
        strategy_(Make(subject_, map_)) {}

  static double Level() {
    return SidakLevel(Subjects().size() * AdversarialMaps().size() * Orientations().size() * 2);
  }
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
      if (std::fabs(pdf - seen->light_pdf[i]) <= 1e-5f * pdf) continue;
      ++exceptions;
      double u, v;
      MapPosition(map_.map_from_world, directions[i], u, v);
      ASSERT_LT(BorderDistance(map_.latlong.width, map_.latlong.height, u, v), kRounding)
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

// All samples of the plan together, each divided by its density (directional lights by 1), must
// give the light of the map, and for unbiased strategies also the light of any part of it.
TEST_P(StrategyOnMap, ThePlanAddsUpToTheMap) {
  constexpr std::uint32_t kRequested = 2;
  const LightPlan plan = strategy_->Plan(kRequested);
  EXPECT_EQ(strategy_->unbiased(), subject_.unbiased);
  if (plan.total() == 0 || !subject_.complete) GTEST_SKIP();
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
        map_.latlong.Pixel(std::clamp(int(u * image.width), 0, image.width - 1),
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
  return NameOf(Subjects()[std::get<0>(info.param)]) + "_" +
         AdversarialMaps()[std::get<1>(info.param)].name + "_" +
         Orientations()[std::get<2>(info.param)].name;
}

INSTANTIATE_TEST_SUITE_P(All, StrategyOnMap,
                         testing::Combine(testing::Range(std::size_t{0}, Subjects().size()),
                                          testing::Range(std::size_t{0}, AdversarialMaps().size()),
                                          testing::Range(std::size_t{0}, Orientations().size())),
                         CaseName);

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

TEST(Strategies, UnknownNamesAndKeysAreRefused) {
  const EnvironmentMap map = {AdversarialMap("OneByOne"), Orientations()[0].map_from_world};
  for (const char* specification :
       {"", "aliases", "importance:", "penrose:lights=0", "penrose:lights=two",
        "penrose:from=penrose", "hybrid:inside=1,pick=power", "hybrid:strata=q",
        "median-cut:lights=3.5", "importance:compensate", "importance:compensate=2",
        "importance:compensate=", "importance:exponent=2", "uniform:compensate=1",
        "importance:compensate=1,", "importance:,compensate=1", ":compensate=1"}) {
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
