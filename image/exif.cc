#include "image/exif.h"

#include <cstdint>
#include <cstring>

namespace skywave {
namespace {

using Bytes = std::string_view;

// Reads numbers of a TIFF structure; offsets beyond its end give nothing.
struct Tiff {
  Bytes bytes;
  bool big_endian;

  std::optional<std::uint32_t> Number(std::size_t at, std::size_t size) const {
    if (at > bytes.size() || bytes.size() - at < size) return std::nullopt;
    std::uint32_t value = 0;
    for (std::size_t i = 0; i < size; ++i) {
      const std::size_t byte = big_endian ? i : size - 1 - i;
      value = (value << 8) | std::uint8_t(bytes[at + byte]);
    }
    return value;
  }
  std::optional<double> Ratio(std::size_t at) const {
    const auto above = Number(at, 4), below = Number(at + 4, 4);
    if (!above || !below || *above == 0 || *below == 0) return std::nullopt;
    return double(*above) / *below;
  }

  // Returns where the entry of a tag begins in the directory at `directory`.
  std::optional<std::size_t> Find(std::size_t directory, std::uint32_t tag) const {
    constexpr std::size_t kEntry = 12;
    const auto count = Number(directory, 2);
    if (!count) return std::nullopt;
    for (std::size_t i = 0; i < *count; ++i) {
      const std::size_t entry = directory + 2 + i * kEntry;
      if (Number(entry, 2) == tag) return entry;
    }
    return std::nullopt;
  }
};

constexpr std::size_t kValue = 8;  // place of the value, or of its offset, in an entry

std::optional<double> RatioOf(const Tiff& tiff, std::size_t directory, std::uint32_t tag) {
  const auto entry = tiff.Find(directory, tag);
  const auto at = entry ? tiff.Number(*entry + kValue, 4) : std::nullopt;
  return at ? tiff.Ratio(*at) : std::nullopt;
}

// A number of 16 bits stands in its entry, one of 32 likewise.
std::optional<double> WholeOf(const Tiff& tiff, std::size_t directory, std::uint32_t tag) {
  constexpr std::uint32_t kShort = 3;
  const auto entry = tiff.Find(directory, tag);
  if (!entry) return std::nullopt;
  const std::size_t size = tiff.Number(*entry + 2, 2) == kShort ? 2 : 4;
  const auto value = tiff.Number(*entry + kValue, size);
  return value && *value > 0 ? std::optional<double>(*value) : std::nullopt;
}

CameraExposure ExposureOf(const Tiff& tiff) {
  constexpr std::uint32_t kExifDirectory = 0x8769, kExposureTime = 0x829A, kFNumber = 0x829D,
                          kIso = 0x8827;
  const auto first = tiff.Number(4, 4);
  const auto entry = first ? tiff.Find(*first, kExifDirectory) : std::nullopt;
  const auto exif = entry ? tiff.Number(*entry + kValue, 4) : std::nullopt;
  if (!exif) return {};
  return {.seconds = RatioOf(tiff, *exif, kExposureTime),
          .f_number = RatioOf(tiff, *exif, kFNumber),
          .iso = WholeOf(tiff, *exif, kIso)};
}

}  // namespace

CameraExposure ReadCameraExposure(Bytes bytes) {
  constexpr Bytes kJpeg("\xFF\xD8", 2), kExif("Exif\0\0", 6);
  constexpr std::uint8_t kApplication1 = 0xE1, kScan = 0xDA;
  if (!bytes.starts_with(kJpeg)) return {};
  // Segments: 0xFF, kind, length of 16 bits with itself, contents.
  for (std::size_t at = 2; bytes.size() - at > 4 && std::uint8_t(bytes[at]) == 0xFF;) {
    const auto kind = std::uint8_t(bytes[at + 1]);
    const std::size_t length =
        std::size_t(std::uint8_t(bytes[at + 2])) << 8 | std::size_t(std::uint8_t(bytes[at + 3]));
    if (kind == kScan || length < 2 || bytes.size() - at - 2 < length) return {};
    const Bytes contents = bytes.substr(at + 4, length - 2);
    if (kind == kApplication1 && contents.starts_with(kExif)) {
      const Bytes tiff = contents.substr(kExif.size());
      return ExposureOf({tiff, tiff.starts_with("MM")});
    }
    at += 2 + length;
  }
  return {};
}

}  // namespace skywave
