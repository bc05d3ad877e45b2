// Tests the statistical tests themselves: known p-values, and the power to reject.

#include "tests/support/statistics.h"

#include <gtest/gtest.h>

#include <cmath>
#include <vector>

#include "tests/support/random_rows.h"

namespace skywave {
namespace {

TEST(Statistics, IncompleteGammaHasKnownValues) {
  for (const double x : {0.01, 0.5, 1.0, 3.0, 20.0, 200.0}) {
    EXPECT_NEAR(UpperRegularizedGamma(1, x), std::exp(-x), 1e-13 * std::exp(-x) + 1e-15) << x;
    EXPECT_NEAR(UpperRegularizedGamma(0.5, x), std::erfc(std::sqrt(x)),
                1e-11 * std::erfc(std::sqrt(x)) + 1e-15);
    EXPECT_NEAR(UpperRegularizedGamma(3, x), std::exp(-x) * (1 + x + x * x / 2),
                1e-11 * UpperRegularizedGamma(3, x) + 1e-15);
  }
  // These are percentiles of the chi-square distribution (Abramowitz and Stegun, table 26.8).
  EXPECT_NEAR(ChiSquarePValue(3.841458820694124, 1), 0.05, 1e-12);
  EXPECT_NEAR(ChiSquarePValue(18.30703805327515, 10), 0.05, 1e-12);
  EXPECT_NEAR(ChiSquarePValue(149.4492526602962, 100), 0.001, 1e-5);
  EXPECT_NEAR(NormalPValue(1.959963984540054), 0.05, 1e-12);
  EXPECT_NEAR(KolmogorovPValue(1.3581 / (std::sqrt(1e6)), 1000000), 0.05, 1e-4);
}

TEST(Statistics, SidakLevelKeepsTheLevelOfTheSuite) {
  EXPECT_DOUBLE_EQ(SidakLevel(1, 0.01), 0.01);
  EXPECT_NEAR(1 - std::pow(1 - SidakLevel(500, 0.01), 500), 0.01, 1e-12);
}

TEST(Statistics, ChiSquareAcceptsWhatIsThereAndRejectsWhatIsNot) {
  Random random(1);
  std::vector<double> observed(64), expected(64, 1000.0), skewed(64);
  for (int i = 0; i < 64000; ++i) ++observed[std::size_t(random.Float() * 64)];
  for (int i = 0; i < 64; ++i) skewed[i] = i < 32 ? 1030 : 970;
  EXPECT_TRUE(MatchesExpected(observed, expected, 0.001));
  EXPECT_FALSE(MatchesExpected(observed, skewed, 0.001));

  std::vector<double> sparse_observed = {0, 2, 0, 1, 0, 0, 2, 995};
  std::vector<double> sparse_expected = {1, 1, 1, 1, 0.5, 0.5, 1, 994};
  EXPECT_TRUE(MatchesExpected(sparse_observed, sparse_expected, 0.001)) << "small cells are pooled";
  sparse_observed[4] = 30;
  EXPECT_FALSE(MatchesExpected(sparse_observed, sparse_expected, 0.001));

  std::vector<double> impossible = {3, 997}, never = {0, 1000};
  EXPECT_FALSE(MatchesExpected(impossible, never, 0.001));
  EXPECT_TRUE(MatchesExpected(impossible, never, 0.001, 3));
  EXPECT_FALSE(MatchesExpected(std::vector<double>{10}, std::vector<double>{20}, 0.001));
}

TEST(Statistics, KolmogorovSmirnovSeesAShift) {
  Random random(2);
  std::vector<float> values(20000);
  for (float& value : values) value = random.Float();
  EXPECT_TRUE(IsUniform(values, 0.001));
  for (float& value : values) value *= 0.97f;
  EXPECT_FALSE(IsUniform(values, 0.001));
}

TEST(Statistics, MomentsAndZTest) {
  Moments moments, shifted;
  Random random(3);
  for (int i = 0; i < 10000; ++i) {
    const double value = random.Float();
    moments.Add(value), shifted.Add(random.Float() + 0.05);
  }
  EXPECT_NEAR(moments.variance(), 1.0 / 12, 2e-3);
  EXPECT_NEAR(moments.standard_error(), std::sqrt(1.0 / 120000), 1e-4);
  EXPECT_TRUE(AgreesWith(moments.mean(), moments.standard_error(), 0.5, 0.001));
  EXPECT_FALSE(AgreesWith(moments, shifted, 0.001));
  EXPECT_TRUE(AgreesWith(1.0, 0, 1.0, 0.001));
  EXPECT_FALSE(AgreesWith(1.0, 0, 1.1, 0.001));
  EXPECT_TRUE(AgreesWith(1.0, 0, 1.1, 0.001, 0.11)) << "rounding counts for nothing";
}

}  // namespace
}  // namespace skywave
