#include "image/formats.h"

#include <algorithm>
#include <cctype>
#include <filesystem>
#include <system_error>

#include "base/error.h"
#include "base/files.h"
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

constexpr std::string_view kExrMagic = "\x76\x2f\x31\x01", kPngMagic = "\x89PNG",
                           kJpegMagic = "\xff\xd8", kBmpMagic = "BM", kGifMagic = "GIF8",
                           kQoiMagic = "qoif";
bool IsWebp(std::string_view bytes) {
  return StartsWith(bytes, "RIFF") && bytes.size() >= 12 && StartsWith(bytes.substr(8), "WEBP");
}
using Decoder8Bit = CompactImage (*)(const std::string& path, std::string_view bytes,
                                     Encoding encoding, const ReadLimits& limits);

// Returns the decoder of a file of 8 bits per channel, or null for other files. TGA has no first
// bytes of its own, and is known by its name.
Decoder8Bit FindDecoder8Bit(const std::string& name, std::string_view bytes) {
  if (StartsWith(bytes, kPngMagic)) return DecodePng;
  if (StartsWith(bytes, kJpegMagic)) return DecodeJpeg;
  if (StartsWith(bytes, kBmpMagic)) return DecodeBmp;
  if (StartsWith(bytes, kGifMagic)) return DecodeGif;
  if (StartsWith(bytes, kQoiMagic)) return DecodeQoi;
  if (IsWebp(bytes)) return DecodeWebp;
  return LowerCaseEnding(name) == ".tga" ? DecodeTga : nullptr;
}

// Says what bytes are that begin like no picture of radiance.
std::string WhatItIsInstead(std::string_view bytes) {
  if (bytes.empty()) return "is empty";
  constexpr std::string_view kTiff = "II*", kTiffFromHigh("MM\0*", 4), kBigTiff = "II+";
  constexpr std::string_view kPointer = "version https://git-lfs";
  std::string what = "is neither OpenEXR, Radiance RGBE nor PFM";
  if (StartsWith(bytes, kPointer)) {
    return what + " but the pointer of Git LFS to it; `git lfs pull` gets the file";
  }
  const auto but = [&](const char* format, const char* advice) {
    return what + " but " + format + ", which " + advice;
  };
  const char* const convert = "cannot be read; convert it to OpenEXR";
  if (StartsWith(bytes, kTiff) || StartsWith(bytes, kTiffFromHigh) || StartsWith(bytes, kBigTiff)) {
    return but("TIFF", convert);
  }
  if (StartsWith(bytes, "DDS ")) return but("DDS", "cannot be read; convert it to PNG or OpenEXR");
  if (StartsWith(bytes, "\xabKTX")) return but("KTX", "cannot be read; convert it to PNG");
  if (StartsWith(bytes, "8BPS")) return but("a file of Photoshop", convert);
  if (FindDecoder8Bit("", bytes) != nullptr) {
    return but("a picture for screens (PNG, JPEG and the like)", "has no radiance");
  }
  return what;
}

// Throws where only an EXR would have what is asked for.
void RequireNoLayer(const std::string& path, const std::string& layer) {
  if (layer.empty()) return;
  throw InputError(InputPosition::File(path),
                   "has no layer " + layer + ": only OpenEXR files have layers");
}

Image DecodeImage(const std::string& path, std::string_view bytes, const ReadLimits& limits,
                  const std::string& layer = "") {
  if (StartsWith(bytes, kExrMagic)) return DecodeExr(path, bytes, limits, {}, layer).image;
  RequireNoLayer(path, layer);
  if (StartsWith(bytes, "#?")) return DecodeRgbe(path, bytes, limits);
  if (StartsWith(bytes, "PF") || StartsWith(bytes, "Pf")) return DecodePfm(path, bytes, limits);
  throw InputError(InputPosition::Byte(path, 0), WhatItIsInstead(bytes));
}

const std::string kExrAlpha = "A";

bool HasExrAlpha(const std::string& path, std::string_view bytes, const ReadLimits& limits) {
  if (!StartsWith(bytes, kExrMagic)) return false;
  const std::vector<std::string> names = ExrLayerNames(path, bytes, limits);
  return std::find(names.begin(), names.end(), kExrAlpha) != names.end();
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

Image ReadImage(const std::string& path, const ReadLimits& limits) {
  const auto [file, layer] = SplitFileName(path);
  return DecodeImage(file, ReadFile(file), limits, layer);
}

std::vector<std::string> ReadLayerNames(const std::string& path, const ReadLimits& limits) {
  const auto [file, layer] = SplitFileName(path);
  const std::string bytes = ReadFile(file);
  if (!StartsWith(bytes, kExrMagic)) return {};
  return ExrLayerNames(file, bytes, limits, layer);
}

namespace {

// Reads what `decode` makes of an EXR, or a picture without layers.
LayeredImage ReadBy(decltype(DecodeExr)* decode, const std::string& name,
                    const std::vector<std::string>& layers, const ReadLimits& limits) {
  const auto [path, layer] = SplitFileName(name);
  const std::string bytes = ReadFile(path);
  if (StartsWith(bytes, kExrMagic)) return decode(path, bytes, limits, layers, layer);
  RequireNoLayer(path, layers.empty() ? layer : layers.front());
  return {DecodeImage(path, bytes, limits)};
}

}  // namespace

LayeredImage ReadLayeredImage(const std::string& path, const std::vector<std::string>& layers,
                              const ReadLimits& limits) {
  return ReadBy(DecodeExr, path, layers, limits);
}

LayeredImage ReadDataWindow(const std::string& path, const std::vector<std::string>& layers,
                            const ReadLimits& limits) {
  return ReadBy(DecodeExrPart, path, layers, limits);
}

LayeredImage ReadOwnColors(const std::string& path, const std::vector<std::string>& layers,
                           const ReadLimits& limits) {
  return ReadBy(DecodeExrColors, path, layers, limits);
}

bool IsRgba(const std::string& path, const ReadLimits& limits) {
  const std::string bytes = ReadFile(path);
  // The places of PNG's type of colours and of QOI's number of channels.
  if (StartsWith(bytes, kPngMagic)) return bytes.size() > 25 && bytes[25] == 6;
  if (StartsWith(bytes, kQoiMagic)) return bytes.size() > 12 && bytes[12] == 4;
  return HasExrAlpha(path, bytes, limits);
}

CompactImage DecodeCompactTexture(const std::string& name, std::string_view bytes,
                                  Encoding encoding, const ReadLimits& limits) {
  const Decoder8Bit decode = FindDecoder8Bit(name, bytes);
  if (encoding == Encoding::kAlpha && (!decode || decode == DecodeJpeg)) {
    if (HasExrAlpha(name, bytes, limits)) {
      LayeredImage read = DecodeExr(name, bytes, limits, {kExrAlpha});
      for (std::size_t i = 0; i < read.image.rgb.size(); ++i) {
        read.image.rgb[i] = read.layers[0].values[i / 3];
      }
      return CompactImage(std::move(read.image));
    }
    Image opaque(1, 1);
    opaque.rgb = {1, 1, 1};
    return opaque;
  }
  if (decode) return decode(name, bytes, encoding, limits);
  return DecodeImage(name, bytes, limits);
}

bool IsGltfImage(std::string_view bytes) {
  return StartsWith(bytes, kPngMagic) || StartsWith(bytes, kJpegMagic) || IsWebp(bytes);
}

bool IsOfScreen(const std::string& path) {
  const auto [file, layer] = SplitFileName(path);
  return FindDecoder8Bit(file, ReadFile(file)) != nullptr;
}

CompactImage ReadCompactTexture(const std::string& path, Encoding encoding,
                                const ReadLimits& limits) {
  const auto [file, layer] = SplitFileName(path);
  const std::string bytes = ReadFile(file);
  if (layer.empty()) return DecodeCompactTexture(file, bytes, encoding, limits);
  if (!StartsWith(bytes, kExrMagic)) RequireNoLayer(file, layer);
  return DecodeImage(file, bytes, limits, layer);
}

Image ReadTexture(const std::string& path, Encoding encoding, const ReadLimits& limits) {
  return ReadCompactTexture(path, encoding, limits).Floats();
}

Image DecodeTexture(const std::string& name, std::string_view bytes, Encoding encoding,
                    const ReadLimits& limits) {
  return DecodeCompactTexture(name, bytes, encoding, limits).Floats();
}

CompactImage FromRgba(int width, int height, const std::uint8_t* rgba, Encoding encoding) {
  const std::size_t pixels = std::size_t(width) * std::size_t(height);
  std::vector<std::uint8_t> codes(3 * pixels);
  for (std::size_t i = 0; i < pixels; ++i) {
    if (encoding == Encoding::kAlpha) {
      std::fill_n(&codes[3 * i], 3, rgba[4 * i + 3]);
    } else {
      std::copy_n(&rgba[4 * i], 3, &codes[3 * i]);
    }
  }
  return {width, height, std::move(codes), encoding};
}

Image FromDeepRgba(int width, int height, const std::vector<std::uint16_t>& rgba,
                   Encoding encoding) {
  std::vector<float> table(65536);
  for (std::size_t i = 0; i < table.size(); ++i) {
    const double share = double(i) / 65535;
    table[i] = float(encoding == Encoding::kSrgb ? LinearFromSrgb(share) : share);
  }
  Image image(width, height);
  for (std::size_t i = 0; i < image.rgb.size(); ++i) {
    const std::size_t channel = encoding == Encoding::kAlpha ? 3 : i % 3;
    image.rgb[i] = table[rgba[4 * (i / 3) + channel]];
  }
  return image;
}

void SpreadGrey(Image& image) {
  for (std::size_t i = 0; i < image.rgb.size(); i += 3) {
    image.rgb[i + 1] = image.rgb[i + 2] = image.rgb[i];
  }
}

void WriteImage(const std::string& path, const Image& image, const Metadata& metadata) {
  const std::string ending = LowerCaseEnding(path);
  if (ending == ".exr") return WriteExr(path, image, metadata);
  if (ending == ".pfm") return WritePfm(path, image);
  if (ending == ".hdr") return WriteRgbe(path, image);
  throw InputError(InputPosition::File(path),
                   "cannot be written: its name must end in .exr, .pfm or .hdr", kExitUsage);
}

}  // namespace skywave
