// Images as scenes keep them: those of files of 8 bits stay bytes, which take a quarter of the
// memory of the floats that they stand for.
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include "image/image.h"

namespace skywave {

class CompactImage {
 public:
  CompactImage() = default;
  CompactImage(Image image)  // NOLINT(google-explicit-constructor): floats are one of two forms
      : width(image.width), height(image.height), floats_(std::move(image)) {}
  // `codes` are three bytes a pixel, rows from the top, and mean what `encoding` says.
  CompactImage(int w, int h, std::vector<std::uint8_t> codes, Encoding encoding);

  int width = 0, height = 0;

  std::size_t values() const { return std::size_t(width) * std::size_t(height) * 3; }
  // Returns a value in the order of Image::rgb.
  float Value(std::size_t i) const { return codes_.empty() ? floats_.rgb[i] : meaning_[codes_[i]]; }
  std::array<float, 3> Pixel(int x, int y) const {
    const std::size_t i = 3 * (std::size_t(y) * std::size_t(width) + std::size_t(x));
    return {Value(i), Value(i + 1), Value(i + 2)};
  }
  // Returns the 3 * width values of a row; `decoded` holds those of bytes.
  const float* Row(int y, std::vector<float>& decoded) const;
  Image Floats() const;

  // Does what RepairRadiance does; bytes are fine.
  void Repair();
  std::size_t bytes() const { return codes_.size() + floats_.rgb.size() * sizeof(float); }

 private:
  // One of both is empty.
  Image floats_;
  std::vector<std::uint8_t> codes_;
  const float* meaning_ = nullptr;  // 256 floats, those that codes stand for
};

// These are ReadTexture and DecodeTexture (image/image.h), whose images are Floats() of what these
// return.
CompactImage ReadCompactTexture(const std::string& path, Encoding encoding,
                                const ReadLimits& limits = {});
CompactImage DecodeCompactTexture(const std::string& name, std::string_view bytes,
                                  Encoding encoding, const ReadLimits& limits = {});

}  // namespace skywave
