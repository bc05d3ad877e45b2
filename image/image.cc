#include "image/image.h"

#include <algorithm>
#include <cctype>
#include <cmath>

#include "base/error.h"
#include "base/files.h"
#include "image/formats.h"
#include "image/srgb.h"

namespace skywave {
namespace {

bool StartsWith(std::string_view bytes, std::string_view magic) {
  return bytes.substr(0, magic.size()) == magic;
}

std::string LowerCaseEnding(const std::string& path) {
  const std::size_t dot = path.find_last_of("./");
  if (dot == std::string::npos || path[dot] != '.') return "";
  std::string ending = path.substr(dot);
  std::transform(ending.begin(), ending.end(), ending.begin(),
                 [](unsigned char c) { return char(std::tolower(c)); });
  return ending;
}

// K. Narkowicz, "ACES Filmic Tone Mapping Curve", 2015: a rational fit with x in scene-linear
// units. It tends to 2.51 / 2.43 > 1, so the caller clips the result.
double FilmicCurve(double x) {
  x = std::min(x, 1e6);  // keeps infinity from becoming inf / inf
  return x * (2.51 * x + 0.03) / (x * (2.43 * x + 0.59) + 0.14);
}

}  // namespace

std::int64_t ParseSize(std::string_view text) {
  if (text.empty() || text.size() > 9) return -1;
  std::int64_t value = 0;
  for (const char c : text) {
    if (c < '0' || c > '9') return -1;
    value = value * 10 + (c - '0');
  }
  return value;
}

void CheckSize(const InputPosition& position, std::int64_t width, std::int64_t height,
               const ReadLimits& limits) {
  const std::string size = std::to_string(width) + " x " + std::to_string(height);
  if (width < 1 || height < 1) throw InputError(position, "a size of " + size + " is no picture");
  if (width > limits.max_width || height > limits.max_height ||
      std::uint64_t(width) > limits.max_pixels / std::uint64_t(height)) {
    throw InputError(position, "a size of " + size + " is over the limit of " +
                                   std::to_string(limits.max_width) + " x " +
                                   std::to_string(limits.max_height) + " and " +
                                   std::to_string(limits.max_pixels) + " pixels");
  }
}

namespace {

Image DecodeImage(const std::string& path, std::string_view bytes, const ReadLimits& limits) {
  if (StartsWith(bytes, "\x76\x2f\x31\x01")) return DecodeExr(path, bytes, limits);
  if (StartsWith(bytes, "#?")) return DecodeRgbe(path, bytes, limits);
  if (StartsWith(bytes, "PF") || StartsWith(bytes, "Pf")) return DecodePfm(path, bytes, limits);
  throw InputError(InputPosition::Byte(path, 0),
                   bytes.empty() ? "is empty" : "is neither OpenEXR, Radiance RGBE nor PFM");
}

}  // namespace

Image ReadImage(const std::string& path, const ReadLimits& limits) {
  return DecodeImage(path, ReadFile(path), limits);
}

Image DecodeTexture(const std::string& name, std::string_view bytes, Encoding encoding,
                    const ReadLimits& limits) {
  if (StartsWith(bytes, "\x89PNG")) return DecodePng(name, bytes, encoding, limits);
  if (encoding == Encoding::kAlpha) {
    Image opaque(1, 1);
    opaque.rgb = {1, 1, 1};
    return opaque;
  }
  if (StartsWith(bytes, "\xff\xd8")) return DecodeJpeg(name, bytes, encoding, limits);
  return DecodeImage(name, bytes, limits);
}

Image ReadTexture(const std::string& path, Encoding encoding, const ReadLimits& limits) {
  return DecodeTexture(path, ReadFile(path), encoding, limits);
}

Image FromBytes(int width, int height, const std::uint8_t* bytes, Encoding encoding) {
  float table[256];
  for (int i = 0; i < 256; ++i) {
    table[i] = float(encoding == Encoding::kSrgb ? LinearFromSrgb(i / 255.0) : i / 255.0);
  }
  Image image(width, height);
  for (std::size_t i = 0; i < image.rgb.size(); ++i) image.rgb[i] = table[bytes[i]];
  return image;
}

void WriteImage(const std::string& path, const Image& image, const Metadata& metadata) {
  const std::string ending = LowerCaseEnding(path);
  if (ending == ".exr") return WriteExr(path, image, metadata);
  if (ending == ".pfm") return WritePfm(path, image);
  if (ending == ".hdr") return WriteRgbe(path, image);
  throw InputError(InputPosition::File(path),
                   "cannot be written: its name must end in .exr, .pfm or .hdr", kExitUsage);
}

BadPixels RepairRadiance(Image& image) {
  BadPixels bad;
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
