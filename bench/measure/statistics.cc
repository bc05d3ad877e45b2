#include "bench/measure/statistics.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <numeric>

namespace skywave {
namespace {

constexpr Interval kUnknownInterval = {std::numeric_limits<double>::quiet_NaN(),
                                       std::numeric_limits<double>::quiet_NaN()};

std::vector<double> Logarithms(std::span<const double> values) {
  std::vector<double> logs;
  for (const double value : values) logs.push_back(std::log(value));
  return logs;
}

Interval RatioInterval(double log_ratio, double reach) {
  return {std::exp(log_ratio - reach), std::exp(log_ratio + reach)};
}

}  // namespace

double Mean(std::span<const double> values) {
  return std::accumulate(values.begin(), values.end(), 0.0) / double(values.size());
}

double GeometricMean(std::span<const double> values) { return std::exp(Mean(Logarithms(values))); }

double SampleVariance(std::span<const double> values) {
  const double mean = Mean(values);
  double squares = 0;
  for (double value : values) squares += (value - mean) * (value - mean);
  return squares / double(values.size() - 1);
}

double Median(std::vector<double> values) {
  std::sort(values.begin(), values.end());
  const std::size_t half = values.size() / 2;
  return values.size() % 2 == 1 ? values[half] : 0.5 * (values[half - 1] + values[half]);
}

double Quantile(std::span<const double> sorted, double p) {
  const double at = p * double(sorted.size() - 1);
  const auto left = std::size_t(at);
  if (left + 1 >= sorted.size() || at == double(left)) return sorted[left];
  return sorted[left] + (at - double(left)) * (sorted[left + 1] - sorted[left]);
}

double StudentQuantile(int degrees) {
  constexpr double kTable[] = {12.7062, 4.3027, 3.1824, 2.7764, 2.5706, 2.4469, 2.3646, 2.3060,
                               2.2622,  2.2281, 2.2010, 2.1788, 2.1604, 2.1448, 2.1314, 2.1199,
                               2.1098,  2.1009, 2.0930, 2.0860, 2.0796, 2.0739, 2.0687, 2.0639,
                               2.0595,  2.0555, 2.0518, 2.0484, 2.0452, 2.0423};
  if (degrees <= int(std::size(kTable))) return kTable[degrees - 1];
  // These are the first terms of the expansion about the normal quantile (Abramowitz and Stegun
  // 26.7.5).
  constexpr double z = 1.959964;
  const double n = degrees;
  return z + (z * z * z + z) / (4 * n) +
         (5 * std::pow(z, 5) + 16 * z * z * z + 3 * z) / (96 * n * n);
}

Interval MeanInterval(std::span<const double> values) {
  if (values.size() < 2) return kUnknownInterval;
  const double mean = Mean(values);
  if (mean == 0) return {0, 0};
  // This is the standard error of log(mean) to first order.
  const double relative = std::sqrt(SampleVariance(values) / double(values.size())) / mean;
  const double reach = StudentQuantile(int(values.size()) - 1) * relative;
  return {mean * std::exp(-reach), mean * std::exp(reach)};
}

double RelativeDeviation(std::span<const double> values) {
  return values.size() < 2 ? 0 : std::sqrt(SampleVariance(values)) / Mean(values);
}

std::size_t KeptOf(std::size_t count, double share) {
  const auto kept = std::size_t(std::ceil(share * double(count)));
  return std::min(count, std::max<std::size_t>(kept, 3));
}

std::vector<double> FastestOf(std::vector<double> times) {
  std::sort(times.begin(), times.end());
  times.resize(KeptOf(times.size(), kKeptTimes));
  return times;
}

Ratio WelchRatio(std::span<const std::vector<double>> a, std::span<const std::vector<double>> b,
                 double kept) {
  double log_ratio = 0, variance = 0, squares = 0;
  bool known = true;
  const double weight = 1 / double(a.size());
  const auto add = [&](const std::vector<double>& values, double sign) {
    std::vector<double> logs = Logarithms(values);
    std::sort(logs.begin(), logs.end());
    const std::size_t count = KeptOf(logs.size(), kept);
    log_ratio += sign * weight * Mean(std::span(logs).first(count));
    known &= count > 1;
    if (!known) return;
    std::fill(logs.begin() + std::ptrdiff_t(count), logs.end(), logs[count - 1]);
    const double degrees = double(count - 1);
    const double part = weight * weight * SampleVariance(logs) * double(logs.size() - 1) /
                        (double(count) * degrees);
    variance += part;
    squares += part * part / degrees;
  };
  for (const std::vector<double>& values : a) add(values, -1);
  for (const std::vector<double>& values : b) add(values, 1);
  if (!known) return {std::exp(log_ratio), kUnknownInterval};
  if (!(squares > 0)) return {std::exp(log_ratio), RatioInterval(log_ratio, 0)};
  // Degrees of freedom are rounded down, which makes the interval wider.
  const double degrees = std::clamp(variance * variance / squares, 1.0, 1e6);
  return {std::exp(log_ratio),
          RatioInterval(log_ratio, StudentQuantile(int(degrees)) * std::sqrt(variance))};
}

Ratio PairedRatio(std::span<const double> ratios) {
  const std::vector<double> logs = Logarithms(ratios);
  const double log_ratio = Mean(logs);
  if (logs.size() < 2) return {std::exp(log_ratio), kUnknownInterval};
  const double error = std::sqrt(SampleVariance(logs) / double(logs.size()));
  return {std::exp(log_ratio),
          RatioInterval(log_ratio, StudentQuantile(int(logs.size()) - 1) * error)};
}

Slope FitSlope(std::span<const CurvePoint> points) {
  const auto count = double(points.size());
  double x = 0, y = 0, xx = 0, xy = 0, residuals = 0;
  for (const CurvePoint& point : points) x += point.x / count, y += point.y / count;
  for (const CurvePoint& point : points) {
    xx += (point.x - x) * (point.x - x);
    xy += (point.x - x) * (point.y - y);
  }
  const double slope = xy / xx;
  if (points.size() < 3) return {slope, kUnknownInterval};
  for (const CurvePoint& point : points) {
    const double residual = point.y - y - slope * (point.x - x);
    residuals += residual * residual;
  }
  const double reach =
      StudentQuantile(int(points.size()) - 2) * std::sqrt(residuals / (count - 2) / xx);
  return {slope, {slope - reach, slope + reach}};
}

Crossing FindCrossing(std::span<const CurvePoint> curve, double level) {
  // The search starts at the end because noise may lift a curve above the level again, and only a
  // final descent counts.
  std::size_t first = curve.size();
  while (first > 0 && curve[first - 1].y <= level) --first;
  if (first == curve.size()) return {Crossing::kBeyond, curve.back().x};
  if (first == 0) return {Crossing::kBefore, curve.front().x};
  const CurvePoint a = curve[first - 1], b = curve[first];
  // A curve that reaches 0 cannot be interpolated on a logarithmic scale.
  if (!(b.y > 0)) return {Crossing::kInside, b.x};
  const double along = std::log(level / a.y) / std::log(b.y / a.y);
  return {Crossing::kInside, a.x * std::pow(b.x / a.x, along)};
}

}  // namespace skywave
