// Decodes the chunks of EXR files of scan lines that are uncompressed or compressed by deflate,
// which most files are. The OpenEXR library would inflate them once more, after their size has been
// checked. For image/ only.
#pragma once

#include <tbb/enumerable_thread_specific.h>

#include <cstdint>
#include <mutex>
#include <string>
#include <string_view>
#include <vector>

#include "image/deflate.h"
#include "image/exr_header.h"
#include "image/image.h"

namespace skywave {

class ExrScanLines {
 public:
  // `names` has the channels for red, green and blue, or one for all of them, and `layers` other
  // channels of the file. The header must outlive this.
  ExrScanLines(const ExrHeader& header, const std::vector<std::string>& names,
               const std::vector<std::string>& layers);

  // False means that the file is of another kind, for the library to decode.
  bool can_decode() const { return can_decode_; }

  // Takes the chunk whose first row has the coordinate `y` in the file, and whose pixels are
  // `decoded_bytes` when decoded. Returns whether they are. Threads may take different chunks at
  // the same time.
  bool Take(std::int64_t y, std::string_view stored, std::int64_t decoded_bytes);

  // Returns the picture with its layers, once all chunks have been taken.
  LayeredImage Picture();

 private:
  // The bytes of pixels in the order of the file: byte i of the even ones is low[i * step].
  struct Bytes {
    const std::uint8_t *low, *high;
    std::size_t step;
  };
  struct Buffers {  // of a thread
    Inflater inflater;
    std::vector<std::uint8_t> differences, inflated;
  };
  static bool Inflate(std::string_view stored, std::size_t decoded_bytes, Buffers& buffers);
  void Allocate();
  void Convert(const Bytes& bytes, bool is_half, float* values, std::size_t stride) const;

  const ExrHeader& header_;
  // Of each channel of the file: 0 to 2 for red, green and blue, 3 + i for layer i, -1 for none.
  std::vector<int> targets_;
  bool can_decode_ = false, is_grey_ = false;
  std::size_t width_;
  tbb::enumerable_thread_specific<Buffers> buffers_;
  std::once_flag allocated_;
  LayeredImage picture_;
};

}  // namespace skywave
