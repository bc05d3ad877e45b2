#include "image/exr_scan_lines.h"

#include <half.h>

#include <algorithm>
#include <bit>

#include "image/formats.h"

namespace skywave {

ExrScanLines::ExrScanLines(const ExrHeader& header, const std::vector<std::string>& names,
                           const std::vector<std::string>& layers)
    : header_(header),
      is_grey_(names.size() == 1),
      width_(std::size_t(header.data_window.width())) {
  const ExrCompression compression = header.compression;
  can_decode_ = std::endian::native == std::endian::little && !header.tiled && !header.deep &&
                (compression == ExrCompression::kNone || compression == ExrCompression::kZips ||
                 compression == ExrCompression::kZip);
  for (const ExrChannel& channel : header.channels) {
    const auto name = std::find(names.begin(), names.end(), channel.name);
    const auto layer = std::find(layers.begin(), layers.end(), channel.name);
    targets_.push_back(name != names.end()     ? int(name - names.begin())
                       : layer != layers.end() ? 3 + int(layer - layers.begin())
                                               : -1);
    if (targets_.back() >= 0 && channel.is_whole) can_decode_ = false;
  }
  for (const std::string& layer : layers) picture_.layers.push_back({layer, {}});
}

// Inflates, and undoes the differences between neighbours that were taken before
// ("Predictor" in the library's ImfZip.cpp).
bool ExrScanLines::Inflate(std::string_view stored, std::size_t decoded_bytes, Buffers& buffers) {
  buffers.differences.resize(decoded_bytes);
  buffers.inflated.resize(decoded_bytes);
  const std::uint8_t* const differences = buffers.differences.data();
  std::uint8_t* const inflated = buffers.inflated.data();
  if (!buffers.inflater.Inflate(stored, buffers.differences.data(), decoded_bytes)) return false;
  std::uint8_t sum = 128;
  for (std::size_t i = 0; i < decoded_bytes; ++i) {
    sum = std::uint8_t(sum + differences[i] - 128);
    inflated[i] = sum;
  }
  return true;
}

void ExrScanLines::Allocate() {
  picture_.image = Image(int(width_), int(header_.data_window.height()));
  for (NamedChannel& layer : picture_.layers) {
    ResizeLarge(layer.values, picture_.image.rgb.size() / 3);
  }
}

void ExrScanLines::Convert(const Bytes& bytes, bool is_half, float* values,
                           std::size_t stride) const {
  const auto [low, high, step] = bytes;
  const auto pair = [low = low, high = high, step = step](std::size_t i) {
    return std::uint32_t(low[i * step]) | std::uint32_t(high[i * step]) << 8;
  };
  if (is_half) {
    for (std::size_t x = 0; x < width_; ++x) {
      half value;
      value.setBits(std::uint16_t(pair(x)));
      values[stride * x] = float(value);
    }
  } else {
    for (std::size_t x = 0; x < width_; ++x) {
      values[stride * x] = std::bit_cast<float>(pair(2 * x) | pair(2 * x + 1) << 16);
    }
  }
}

bool ExrScanLines::Take(std::int64_t y, std::string_view stored, std::int64_t decoded_bytes) {
  const auto size = std::size_t(decoded_bytes);
  Bytes bytes;
  if (stored.size() == size) {  // compression would not have made it smaller
    const auto* const plain = reinterpret_cast<const std::uint8_t*>(stored.data());
    bytes = {.low = plain, .high = plain + 1, .step = 2};
  } else {
    Buffers& buffers = buffers_.local();
    if (!Inflate(stored, size, buffers)) return false;
    const std::uint8_t* const inflated = buffers.inflated.data();
    bytes = {.low = inflated, .high = inflated + (size + 1) / 2, .step = 1};
  }
  std::call_once(allocated_, [&] { Allocate(); });
  const std::size_t row_bytes = width_ * std::size_t(header_.pixel_bytes());
  const auto first = std::size_t(y - header_.data_window.y_min);
  for (std::size_t row = 0; row < size / row_bytes; ++row) {
    for (std::size_t c = 0; c < targets_.size(); ++c) {
      const bool is_half = header_.channels[c].bytes == 2;
      const int target = targets_[c];
      if (target >= 3) {
        float* const layer = picture_.layers[std::size_t(target) - 3].values.data();
        Convert(bytes, is_half, layer + (first + row) * width_, 1);
      } else if (target >= 0) {
        Convert(bytes, is_half, picture_.image.Pixel(0, int(first + row)) + target, 3);
      }
      const std::size_t pairs = width_ * (is_half ? 1 : 2) * bytes.step;
      bytes.low += pairs, bytes.high += pairs;
    }
  }
  return true;
}

LayeredImage ExrScanLines::Picture() {
  if (is_grey_) SpreadGrey(picture_.image);
  return std::move(picture_);
}

}  // namespace skywave
