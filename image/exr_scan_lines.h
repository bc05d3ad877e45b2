// Decodes the chunks of EXR files of scan lines that are uncompressed or compressed by deflate,
// which most files are. The OpenEXR library would inflate them once more, after their size has been
// checked. For image/ only.
#pragma once

#include <cstdint>
#include <memory>
#include <string>
#include <string_view>
#include <vector>

#include "image/exr_header.h"
#include "image/image.h"

namespace skywave {

class ExrScanLines {
 public:
  // `names` has the channels for red, green and blue, or one for all of them. The header must
  // outlive this.
  ExrScanLines(const ExrHeader& header, const std::vector<std::string>& names);
  ~ExrScanLines();

  // False means that the file is of another kind, for the library to decode.
  bool can_decode() const { return can_decode_; }

  // Takes the chunk whose first row has the coordinate `y` in the file, and whose pixels are
  // `decoded_bytes` when decoded. Returns whether they are.
  bool Take(std::int64_t y, std::string_view stored, std::int64_t decoded_bytes);

  // Returns the picture, once all chunks have been taken.
  Image Picture();

 private:
  // The bytes of pixels in the order of the file: byte i of the even ones is low[i * step].
  struct Bytes {
    const std::uint8_t *low, *high;
    std::size_t step;
  };
  bool Inflate(std::string_view stored, std::size_t decoded_bytes);
  void Convert(const Bytes& bytes, bool is_half, float* pixels) const;

  struct Inflater;
  const ExrHeader& header_;
  std::vector<int> targets_;  // of each channel: red, green or blue, or -1 for none
  bool can_decode_ = false, is_grey_ = false;
  std::size_t width_;
  std::unique_ptr<Inflater> inflater_;
  std::vector<std::uint8_t> inflated_;
  Image image_;
};

}  // namespace skywave
