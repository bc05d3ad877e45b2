// Tests the statistics of results of skywave bench.
#include <gtest/gtest.h>
#include <sched.h>
#include <signal.h>
#include <sys/stat.h>
#include <unistd.h>

#include <cmath>
#include <random>

#include "base/error.h"
#include "bench/measure/bench_compare.h"
#include "bench/measure/statistics.h"

namespace skywave {
namespace {

using Values = std::vector<double>;

constexpr double kScatter = 0.02;

Values Draw(std::mt19937& random, double median, int count) {
  std::lognormal_distribution<double> draw(std::log(median), kScatter);
  Values values(static_cast<std::size_t>(count));
  for (double& value : values) value = draw(random);
  return values;
}

TEST(BenchStatistics, GeometricMeanOfPowers) {
  EXPECT_NEAR(GeometricMean(Values{1, 4, 16}), 4, 1e-12);
  EXPECT_NEAR(GeometricMean(Values{7}), 7, 1e-12);
}

TEST(BenchStatistics, RelativeDeviationIsThatOfTheSample) {
  EXPECT_DOUBLE_EQ(RelativeDeviation(Values{1, 3}), std::sqrt(2.0) / 2);
  EXPECT_EQ(RelativeDeviation(Values{5}), 0);
}

// Logarithms 0, 2 and 1, 1, 4: means 1 and 2, variances 2 and 3, squared errors 1 and 1; degrees of
// freedom 4 / (1 / 1 + 1 / 2) = 2.67, rounded down to 2.
TEST(BenchStatistics, ThreeQuartersAreKeptAndAtLeastThree) {
  EXPECT_EQ(FastestOf({4, 1, 3, 2, 9, 8, 7, 5}), (Values{1, 2, 3, 4, 5, 7}));
  EXPECT_EQ(FastestOf({3, 1, 2}), (Values{1, 2, 3}));
  EXPECT_EQ(FastestOf({2}), Values{2});
}

// Of 1, e, e^2, e^5 the first three are kept: their mean is e^1, and the variance that of 0, 1, 2,
// 2, which is 11/12. It counts as 11/12 * 3 / (3 * 2).
TEST(BenchStatistics, TrimmedRatioMatchesAHandCalculation) {
  const double e = std::exp(1.0);
  const std::vector<Values> a = {{1, 1, 1, 1}}, b = {{std::pow(e, 5), 1, e * e, e}};
  const Ratio ratio = WelchRatio(a, b, 0.75);
  EXPECT_NEAR(ratio.value, e, 1e-12);
  const double reach = StudentQuantile(2) * std::sqrt(11 / 24.0);
  EXPECT_NEAR(ratio.interval.low, std::exp(1 - reach), 1e-9);
  EXPECT_NEAR(ratio.interval.high, std::exp(1 + reach), 1e-9);
}

TEST(BenchStatistics, WelchRatioMatchesAHandCalculation) {
  const Values a[] = {{1, std::exp(2.0)}}, b[] = {{std::exp(1.0), std::exp(1.0), std::exp(4.0)}};
  const Ratio ratio = WelchRatio(a, b);
  EXPECT_NEAR(ratio.value, std::exp(1.0), 1e-12);
  EXPECT_NEAR(std::log(ratio.interval.low), 1 - 4.3027 * std::sqrt(2.0), 1e-9);
  EXPECT_NEAR(std::log(ratio.interval.high), 1 + 4.3027 * std::sqrt(2.0), 1e-9);
  const Values single[] = {{2}};
  EXPECT_TRUE(std::isnan(WelchRatio(a, single).interval.low));
  const Values same[] = {{2, 2}};
  EXPECT_DOUBLE_EQ(WelchRatio(same, same).interval.high, 1);
}

TEST(BenchStatistics, PairedRatioMatchesAHandCalculation) {
  const Ratio ratio = PairedRatio(Values{1, std::exp(2.0)});
  EXPECT_NEAR(ratio.value, std::exp(1.0), 1e-12);
  EXPECT_NEAR(std::log(ratio.interval.high), 1 + 12.7062, 1e-9);
  EXPECT_TRUE(std::isnan(PairedRatio(Values{3}).interval.low));
}

TEST(BenchStatistics, SlopeMatchesAHandCalculation) {
  const CurvePoint points[] = {{0, 0}, {1, 2}, {2, 1}};  // residuals -0.5, 1, -0.5
  const Slope slope = FitSlope(points);
  EXPECT_NEAR(slope.value, 0.5, 1e-12);
  EXPECT_NEAR(slope.interval.high, 0.5 + 12.7062 * std::sqrt(1.5 / 2), 1e-9);
}

// Both kinds of intervals, and that of a slope, contain the truth in 95 of 100 experiments.
TEST(BenchStatistics, IntervalsCoverTheTruthAsOftenAsTheySay) {
  std::mt19937 random(1);
  constexpr int kExperiments = 4000;
  int welch = 0, paired = 0, slopes = 0;
  for (int i = 0; i < kExperiments; ++i) {
    const Values a[] = {Draw(random, 1, 5), Draw(random, 3, 4)};
    const Values b[] = {Draw(random, 1.1, 7), Draw(random, 3.3, 5)};
    const Interval interval = WelchRatio(a, b).interval;
    welch += interval.low <= 1.1 && 1.1 <= interval.high;
    const Interval pairs = PairedRatio(Draw(random, 1.1, 6)).interval;
    paired += pairs.low <= 1.1 && 1.1 <= pairs.high;
    std::vector<CurvePoint> points;
    for (int x = 0; x < 8; ++x) points.push_back({double(x), std::log(Draw(random, 1, 1)[0])});
    const Interval drift = FitSlope(points).interval;
    slopes += drift.low <= 0 && 0 <= drift.high;
  }
  // Four standard deviations of the count, and as much as degrees that are rounded down may add.
  const double reach = 4 * std::sqrt(0.95 * 0.05 / kExperiments);
  EXPECT_NEAR(double(paired) / kExperiments, 0.95, reach);
  EXPECT_NEAR(double(slopes) / kExperiments, 0.95, reach);
  EXPECT_NEAR(double(welch) / kExperiments, 0.95, reach + 0.005);
}

}  // namespace
}  // namespace skywave
