// Splits an error into noise and bias by repeated renders with independent seeds.
#pragma once

#include <optional>
#include <vector>

#include "base/names.h"
#include "image/compare.h"
#include "image/image.h"

namespace skywave {

// The measure used for curves, targets and bias. See ImageDifference.
enum class ErrorMeasure { kMse, kRelativeMse };
template <>
inline constexpr auto kEnumNames<ErrorMeasure> = std::to_array<Named<ErrorMeasure>>(
    {{ErrorMeasure::kMse, "mse"}, {ErrorMeasure::kRelativeMse, "relative_mse"}});
double Value(const ImageDifference& difference, ErrorMeasure measure);

// The picture against which errors are measured.
struct Reference {
  Image image;
  // Half the difference of the two independent halves whose mean is `image`; empty if only the mean
  // is known. Its square is, on average, the variance of `image`.
  Image half_difference;
  // The error of `image` itself against the exact picture; nothing if unknown.
  std::optional<double> mse, relative_mse;

  std::optional<double> noise(ErrorMeasure measure) const {
    return measure == ErrorMeasure::kMse ? mse : relative_mse;
  }
};

// Makes a reference of two independent, equally noisy pictures with the same size and expectation.
Reference MakeReference(const Image& first_half, const Image& second_half);

// Mean and variance of every channel of every pixel over the added pictures (Welford).
class PictureMoments {
 public:
  PictureMoments(int width, int height);
  void Add(const Image& picture);

  int count() const { return count_; }
  double mean(std::size_t channel) const { return mean_[channel]; }
  // Returns the variance of one picture, not of the mean. Requires two pictures.
  double variance(std::size_t channel) const { return squares_[channel] / (count_ - 1); }

 private:
  int count_ = 0;
  std::vector<double> mean_, squares_;
};

// The expected error of one render is squared_bias + variance.
struct ErrorSplit {
  // Unbiased estimate, so it may be negative if there is no bias: the error of the mean of all
  // pictures, minus the remaining variance of that mean, minus the noise of the reference.
  double squared_bias = 0;
  double squared_bias_error = 0;  // its standard error, from the spread over pixels
  double variance = 0;

  // True beyond three standard errors; chance alone exceeds them about once in 700 times.
  bool biased() const { return squared_bias > 3 * squared_bias_error; }
};

// Requires at least two pictures, independent of each other and of the reference. Unknown noise of
// the reference counts as bias.
ErrorSplit SplitError(const PictureMoments& pictures, const Reference& reference,
                      ErrorMeasure measure);

}  // namespace skywave
