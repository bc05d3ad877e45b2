#include "image/image.h"

#include <tbb/parallel_for.h>

#include <algorithm>
#include <array>
#include <atomic>
#include <cmath>
#include <limits>

#include "image/srgb.h"

namespace skywave {
namespace {

// K. Narkowicz, "ACES Filmic Tone Mapping Curve", 2015: a rational fit with x in scene-linear
// units. It tends to 2.51 / 2.43 > 1, so the caller clips the result.
double FilmicCurve(double x) { return x * (2.51 * x + 0.03) / (x * (2.43 * x + 0.59) + 0.14); }

using Rgb = std::array<double, 3>;

Rgb Times(const double (&matrix)[3][3], const Rgb& v) {
  Rgb result;
  for (int row = 0; row < 3; ++row) {
    result[row] = matrix[row][0] * v[0] + matrix[row][1] * v[1] + matrix[row][2] * v[2];
  }
  return result;
}

// S. Hill's fit to the reference rendering and output device transforms of ACES (BakingLab, 2016):
// a matrix to the primaries of its rendering space with some loss of saturation, a rational curve,
// and a matrix back.
Rgb AcesCurve(const Rgb& linear) {
  constexpr double kIn[3][3] = {
      {0.59719, 0.35458, 0.04823}, {0.07600, 0.90834, 0.01566}, {0.02840, 0.13383, 0.83777}};
  constexpr double kOut[3][3] = {
      {1.60475, -0.53108, -0.07367}, {-0.10208, 1.10813, -0.00605}, {-0.00327, -0.07276, 1.07602}};
  Rgb v = Times(kIn, linear);
  for (double& x : v) {
    x = (x * (x + 0.0245786) - 0.000090537) / (x * (0.983729 * x + 0.4329510) + 0.238081);
  }
  return Times(kOut, v);
}

Rgb ReinhardCurve(const Rgb& linear) {
  constexpr double kWhite = 4;
  const double luminance = 0.2126 * linear[0] + 0.7152 * linear[1] + 0.0722 * linear[2];
  const double scale = (1 + luminance / (kWhite * kWhite)) / (1 + luminance);
  return {scale * linear[0], scale * linear[1], scale * linear[2]};
}

Rgb OnCurve(ToneCurve curve, Rgb v) {
  switch (curve) {
    case ToneCurve::kClip:
      break;
    case ToneCurve::kFilmic:
      return {FilmicCurve(v[0]), FilmicCurve(v[1]), FilmicCurve(v[2])};
    case ToneCurve::kAces:
      return AcesCurve(v);
    case ToneCurve::kReinhard:
      return ReinhardCurve(v);
  }
  return v;
}

}  // namespace

BadPixels RepairRadiance(Image& image) {
  BadPixels bad;
  // Most pictures are good, which is found without a branch for each number.
  std::atomic<bool> any = false;
  constexpr std::size_t kAtOnce = std::size_t{1} << 18;
  tbb::parallel_for(std::size_t{0}, (image.rgb.size() + kAtOnce - 1) / kAtOnce, [&](std::size_t i) {
    unsigned here = 0;
    const std::size_t end = std::min((i + 1) * kAtOnce, image.rgb.size());
    for (std::size_t k = i * kAtOnce; k < end; ++k) {
      const float value = image.rgb[k];
      here |= unsigned(!(value >= 0)) | unsigned(!(value <= std::numeric_limits<float>::max()));
    }
    if (here != 0) any = true;
  });
  if (!any) return bad;
  for (std::size_t i = 0; i < image.rgb.size(); i += 3) {
    bool nan = false, infinite = false, negative = false;
    for (std::size_t c = i; c < i + 3; ++c) {
      float& value = image.rgb[c];
      if (std::isfinite(value) && value >= 0) continue;
      nan |= std::isnan(value);
      infinite |= std::isinf(value);
      negative |= value < 0;
      value = 0;
    }
    if (nan) {
      ++bad.nan;
    } else if (infinite) {
      ++bad.infinite;
    } else if (negative) {
      ++bad.negative;
    }
  }
  return bad;
}

float ExposureValue100(const PhotographicExposure& camera) {
  const double n = camera.f_number;
  return float(std::log2(n * n / camera.shutter_seconds * 100 / camera.iso));
}

float ExposureStops(const PhotographicExposure& camera) {
  constexpr double kSaturation = 78, kLens = 0.65, kSpeed = 100;
  return float(-std::log2(kSaturation / (kLens * kSpeed)) - ExposureValue100(camera));
}

std::vector<std::uint8_t> ToneMap(const Image& image, const ToneMapping& mapping) {
  const double scale = std::exp2(double(mapping.exposure_stops));
  constexpr double kWhite = 1e6;  // keeps infinity from becoming inf / inf
  std::vector<std::uint8_t> mapped(image.rgb.size());
  tbb::parallel_for(0, image.height, [&](int y) {
    const std::size_t row = std::size_t(image.width) * 3;
    for (std::size_t i = y * row; i < (y + 1) * row; i += 3) {
      Rgb v;
      for (int c = 0; c < 3; ++c) {
        const double value = scale * image.rgb[i + c];
        v[c] = value > 0 ? std::min(value, kWhite) : 0;  // negative values and NaN become black
      }
      v = OnCurve(mapping.curve, v);
      for (int c = 0; c < 3; ++c) mapped[i + c] = std::uint8_t(SrgbFromLinear(v[c]) * 255 + 0.5);
    }
  });
  return mapped;
}

float AutomaticExposureStops(const Image& image) {
  constexpr double kGrey = 0.18, kSteps = 16, kMost = 100;
  std::vector<float> luminances;
  luminances.reserve(image.rgb.size() / 3);
  for (std::size_t i = 0; i < image.rgb.size(); i += 3) {
    const float luminance = Luminance(&image.rgb[i]);
    if (luminance > 0 && std::isfinite(luminance)) luminances.push_back(luminance);
  }
  if (luminances.empty()) return 0;
  const auto median = luminances.begin() + std::ptrdiff_t(luminances.size() / 2);
  std::nth_element(luminances.begin(), median, luminances.end());
  const double stops = std::round(kSteps * std::log2(kGrey / *median)) / kSteps;
  return float(std::clamp(stops, -kMost, kMost));
}

}  // namespace skywave
