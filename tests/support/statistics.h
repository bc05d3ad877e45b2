// Statistical tests with stated error rates: chi-square with pooled cells, Z-tests, moments.
//
// All of them run on fixed seeds, so a test that passes once always passes; the level only states
// how unlikely a chance failure was when the seed was chosen. Levels are Sidak-corrected for the
// number of tests in a suite. Failures print the table that failed.
#pragma once

#include <gtest/gtest.h>

#include <cstddef>
#include <span>
#include <string>

namespace skywave {

// Probability that any test of a suite fails by chance.
inline constexpr double kSuiteLevel = 0.01;

// Returns the level of each of `tests` independent tests such that none fails by chance with
// probability 1 - suite_level (Sidak 1967).
double SidakLevel(std::size_t tests, double suite_level = kSuiteLevel);

// Returns Q(a, x) = Gamma(a, x) / Gamma(a), the upper regularised incomplete gamma function, for a
// > 0 and x >= 0: a series below x = a + 1, Lentz's continued fraction above. The relative error is
// below 1e-12.
double UpperRegularizedGamma(double a, double x);

// Returns the probability that a chi-square variable with `degrees` degrees of freedom is at least
// `statistic`.
double ChiSquarePValue(double statistic, int degrees);
// Returns the probability that a normal variable deviates from its mean by |z| or more.
double NormalPValue(double z);
// Returns the probability that the largest distance between the empirical and the true distribution
// of `samples` values is at least `distance` (Kolmogorov, with Stephens' correction for few
// samples).
double KolmogorovPValue(double distance, std::size_t samples);

// Pearson's test of counts against expected counts (with the same sum, or the rest in a separate
// cell). Cells that expect fewer than 5 are pooled, the smallest first. Counts in cells that expect
// nothing fail the test, unless they total at most `strays`: samples that rounding put on the wrong
// side of a border.
testing::AssertionResult MatchesExpected(std::span<const double> observed,
                                         std::span<const double> expected, double level,
                                         double strays = 0);

// Tests that the values in [0, 1) are uniform (Kolmogorov-Smirnov).
testing::AssertionResult IsUniform(std::span<const float> values, double level);

// Mean and spread of a sample in one pass (Welford).
class Moments {
 public:
  void Add(double value);
  std::size_t count() const { return count_; }
  double mean() const { return mean_; }
  double variance() const { return count_ > 1 ? squares_ / double(count_ - 1) : 0; }
  double standard_error() const;

 private:
  std::size_t count_ = 0;
  double mean_ = 0, squares_ = 0;
};

// Tests that the estimate agrees with `exact` within its standard error. `rounding` allows for
// errors of arithmetic.
testing::AssertionResult AgreesWith(double estimate, double standard_error, double exact,
                                    double level, double rounding = 0);
// Tests that two independent estimates agree.
testing::AssertionResult AgreesWith(const Moments& a, const Moments& b, double level);

}  // namespace skywave
