#include "image/compare.h"

#include <algorithm>
#include <cmath>
#include <cstring>
#include <limits>

#include "base/error.h"
#include "image/srgb.h"

namespace skywave {
namespace {

// Values with equal bits do not differ, not even NaN and infinity.
double Difference(float a, float b) {
  return std::memcmp(&a, &b, sizeof a) == 0 ? 0 : double(a) - double(b);
}

// The ramp goes from dark violet through red to bright yellow; every step is brighter than the
// previous one, so that the map is legible in grey too.
constexpr double kRamp[][3] = {{0.00, 0.00, 0.02}, {0.15, 0.04, 0.36}, {0.42, 0.08, 0.43},
                               {0.70, 0.16, 0.34}, {0.90, 0.34, 0.18}, {0.98, 0.64, 0.10},
                               {0.99, 0.99, 0.65}};

void WriteRampColor(double position, std::uint8_t* rgb) {
  if (std::isnan(position)) position = 1;
  constexpr int kLast = int(std::size(kRamp)) - 1;
  const double scaled = kLast * std::min(position, 1.0);
  const int left = std::min(int(scaled), kLast - 1);
  const double weight = scaled - left;
  for (int c = 0; c < 3; ++c) {
    const double color = kRamp[left][c] + weight * (kRamp[left + 1][c] - kRamp[left][c]);
    rgb[c] = std::uint8_t(color * 255 + 0.5);
  }
}

}  // namespace

void RequireSameSize(const Image& image, const Image& reference) {
  if (image.width == reference.width && image.height == reference.height) return;
  const auto size = [](const Image& i) {
    return std::to_string(i.width) + " x " + std::to_string(i.height);
  };
  throw InputError(InputPosition::File("compare"),
                   "the pictures have different sizes, " + size(image) + " and " + size(reference));
}

ImageDifference Compare(const Image& image, const Image& reference) {
  RequireSameSize(image, reference);
  ImageDifference result;
  double encoded_squares = 0;
  for (int y = 0; y < image.height; ++y) {
    for (int x = 0; x < image.width; ++x) {
      const float* const a = image.Pixel(x, y);
      const float* const b = reference.Pixel(x, y);
      result.mean_a += Luminance(a);
      result.mean_b += Luminance(b);
      double absolute[3];
      for (int c = 0; c < 3; ++c) {
        const double d = Difference(a[c], b[c]);
        absolute[c] = std::abs(d);
        result.mse += d * d;
        result.relative_mse += d == 0 ? 0 : d * d / (double(b[c]) * b[c] + kRelativeFloor);
        const double encoded = SrgbFromLinear(a[c]) - SrgbFromLinear(b[c]);
        encoded_squares += encoded * encoded;
        const double largest =
            std::isnan(d) ? std::numeric_limits<double>::infinity() : absolute[c];
        if (largest > result.max_absolute) {
          result.max_absolute = largest;
          result.max_x = x;
          result.max_y = y;
        }
      }
      const double sum = absolute[0] + absolute[1] + absolute[2];
      const double luminance =
          0.212671 * absolute[0] + 0.715160 * absolute[1] + 0.072169 * absolute[2];
      result.mean_absolute += sum;
      result.squared_channel_sum += sum * sum;
      result.thesis_luminance += luminance * luminance;
      result.different_pixels += std::memcmp(a, b, 3 * sizeof(float)) != 0;
    }
  }
  const double pixels = double(image.width) * image.height;
  result.mean_a /= pixels;
  result.mean_b /= pixels;
  result.mse /= 3 * pixels;
  result.rmse = std::sqrt(result.mse);
  result.relative_mse /= 3 * pixels;
  result.mean_absolute /= 3 * pixels;
  result.psnr = -10 * std::log10(encoded_squares / (3 * pixels));
  result.squared_channel_sum /= pixels;
  result.thesis_luminance /= pixels;
  return result;
}

std::vector<std::uint8_t> FalseColors(std::span<const float> values, double full_scale) {
  std::vector<std::uint8_t> map(values.size() * 3);
  for (std::size_t i = 0; i < values.size(); ++i) {
    WriteRampColor(values[i] / full_scale, &map[3 * i]);
  }
  return map;
}

std::vector<std::uint8_t> ErrorMap(const Image& image, const Image& reference, double full_scale) {
  RequireSameSize(image, reference);
  std::vector<std::uint8_t> map(image.rgb.size());
  for (std::size_t i = 0; i < map.size(); i += 3) {
    double difference = 0, level = 0;
    for (std::size_t c = i; c < i + 3; ++c) {
      difference += std::abs(Difference(image.rgb[c], reference.rgb[c])) / 3;
      level += std::abs(double(reference.rgb[c])) / 3;
    }
    const double error = difference == 0 ? 0 : difference / (level + kRelativeFloor) / full_scale;
    WriteRampColor(error, &map[i]);
  }
  return map;
}

std::vector<std::uint8_t> LogErrorMap(const Image& image, const Image& reference,
                                      double full_scale) {
  constexpr double kDecades = 6;
  RequireSameSize(image, reference);
  std::vector<std::uint8_t> map(image.rgb.size());
  for (std::size_t i = 0; i < map.size(); i += 3) {
    double square = 0;
    for (std::size_t c = i; c < i + 3; ++c) {
      const double difference = Difference(image.rgb[c], reference.rgb[c]);
      square += difference * difference / 3;
    }
    const double decades =
        square == 0 ? -kDecades : std::log10(square) - 2 * std::log10(full_scale);
    WriteRampColor(std::max(1 + decades / kDecades, 0.0), &map[i]);
  }
  return map;
}

}  // namespace skywave
