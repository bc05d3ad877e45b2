// Statistics of few repetitions: means with confidence intervals, medians, and crossings of a curve
// with a level. All intervals are 95 % intervals.
#pragma once

#include <cstddef>
#include <span>
#include <vector>

namespace skywave {

struct Interval {
  double low, high;  // NaN: unknown
};

// Requires at least one value.
double Mean(std::span<const double> values);
// Requires at least one value, none of them negative.
double GeometricMean(std::span<const double> values);
// Divides by n - 1; requires at least two values.
double SampleVariance(std::span<const double> values);
// For an even number of values, returns the mean of the middle two.
double Median(std::vector<double> values);
// Returns the value with a fraction `p` of all values below it, interpolated between neighbours.
// `sorted` is ascending and not empty.
double Quantile(std::span<const double> sorted, double p);

// Returns the 97.5 % quantile of Student's distribution with `degrees` >= 1 degrees of freedom.
double StudentQuantile(int degrees);

// Returns a confidence interval for the mean of positive quantities: Student's interval on a
// logarithmic scale, on which errors and times vary evenly, so that its low end stays positive. It
// is unknown for fewer than two values, and the mean itself if that is 0.
Interval MeanInterval(std::span<const double> values);

// Returns the standard deviation over the mean; 0 for fewer than two values, which show none.
double RelativeDeviation(std::span<const double> values);

// The share of the times of a run that a comparison keeps, the fastest ones: what else a machine
// does only ever adds to a time.
inline constexpr double kKeptTimes = 0.75;
// Returns the number of `count` values that are kept; at least three where there are as many.
std::size_t KeptOf(std::size_t count, double share);
// Returns the fastest of `times` that are kept, in ascending order.
std::vector<double> FastestOf(std::vector<double> times);

// A ratio of positive quantities, with its interval.
struct Ratio {
  double value;
  Interval interval;
};
// Returns the geometric mean over i of the ratios of the geometric means of b[i] to those of a[i],
// with the interval of Welch's test on logarithms (Welch 1947): groups need not have equal numbers
// of values or equal variances. It is unknown if a group has fewer than two values. `a` and `b`
// have equally many groups, at least one, none of them empty. Of each group the least values are
// kept, by their share: the means are those of these values, and their errors come from the
// variance of all, with those above raised no further than to the last one that is kept (Yuen
// 1974).
Ratio WelchRatio(std::span<const std::vector<double>> a, std::span<const std::vector<double>> b,
                 double kept = 1);
// Returns the geometric mean of ratios that were measured in pairs, with Student's interval on
// logarithms; unknown for fewer than two.
Ratio PairedRatio(std::span<const double> ratios);

struct CurvePoint {
  double x, y;  // both positive on curves whose scales are logarithmic
};

// The slope of the straight line of least squares through points.
struct Slope {
  double value;
  Interval interval;  // Student's; unknown for fewer than three points
};
// Requires two points of different x.
Slope FitSlope(std::span<const CurvePoint> points);

// The point after which a falling curve stays below a level.
struct Crossing {
  // The crossing lies within the curve, before its first point, or beyond its last one.
  enum Kind { kInside, kBefore, kBeyond };
  Kind kind;
  double x;  // the crossing; for kBefore and kBeyond the first and the last x, as a bound
};

// Expects at least one point, in order of effort; points are connected by straight lines on
// logarithmic scales.
Crossing FindCrossing(std::span<const CurvePoint> curve, double level);

}  // namespace skywave
