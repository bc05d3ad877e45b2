#include "image/image.h"

#include <algorithm>
#include <cmath>
#include <limits>

#include "image/srgb.h"

namespace skywave {
namespace {

// K. Narkowicz, "ACES Filmic Tone Mapping Curve", 2015: a rational fit with x in scene-linear
// units. It tends to 2.51 / 2.43 > 1, so the caller clips the result.
double FilmicCurve(double x) {
  x = std::min(x, 1e6);  // keeps infinity from becoming inf / inf
  return x * (2.51 * x + 0.03) / (x * (2.43 * x + 0.59) + 0.14);
}

}  // namespace

BadPixels RepairRadiance(Image& image) {
  BadPixels bad;
  // Most pictures are good, which is found without a branch for each number.
  unsigned any = 0;
  for (const float value : image.rgb) {
    any |= unsigned(!(value >= 0)) | unsigned(!(value <= std::numeric_limits<float>::max()));
  }
  if (any == 0) return bad;
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
  std::vector<std::uint8_t> mapped(image.rgb.size());
  for (std::size_t i = 0; i < mapped.size(); ++i) {
    double value = scale * image.rgb[i];
    if (!(value > 0)) continue;  // black; negative values and NaN become black too
    if (mapping.curve == ToneCurve::kFilmic) value = FilmicCurve(value);
    mapped[i] = std::uint8_t(SrgbFromLinear(value) * 255 + 0.5);
  }
  return mapped;
}

}  // namespace skywave
