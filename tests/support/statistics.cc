#include "tests/support/statistics.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <numeric>
#include <vector>

namespace skywave {

double SidakLevel(std::size_t tests, double suite_level) {
  return -std::expm1(std::log1p(-suite_level) / double(tests));
}

double UpperRegularizedGamma(double a, double x) {
  if (x <= 0) return 1;
  const double scale = std::exp(a * std::log(x) - x - std::lgamma(a));
  constexpr double kEpsilon = 1e-16;
  constexpr int kMaxTerms = 100000;
  if (x < a + 1) {
    // P(a, x) = x^a e^-x / Gamma(a) * sum x^n / (a (a + 1) ... (a + n)).
    double term = 1 / a, sum = term;
    for (int n = 1; n < kMaxTerms && term > sum * kEpsilon; ++n) sum += term *= x / (a + n);
    return 1 - scale * sum;
  }
  // This is Abramowitz and Stegun 6.5.31, even part, by modified Lentz.
  constexpr double kTiny = 1e-300;
  double b = x + 1 - a, c = 1 / kTiny, d = 1 / b, fraction = d;
  for (int n = 1; n < kMaxTerms; ++n) {
    const double numerator = -n * (n - a);
    b += 2;
    d = numerator * d + b;
    if (std::fabs(d) < kTiny) d = kTiny;
    c = b + numerator / c;
    if (std::fabs(c) < kTiny) c = kTiny;
    d = 1 / d;
    fraction *= d * c;
    if (std::fabs(d * c - 1) < kEpsilon) break;
  }
  return scale * fraction;
}

double ChiSquarePValue(double statistic, int degrees) {
  return UpperRegularizedGamma(0.5 * degrees, 0.5 * statistic);
}

double NormalPValue(double z) { return std::erfc(std::fabs(z) / std::sqrt(2.0)); }

double KolmogorovPValue(double distance, std::size_t samples) {
  const double root = std::sqrt(double(samples));
  const double t = (root + 0.12 + 0.11 / root) * distance;
  if (t < 0.2) return 1;
  double sum = 0;
  for (int k = 1; k <= 100; ++k) sum += (k % 2 == 1 ? 2 : -2) * std::exp(-2.0 * k * k * t * t);
  return std::clamp(sum, 0.0, 1.0);
}

testing::AssertionResult MatchesExpected(std::span<const double> observed,
                                         std::span<const double> expected, double level,
                                         double strays) {
  if (observed.size() != expected.size()) {
    return testing::AssertionFailure()
           << observed.size() << " counts, " << expected.size() << " expectations";
  }
  for (std::size_t i = 0; i < expected.size(); ++i) {
    if (!(expected[i] >= 0) || !std::isfinite(expected[i])) {
      return testing::AssertionFailure() << "cell " << i << " expects " << expected[i];
    }
  }
  std::vector<std::size_t> order(observed.size());
  std::iota(order.begin(), order.end(), std::size_t{0});
  std::stable_sort(order.begin(), order.end(),
                   [&](std::size_t a, std::size_t b) { return expected[a] < expected[b]; });

  struct Row {
    std::size_t first_cell, cells;
    double observed, expected, share;
  };
  std::vector<Row> table;
  double stray = 0;
  Row pool = {};
  for (const std::size_t i : order) {
    // An expectation of a few millionths of a sample is a rounded zero.
    if (expected[i] <= 1e-6) {
      stray += observed[i];
      continue;
    }
    if (pool.cells == 0) pool.first_cell = i;
    ++pool.cells;
    pool.observed += observed[i], pool.expected += expected[i];
    if (pool.expected >= 5) table.push_back(pool), pool = {};
  }
  // The remainder expects less than 5 and is so small that it would distort the test.
  if (pool.cells != 0 && !table.empty()) {
    table.back().cells += pool.cells;
    table.back().observed += pool.observed, table.back().expected += pool.expected;
  } else if (pool.cells != 0) {
    table.push_back(pool);
  }
  if (stray > strays) {
    return testing::AssertionFailure()
           << stray << " samples in cells that expect none; " << strays << " may be rounding";
  }
  double statistic = 0;
  for (Row& row : table) {
    const double difference = row.observed - row.expected;
    statistic += row.share = difference * difference / row.expected;
  }
  const int degrees = int(table.size()) - 1;
  if (degrees < 1) {
    // With one cell, everything has to be in it.
    const Row row = table.empty() ? Row{} : table[0];
    if (std::fabs(row.observed + stray - row.expected) <= 1e-3 * row.expected + strays) {
      return testing::AssertionSuccess();
    }
    return testing::AssertionFailure()
           << "one cell with " << row.observed << " samples, expected " << row.expected;
  }
  const double p = ChiSquarePValue(statistic, degrees);
  if (p >= level) return testing::AssertionSuccess();

  std::sort(table.begin(), table.end(),
            [](const Row& a, const Row& b) { return a.share > b.share; });
  std::string dump = fmt::format(
      "chi-square {:.1f} with {} degrees of freedom, p = {:.3g} below the level {:.3g}; worst rows "
      "of "
      "{}:\n  first cell  cells    observed    expected  chi-square\n",
      statistic, degrees, p, level, table.size());
  for (std::size_t i = 0; i < std::min<std::size_t>(table.size(), 40); ++i) {
    const Row& row = table[i];
    dump += fmt::format("  {:10} {:6} {:11} {:11.2f} {:11.2f}\n", row.first_cell, row.cells,
                        row.observed, row.expected, row.share);
  }
  return testing::AssertionFailure() << dump;
}

testing::AssertionResult IsUniform(std::span<const float> values, double level) {
  std::vector<float> sorted(values.begin(), values.end());
  std::sort(sorted.begin(), sorted.end());
  const double n = double(sorted.size());
  double distance = 0;
  for (std::size_t i = 0; i < sorted.size(); ++i) {
    distance = std::max({distance, sorted[i] - double(i) / n, double(i + 1) / n - sorted[i]});
  }
  const double p = KolmogorovPValue(distance, sorted.size());
  if (p >= level) return testing::AssertionSuccess();
  return testing::AssertionFailure() << fmt::format(
             "Kolmogorov distance {:.4g} of {} values, p = {:.3g} below the level {:.3g}", distance,
             sorted.size(), p, level);
}

void Moments::Add(double value) {
  ++count_;
  const double difference = value - mean_;
  mean_ += difference / double(count_);
  squares_ += difference * (value - mean_);
}

double Moments::standard_error() const {
  return count_ > 0 ? std::sqrt(variance() / double(count_)) : 0;
}

testing::AssertionResult AgreesWith(double estimate, double standard_error, double exact,
                                    double level, double rounding) {
  const double difference = std::max(0.0, std::fabs(estimate - exact) - rounding);
  if (difference == 0) return testing::AssertionSuccess();
  const double p = standard_error > 0 ? NormalPValue(difference / standard_error) : 0;
  if (p >= level) return testing::AssertionSuccess();
  return testing::AssertionFailure() << fmt::format(
             "estimate {:.8g} +- {:.3g} against {:.8g}: p = {:.3g} below the level {:.3g}",
             estimate, standard_error, exact, p, level);
}

testing::AssertionResult AgreesWith(const Moments& a, const Moments& b, double level) {
  return AgreesWith(a.mean(), std::hypot(a.standard_error(), b.standard_error()), b.mean(), level);
}

}  // namespace skywave
