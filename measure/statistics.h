// Figures of few repetitions: means with confidence intervals, medians, and where a curve meets a
// level. All intervals are of 95 %.
#pragma once

#include <span>
#include <vector>

namespace skywave {

struct Interval {
  double low, high;  // NaN: unknown
};

// Of at least one value.
double Mean(std::span<const double> values);
// With n - 1 in the denominator; of at least two values.
double SampleVariance(std::span<const double> values);
// Of an even number of values the mean of the middle two.
double Median(std::vector<double> values);
// The value below which a share of `p` lies, interpolated between neighbours; sorted, not empty.
double Quantile(std::span<const double> sorted, double p);

// The t below which 97.5 % of Student's distribution of `degrees` >= 1 degrees of freedom lie.
double StudentQuantile(int degrees);

// Where the mean of positive quantities lies: Student's interval of their mean, laid out on a
// logarithmic scale, where errors and times vary evenly, so its low end stays positive. Unknown for
// fewer than two values; the mean itself where it is 0.
Interval MeanInterval(std::span<const double> values);

struct CurvePoint {
  double x, y;  // positive
};

// Where a falling curve comes down to a level to stay.
struct Crossing {
  // Along the curve; already before its first point; not up to its last point.
  enum Kind { kInside, kBefore, kBeyond };
  Kind kind;
  double x;  // the place; for kBefore and kBeyond the first and the last x: a bound
};

// Points in the order of effort, at least one, straight lines between them on logarithmic scales.
Crossing FindCrossing(std::span<const CurvePoint> curve, double level);

}  // namespace skywave
