#include "image/image.h"

#include <fmt/format.h>
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

// T. Sobotka's AgX as Blender has it, with B. Wrensch's polynomial for its curve (2023): in the
// primaries of Rec. 2020, a matrix that lets each channel see the others, a sigmoid of the stops
// from -12.47 to 4.03, the matrix back, and the power 2.2 that makes it linear.
Rgb AgxCurve(const Rgb& linear) {
  constexpr double kToRec2020[3][3] = {
      {0.6274, 0.3293, 0.0433}, {0.0691, 0.9195, 0.0113}, {0.0164, 0.0880, 0.8956}};
  constexpr double kFromRec2020[3][3] = {
      {1.6605, -0.5876, -0.0728}, {-0.1246, 1.1329, -0.0083}, {-0.0182, -0.1006, 1.1187}};
  constexpr double kInset[3][3] = {{0.856627153315983, 0.0951212405381588, 0.0482516061458583},
                                   {0.137318972929847, 0.761241990602591, 0.101439036467562},
                                   {0.11189821299995, 0.0767994186031903, 0.811302368396859}};
  constexpr double kOutset[3][3] = {
      {1.1271005818144368, -0.11060664309660323, -0.01649393871783457},
      {-0.1413297634984383, 1.157823702216272, -0.01649393871783426},
      {-0.14132976349843826, -0.11060664309660294, 1.25193640659504}};
  constexpr double kLeastStops = -12.47393, kMostStops = 4.026069;
  Rgb v = Times(kInset, Times(kToRec2020, linear));
  for (double& x : v) {
    const double stops = std::log2(std::max(x, 1e-10));
    x = std::clamp((stops - kLeastStops) / (kMostStops - kLeastStops), 0.0, 1.0);
    x = -0.00232 +
        x * (0.1191 + x * (0.4298 + x * (-6.868 + x * (31.96 + x * (-40.14 + x * 15.5)))));
  }
  v = Times(kOutset, v);
  for (double& x : v) x = std::pow(std::max(x, 0.0), 2.2);
  return Times(kFromRec2020, v);
}

// Khronos PBR Neutral (2024): what is lit as bright as white paper keeps its colour; the reflection
// of a Fresnel term of .04 is taken off, and above .76 the brightest channel runs towards 1 while
// the others follow it to white.
Rgb NeutralCurve(const Rgb& linear) {
  constexpr double kFresnel = 0.04, kPaper = 0.8 - kFresnel, kDesaturation = 0.15;
  const auto [least, most] = std::minmax({linear[0], linear[1], linear[2]});
  const double offset = least < 2 * kFresnel ? least - least * least / (4 * kFresnel) : kFresnel;
  const double peak = most - offset;
  Rgb v = {linear[0] - offset, linear[1] - offset, linear[2] - offset};
  if (peak < kPaper) return v;
  const double room = 1 - kPaper;
  const double shown = 1 - room * room / (peak + room - kPaper);
  const double white = 1 - 1 / (kDesaturation * (peak - shown) + 1);
  for (double& x : v) x = (1 - white) * x * shown / peak + white * shown;
  return v;
}

// The response of photoreceptors, v^n / (v^n + g^n) (Naka and Rushton 1966), with g = 0.18, the
// grey that an exposure is made for, and an n of 2, twice what is measured of eyes. Grey stays
// grey.
double ContrastCurve(double v) {
  constexpr double kGrey = 0.18, kHalf = kGrey * kGrey * (1 / kGrey - 1);
  const double inverse = 1 / std::max(v, 1e-30);
  return 1 / (1 + kHalf * inverse * inverse);
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
    case ToneCurve::kAgx:
      return AgxCurve(v);
    case ToneCurve::kNeutral:
      return NeutralCurve(v);
    case ToneCurve::kContrast:
      return {ContrastCurve(v[0]), ContrastCurve(v[1]), ContrastCurve(v[2])};
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
  constexpr float kLargestHalf = 65504;
  float largest = kLargestHalf;
  for (const float value : image.rgb) {
    if (std::isfinite(value)) largest = std::max(largest, value);
  }
  for (std::size_t i = 0; i < image.rgb.size(); i += 3) {
    bool nan = false, infinite = false, negative = false;
    for (std::size_t c = i; c < i + 3; ++c) {
      float& value = image.rgb[c];
      if (std::isfinite(value) && value >= 0) continue;
      nan |= std::isnan(value);
      infinite |= std::isinf(value);
      negative |= value < 0;
      value = std::isinf(value) && value > 0 ? largest : 0;
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

std::string Describe(const BadPixels& bad) {
  return fmt::format(
      "{} NaN, {} infinite and {} negative pixels: infinite ones become the largest value, others "
      "0",
      bad.nan, bad.infinite, bad.negative);
}

float ExposureValue100(const PhotographicExposure& camera) {
  const double n = camera.f_number;
  return float(std::log2(n * n / camera.shutter_seconds * 100 / camera.iso));
}

float ExposureStops(const PhotographicExposure& camera) {
  constexpr double kSaturation = 78, kLens = 0.65, kSpeed = 100;
  return float(-std::log2(kSaturation / (kLens * kSpeed)) - ExposureValue100(camera));
}

std::vector<NamedChannel> AsLayer(std::string_view name, const Image& image) {
  std::vector<NamedChannel> channels;
  for (std::size_t c = 0; c < 3 && !image.rgb.empty(); ++c) {
    NamedChannel& channel =
        channels.emplace_back(NamedChannel{fmt::format("{}.{}", name, "RGB"[c]), {}});
    channel.values.reserve(image.rgb.size() / 3);
    for (std::size_t i = c; i < image.rgb.size(); i += 3) channel.values.push_back(image.rgb[i]);
  }
  return channels;
}

std::vector<std::uint8_t> ToBytes(std::span<const float> shares) {
  std::vector<std::uint8_t> bytes;
  bytes.reserve(shares.size());
  for (const float share : shares) {
    bytes.push_back(std::uint8_t(share > 0 ? std::min(share, 1.0f) * 255 + 0.5f : 0.0f));
  }
  return bytes;
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

namespace {

// Returns the luminance below which a share of `luminances` lies; puts them in another order.
double QuantileOf(std::vector<float>& luminances, double share) {
  const auto at = luminances.begin() + std::ptrdiff_t(double(luminances.size()) * share);
  std::nth_element(luminances.begin(), at, luminances.end());
  return *at;
}

}  // namespace

float AutomaticExposureStops(const Image& image, std::span<const float> coverage) {
  constexpr double kGrey = 0.18, kSteps = 16, kMost = 100;
  constexpr double kBright = 0.95, kLight = 0.9, kMostDarker = 2;
  std::vector<float> all, covered;
  all.reserve(image.rgb.size() / 3);
  for (std::size_t pixel = 0; pixel < image.rgb.size() / 3; ++pixel) {
    const float luminance = Luminance(&image.rgb[3 * pixel]);
    if (!(luminance > 0) || !std::isfinite(luminance)) continue;
    all.push_back(luminance);
    if (!coverage.empty() && coverage[pixel] >= 0.5f) covered.push_back(luminance);
  }
  if (all.empty()) return 0;
  const double metered = QuantileOf(covered.empty() ? all : covered, 0.5);
  double stops = std::log2(kGrey / metered);
  const double fits = std::log2(kLight / QuantileOf(all, kBright));
  stops = std::clamp(fits, stops - kMostDarker, stops);
  return float(std::clamp(std::round(kSteps * stops) / kSteps, -kMost, kMost));
}

}  // namespace skywave
