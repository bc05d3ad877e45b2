#include "bench/measure/error_split.h"

#include <cassert>
#include <cmath>

namespace skywave {
namespace {

// Returns the factor of a squared difference; see ImageDifference.
double Weight(ErrorMeasure measure, float reference) {
  if (measure == ErrorMeasure::kMse) return 1;
  return 1 / (double(reference) * reference + kRelativeFloor);
}

double MeanWeightedSquare(const Image& difference, const Image& reference, ErrorMeasure measure) {
  double sum = 0;
  for (std::size_t i = 0; i < difference.rgb.size(); ++i) {
    const double d = difference.rgb[i];
    sum += Weight(measure, reference.rgb[i]) * d * d;
  }
  return sum / double(difference.rgb.size());
}

}  // namespace

double Value(const ImageDifference& difference, ErrorMeasure measure) {
  return measure == ErrorMeasure::kMse ? difference.mse : difference.relative_mse;
}

Reference MakeReference(const Image& first_half, const Image& second_half) {
  assert(first_half.rgb.size() == second_half.rgb.size());
  Reference reference;
  reference.image = Image(first_half.width, first_half.height);
  reference.half_difference = reference.image;
  for (std::size_t i = 0; i < reference.image.rgb.size(); ++i) {
    const double a = first_half.rgb[i], b = second_half.rgb[i];
    reference.image.rgb[i] = float(0.5 * (a + b));
    reference.half_difference.rgb[i] = float(0.5 * (a - b));
  }
  reference.mse =
      MeanWeightedSquare(reference.half_difference, reference.image, ErrorMeasure::kMse);
  reference.relative_mse =
      MeanWeightedSquare(reference.half_difference, reference.image, ErrorMeasure::kRelativeMse);
  return reference;
}

PictureMoments::PictureMoments(int width, int height)
    : mean_(std::size_t(width) * height * 3), squares_(mean_.size()) {}

void PictureMoments::Add(const Image& picture) {
  assert(picture.rgb.size() == mean_.size());
  ++count_;
  for (std::size_t i = 0; i < mean_.size(); ++i) {
    const double value = picture.rgb[i], before = value - mean_[i];
    mean_[i] += before / count_;
    squares_[i] += before * (value - mean_[i]);
  }
}

ErrorSplit SplitError(const PictureMoments& pictures, const Reference& reference,
                      ErrorMeasure measure) {
  assert(pictures.count() >= 2);
  const Image& exact = reference.image;
  const bool halves = !reference.half_difference.rgb.empty();
  const std::size_t pixels = exact.rgb.size() / 3;
  ErrorSplit split;
  double squares = 0;
  for (std::size_t pixel = 0; pixel < pixels; ++pixel) {
    // This is the mean of (x_i - a) (x_j - b) over all pairs of different pictures x and the halves
    // a and b. Its expectation is the squared bias because no picture is multiplied by itself. The
    // channels of a pixel share random numbers while pixels do not, so the spread is taken over
    // pixels.
    double bias = 0;
    for (std::size_t i = 3 * pixel; i < 3 * pixel + 3; ++i) {
      const double weight = Weight(measure, exact.rgb[i]) / 3;
      const double off = pictures.mean(i) - exact.rgb[i];
      const double own = halves ? reference.half_difference.rgb[i] : 0.0;
      bias += weight * (off * off - pictures.variance(i) / pictures.count() - own * own);
      split.variance += weight * pictures.variance(i);
    }
    if (!halves) bias -= reference.noise(measure).value_or(0);
    const double before = bias - split.squared_bias;
    split.squared_bias += before / double(pixel + 1);
    squares += before * (bias - split.squared_bias);
  }
  split.variance /= double(pixels);
  if (pixels > 1) {
    split.squared_bias_error = std::sqrt(squares / double(pixels - 1) / double(pixels));
  }
  return split;
}

}  // namespace skywave
