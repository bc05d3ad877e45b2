#include "image/compact_image.h"

#include <algorithm>
#include <utility>

#include "image/srgb.h"

namespace skywave {
namespace {

using Meaning = std::array<float, 256>;

Meaning MeaningOf(double (*value)(double)) {
  Meaning meaning;
  for (int i = 0; i < 256; ++i) meaning[std::size_t(i)] = float(value(i / 255.0));
  return meaning;
}

const float* MeaningOf(Encoding encoding) {
  static const Meaning colors = MeaningOf(LinearFromSrgb);
  static const Meaning numbers = MeaningOf([](double share) { return share; });
  return encoding == Encoding::kSrgb ? colors.data() : numbers.data();
}

}  // namespace

CompactImage::CompactImage(int w, int h, std::vector<std::uint8_t> codes, Encoding encoding)
    : width(w), height(h), codes_(std::move(codes)), meaning_(MeaningOf(encoding)) {}

const float* CompactImage::Row(int y, std::vector<float>& decoded) const {
  if (codes_.empty()) return floats_.Pixel(0, y);
  const std::size_t count = 3 * std::size_t(width), first = std::size_t(y) * count;
  decoded.resize(count);
  for (std::size_t i = 0; i < count; ++i) decoded[i] = meaning_[codes_[first + i]];
  return decoded.data();
}

Image CompactImage::Floats() const {
  if (codes_.empty()) return floats_;
  Image image(width, height);
  std::transform(codes_.begin(), codes_.end(), image.rgb.begin(),
                 [this](std::uint8_t code) { return meaning_[code]; });
  return image;
}

void CompactImage::Repair() { RepairRadiance(floats_); }

}  // namespace skywave
