// Compares statistics of repeated measurements with values computed by hand, and with artificial
// pictures of known bias and variance.
#include <gtest/gtest.h>

#include <cmath>
#include <limits>
#include <random>

#include "bench/measure/converge.h"
#include "bench/measure/error_split.h"
#include "bench/measure/statistics.h"
#include "bench/measure/summary.h"

namespace skywave {
namespace {

constexpr double kInfinity = std::numeric_limits<double>::infinity();

TEST(Statistics, MatchAHandCalculation) {
  const std::vector<double> values = {1, 2, 4, 9};
  EXPECT_DOUBLE_EQ(Mean(values), 4);
  EXPECT_DOUBLE_EQ(SampleVariance(values), (9 + 4 + 0 + 25) / 3.0);
  EXPECT_DOUBLE_EQ(Median({9, 1, 4, 2}), 3);
  EXPECT_DOUBLE_EQ(Median({9, 1, 4}), 4);
  EXPECT_DOUBLE_EQ(Quantile(values, 0), 1);
  EXPECT_DOUBLE_EQ(Quantile(values, 1), 9);
  EXPECT_DOUBLE_EQ(Quantile(values, 0.5), 3);
}

// The quantiles must agree with printed tables.
TEST(Statistics, StudentQuantilesAreThoseOfTheTables) {
  EXPECT_NEAR(StudentQuantile(1), 12.706, 1e-3);
  EXPECT_NEAR(StudentQuantile(3), 3.182, 1e-3);
  EXPECT_NEAR(StudentQuantile(30), 2.042, 1e-3);
  EXPECT_NEAR(StudentQuantile(31), 2.0395, 1e-4);
  EXPECT_NEAR(StudentQuantile(40), 2.0211, 1e-4);
  EXPECT_NEAR(StudentQuantile(1000000), 1.95996, 1e-4);
}

TEST(Statistics, IntervalOfAMeanIsEvenOnALogarithmicScale) {
  // The mean is 4, its standard error 1; the quantile of three degrees of freedom is 3.1824.
  const std::vector<double> values = {4 - std::sqrt(6.0), 4, 4, 4 + std::sqrt(6.0)};
  const Interval interval = MeanInterval(values);
  EXPECT_NEAR(interval.low, 4 * std::exp(-3.1824 / 4), 1e-9);
  EXPECT_NEAR(interval.high, 4 * std::exp(3.1824 / 4), 1e-9);
  EXPECT_TRUE(std::isnan(MeanInterval(std::vector<double>{4}).low));
  EXPECT_EQ(MeanInterval(std::vector<double>{0, 0}).high, 0);
}

// The interval contains the true mean in 95 of 100 experiments.
TEST(Statistics, IntervalsCoverTheMeanAsOftenAsTheySay) {
  std::mt19937 random(1);
  std::lognormal_distribution<double> draw(0, 0.3);
  const double mean = std::exp(0.5 * 0.3 * 0.3);
  constexpr int kExperiments = 4000;
  int covered = 0;
  for (int i = 0; i < kExperiments; ++i) {
    std::vector<double> values(6);
    for (double& value : values) value = draw(random);
    const Interval interval = MeanInterval(values);
    covered += interval.low <= mean && mean <= interval.high;
  }
  EXPECT_NEAR(covered / double(kExperiments), 0.95, 0.02);
}

TEST(Crossing, IsInterpolatedOnLogarithmicScales) {
  // The error is 1 / time, so the level 0.05 is reached at 20, between the points.
  const std::vector<CurvePoint> curve = {{1, 1}, {10, 0.1}, {100, 0.01}};
  const Crossing crossing = FindCrossing(curve, 0.05);
  EXPECT_EQ(crossing.kind, Crossing::kInside);
  EXPECT_NEAR(crossing.x, 20, 1e-9);
  EXPECT_NEAR(FindCrossing(curve, 0.1).x, 10, 1e-9);
  EXPECT_EQ(FindCrossing(curve, 0.1).kind, Crossing::kInside);
  EXPECT_NEAR(FindCrossing(curve, 0.01).x, 100, 1e-9);
  // This curve has another slope: error 1 / time^2.
  EXPECT_NEAR(FindCrossing(std::vector<CurvePoint>{{1, 1}, {100, 1e-4}}, 0.25).x, 2, 1e-9);
}

TEST(Crossing, OutsideOfTheCurveIsABound) {
  const std::vector<CurvePoint> curve = {{2, 1}, {10, 0.1}};
  EXPECT_EQ(FindCrossing(curve, 0.05).kind, Crossing::kBeyond);
  EXPECT_EQ(FindCrossing(curve, 0.05).x, 10);
  EXPECT_EQ(FindCrossing(curve, 2).kind, Crossing::kBefore);
  EXPECT_EQ(FindCrossing(curve, 2).x, 2);
  EXPECT_EQ(FindCrossing(std::vector<CurvePoint>{{3, 1}}, 0.5).kind, Crossing::kBeyond);
  EXPECT_EQ(FindCrossing(std::vector<CurvePoint>{{3, 1}, {5, 0}}, 0.5).x, 5);
}

TEST(Crossing, CountsOnlyWhatStaysBelow) {
  const std::vector<CurvePoint> curve = {{1, 1}, {2, 0.4}, {4, 0.8}, {8, 0.2}};
  const Crossing crossing = FindCrossing(curve, 0.4);
  EXPECT_GT(crossing.x, 4);
  EXPECT_LT(crossing.x, 8);
}

// Returns a picture of one pixel with the same value in every channel.
Image Grey(float value) {
  Image image(1, 1);
  image.rgb = {value, value, value};
  return image;
}

TEST(SplitError, MatchesAHandCalculation) {
  PictureMoments pictures(1, 1);
  for (float value : {3.0f, 5.0f, 7.0f}) pictures.Add(Grey(value));
  EXPECT_DOUBLE_EQ(pictures.mean(0), 5);
  EXPECT_DOUBLE_EQ(pictures.variance(0), 4);
  const Reference reference = MakeReference(Grey(1), Grey(2));
  EXPECT_EQ(reference.image.rgb[0], 1.5f);
  EXPECT_DOUBLE_EQ(*reference.mse, 0.25);
  EXPECT_DOUBLE_EQ(*reference.relative_mse, 0.25 / (2.25 + 0.01));
  const double squared_bias = 3.5 * 3.5 - 4.0 / 3 - 0.25;
  const ErrorSplit split = SplitError(pictures, reference, ErrorMeasure::kMse);
  EXPECT_DOUBLE_EQ(split.squared_bias, squared_bias);
  EXPECT_DOUBLE_EQ(split.variance, 4);
  const ErrorSplit relative = SplitError(pictures, reference, ErrorMeasure::kRelativeMse);
  EXPECT_DOUBLE_EQ(relative.squared_bias, squared_bias / 2.26);
  EXPECT_DOUBLE_EQ(relative.variance, 4 / 2.26);
  // A reference that was read from a file knows its mean noise, or nothing.
  Reference read = reference;
  read.half_difference = Image();
  EXPECT_DOUBLE_EQ(SplitError(pictures, read, ErrorMeasure::kMse).squared_bias, squared_bias);
  read.mse.reset();
  EXPECT_DOUBLE_EQ(SplitError(pictures, read, ErrorMeasure::kMse).squared_bias,
                   squared_bias + 0.25);
}

// Pictures of noise on a gradient, with both quiet and noisy pixels.
class Noise {
 public:
  explicit Noise(unsigned seed) : random_(seed) {}
  Image Picture(double bias, double sigma) {
    Image picture(40, 30);
    for (std::size_t i = 0; i < picture.rgb.size(); ++i) {
      const double loud = i / 3 % 7 == 0 ? 3 : 1;
      picture.rgb[i] = float(0.5 + 0.001 * double(i % 97) + bias + loud * sigma * draw_(random_));
    }
    return picture;
  }
  // Returns the variance of Picture(), averaged over pixels: 1/7 of them have 9 times the variance.
  static double Variance(double sigma) { return sigma * sigma * (1200 + 8 * 172) / 1200.0; }

 private:
  std::mt19937 random_;
  std::normal_distribution<double> draw_;
};

ErrorSplit SplitOf(unsigned seed, double bias, double sigma, int repeats) {
  Noise noise(seed);
  const Reference reference = MakeReference(noise.Picture(0, 0.02), noise.Picture(0, 0.02));
  PictureMoments pictures(40, 30);
  for (int i = 0; i < repeats; ++i) pictures.Add(noise.Picture(bias, sigma));
  return SplitError(pictures, reference, ErrorMeasure::kMse);
}

TEST(SplitError, FindsTheBiasAndTheVarianceThatWerePutIn) {
  const ErrorSplit split = SplitOf(7, 0.05, 0.1, 8);
  EXPECT_NEAR(split.variance, Noise::Variance(0.1), 0.05 * Noise::Variance(0.1));
  EXPECT_NEAR(split.squared_bias, 0.0025, 4 * split.squared_bias_error);
  EXPECT_LT(split.squared_bias_error, 0.0004);
  EXPECT_TRUE(split.biased());
}

TEST(SplitError, EstimatesNoBiasWithoutBiasAndKnowsItsOwnSpread) {
  constexpr int kExperiments = 300;
  std::vector<double> z;
  int biased = 0;
  for (int i = 0; i < kExperiments; ++i) {
    const ErrorSplit split = SplitOf(unsigned(100 + i), 0, 0.1, 3);
    z.push_back(split.squared_bias / split.squared_bias_error);
    biased += split.biased();
  }
  // The mean is 0 and the variance 1, each within four standard errors.
  EXPECT_NEAR(Mean(z), 0, 4 / std::sqrt(double(kExperiments)));
  EXPECT_NEAR(SampleVariance(z), 1, 4 * std::sqrt(2.0 / kExperiments));
  EXPECT_LE(biased, 4);
}

TEST(SplitError, IsNotMisledByOneBrightPixel) {
  Noise noise(3);
  Image half = noise.Picture(0, 0.01);
  half.rgb[30] = 1e4f;
  const Reference reference = MakeReference(half, noise.Picture(0, 0.01));
  PictureMoments pictures(40, 30);
  for (int i = 0; i < 5; ++i) {
    Image picture = noise.Picture(0, 0.1);
    if (i == 2) picture.rgb[600] = 1e3f;
    pictures.Add(picture);
  }
  // The mean square of the reference's noise (7000 and 11) cancels; its product with other noise
  // remains.
  const ErrorSplit split = SplitError(pictures, reference, ErrorMeasure::kMse);
  EXPECT_NEAR(split.squared_bias, 0, 0.5);
  EXPECT_FALSE(split.biased());
}

// Returns errors of `cost` / time, the same in every repeat.
CurveRuns ExactRuns(double cost, int rungs, int repeats) {
  CurveRuns runs;
  for (int rung = 0; rung < rungs; ++rung) {
    const double seconds = std::pow(2, rung);
    runs.seconds.emplace_back(std::size_t(repeats), seconds);
    runs.errors.emplace_back(std::size_t(repeats), cost / seconds);
  }
  return runs;
}

TEST(TargetSummary, ComparesTimesToTheSameError) {
  const TargetSummary summary =
      SummarizeTarget({ExactRuns(1, 6, 4), ExactRuns(0.25, 6, 4), ExactRuns(100, 6, 4)}, {});
  EXPECT_DOUBLE_EQ(summary.target, 1.0 / 32);
  EXPECT_TRUE(summary.from_first);
  EXPECT_NEAR(summary.times[0].time.x, 32, 1e-9);
  EXPECT_NEAR(summary.times[0].speed_up, 1, 1e-9);
  EXPECT_NEAR(summary.times[1].time.x, 8, 1e-9);
  EXPECT_NEAR(summary.times[1].speed_up, 4, 1e-9);
  EXPECT_NEAR(summary.times[1].interval.low, 8, 1e-9);
  EXPECT_NEAR(summary.times[1].interval.high, 8, 1e-9);
  EXPECT_NEAR(summary.times[1].speed_up_interval.low, 4, 1e-9);
  EXPECT_EQ(summary.times[2].time.kind, Crossing::kBeyond);
  EXPECT_EQ(summary.times[2].interval.low, kInfinity);
  EXPECT_TRUE(std::isnan(summary.times[2].speed_up));
  EXPECT_TRUE(std::isnan(summary.times[2].speed_up_interval.low));
}

TEST(TargetSummary, TakesAGivenTarget) {
  const TargetSummary summary = SummarizeTarget({ExactRuns(1, 6, 2), ExactRuns(0.25, 6, 2)}, 0.125);
  EXPECT_FALSE(summary.from_first);
  EXPECT_NEAR(summary.times[0].time.x, 8, 1e-9);
  EXPECT_NEAR(summary.times[1].time.x, 2, 1e-9);
  EXPECT_EQ(SummarizeTarget({ExactRuns(1, 6, 2)}, 3).times[0].interval.high, 0);
}

// A minute in which everything took longer cancels in the ratio, but not in the times.
TEST(TargetSummary, PairsTheRepeatsOfAllCurves) {
  CurveRuns a = ExactRuns(1, 6, 5), b = a;
  for (std::size_t rung = 0; rung < 6; ++rung) {
    for (std::size_t repeat = 0; repeat < 5; ++repeat) {
      const double slow = 1 + double(repeat);
      a.seconds[rung][repeat] *= slow;
      b.seconds[rung][repeat] *= 3 * slow;
    }
  }
  const TargetSummary summary = SummarizeTarget({a, b}, 1.0 / 16);
  EXPECT_GT(summary.times[1].interval.high, 2 * summary.times[1].interval.low);
  EXPECT_NEAR(summary.times[1].speed_up, 1.0 / 3, 1e-9);
  EXPECT_NEAR(summary.times[1].speed_up_interval.low, 1.0 / 3, 1e-9);
  EXPECT_NEAR(summary.times[1].speed_up_interval.high, 1.0 / 3, 1e-9);
}

TEST(Median, OfTheTimesIsWhatACurveHas) {
  CurveRuns runs;
  runs.seconds = {{1, 2, 90}, {4, 5, 6}};
  runs.errors = {{3, 6, 9}, {1, 2, 3}};
  const std::vector<CurvePoint> curve = Curve(runs);
  EXPECT_EQ(curve[0].x, 2);
  EXPECT_EQ(curve[0].y, 6);
  EXPECT_EQ(curve[1].x, 5);
  EXPECT_EQ(curve[1].y, 2);
}

TEST(Ladder, DoublesUpToItsEnd) {
  EXPECT_EQ(DoublingLadder(1), (std::vector<std::uint32_t>{1}));
  EXPECT_EQ(DoublingLadder(8), (std::vector<std::uint32_t>{1, 2, 4, 8}));
  EXPECT_EQ(DoublingLadder(10), (std::vector<std::uint32_t>{1, 2, 4, 8, 10}));
}

TEST(Ladder, RoundsToThreeLeadingBits) {
  EXPECT_EQ(RoundSamplesDown(0.2), 1u);
  EXPECT_EQ(RoundSamplesDown(7.9), 7u);
  EXPECT_EQ(RoundSamplesDown(9), 8u);
  EXPECT_EQ(RoundSamplesDown(127), 112u);
  EXPECT_EQ(RoundSamplesDown(100), 96u);
}

TEST(Seeds, AreNeverSharedByMeasurementsThatHaveToBeIndependent) {
  std::vector<std::uint32_t> seeds = {ReferenceSeed(3, 0), ReferenceSeed(3, 1)};
  for (std::size_t rung = 0; rung < 64; ++rung) {
    for (int repeat = 0; repeat < 1000; ++repeat) seeds.push_back(RunSeed(3, rung, repeat));
  }
  EXPECT_GE(*std::min_element(seeds.begin(), seeds.end()), 1u << 20);
  std::sort(seeds.begin(), seeds.end());
  EXPECT_EQ(std::adjacent_find(seeds.begin(), seeds.end()), seeds.end());
}

}  // namespace
}  // namespace skywave
