#include "bench/measure/picture_noise.h"

#include <algorithm>
#include <cmath>
#include <limits>

#include "bench/measure/statistics.h"
#include "image/compare.h"

namespace skywave {
namespace {

// The variance of a mean, and how many degrees of freedom its estimate has.
struct MeanVariance {
  double variance = 0, degrees = 1;
};

MeanVariance VarianceOfValue(const std::optional<PictureNoise>& noise, std::size_t value) {
  if (!noise) return {};
  const double samples = noise->samples[value / 3];
  if (!(samples > 1)) return {};
  return {noise->variance[value] / samples, samples - 1};
}

// Returns the 97.5 % quantile of Student's distribution.
class StudentTable {
 public:
  StudentTable() {
    for (int degrees = 1; degrees < int(std::size(quantiles_)); ++degrees) {
      quantiles_[degrees] = StudentQuantile(degrees);
    }
  }
  double At(double degrees) const {
    return quantiles_[int(std::clamp(degrees, 1.0, double(std::size(quantiles_) - 1)))];
  }

 private:
  double quantiles_[1001] = {};
};

}  // namespace

std::vector<std::string> NoiseChannels() {
  return {"variance.R", "variance.G", "variance.B", "samples.V"};
}

PictureNoise NoiseOf(std::span<const NamedChannel> layers) {
  PictureNoise noise = {{}, layers[3].values};
  noise.variance.resize(noise.samples.size() * 3);
  for (std::size_t i = 0; i < noise.variance.size(); ++i) {
    noise.variance[i] = layers[i % 3].values[i / 3];
  }
  return noise;
}

std::vector<std::string> ErrorChannels() { return {"error.R", "error.G", "error.B"}; }

PictureNoise NoiseOfErrors(std::span<const NamedChannel> layers) {
  // The quantiles of so many degrees of freedom are those of the normal distribution.
  constexpr float kMany = 1e6f;
  const std::size_t pixels = layers[0].values.size();
  PictureNoise noise = {std::vector<float>(3 * pixels), std::vector<float>(pixels, kMany)};
  for (std::size_t i = 0; i < noise.variance.size(); ++i) {
    const float error = layers[i % 3].values[i / 3];
    noise.variance[i] = error * error * kMany;
  }
  return noise;
}

NoiseComparison CompareNoise(const Image& image, const std::optional<PictureNoise>& image_noise,
                             const Image& reference,
                             const std::optional<PictureNoise>& reference_noise) {
  RequireSameSize(image, reference);
  static const StudentTable quantiles;
  NoiseComparison result;
  std::array<double, 3> variances = {};
  std::size_t exceeding = 0;
  double squared_z = 0;
  for (std::size_t i = 0; i < image.rgb.size(); ++i) {
    const double difference = double(image.rgb[i]) - reference.rgb[i];
    const MeanVariance a = VarianceOfValue(image_noise, i), b = VarianceOfValue(reference_noise, i);
    const double variance = a.variance + b.variance;
    result.mean_difference[i % 3] += difference;
    variances[i % 3] += variance;
    if (!(variance > 0)) {
      ++result.exact_values;
      result.exact_that_differ += difference != 0;
      continue;
    }
    ++result.values;
    // Welch 1947: the degrees of freedom of a sum of two estimated variances.
    const double degrees =
        variance * variance /
        (a.variance * a.variance / a.degrees + b.variance * b.variance / b.degrees);
    const double z2 = difference * difference / variance;
    const double quantile = quantiles.At(degrees);
    exceeding += !(z2 <= quantile * quantile);
    squared_z += z2;
  }
  constexpr double kNormalQuantile = 1.959964;
  const double pixels = double(image.rgb.size() / 3);
  for (int c = 0; c < 3; ++c) {
    result.mean_difference[c] /= pixels;
    result.half_width[c] = kNormalQuantile * std::sqrt(variances[c]) / pixels;
  }
  if (result.values == 0) return result;
  result.exceeding = double(exceeding) / double(result.values);
  result.mean_squared_z = squared_z / double(result.values);
  return result;
}

}  // namespace skywave
