// Encodes strips of rows of a picture as chunks of EXR files of scan lines that are uncompressed or
// compressed by deflate, which most files are. The OpenEXR library would take three times as long.
// For image/ only.
#pragma once

#include <string>
#include <vector>

#include "image/image.h"

namespace skywave {

// One channel of a picture that is written.
struct WrittenChannel {
  std::string name;
  const float* values;  // of the first row, `stride` floats from pixel to pixel
  std::size_t stride;
  bool half;
};

// Returns the 16-bit float of a value, rounded to nearest; finite ones beyond its range become its
// largest.
std::uint16_t HalfBits(float value);

// Returns whether the compression is one that EncodeStrip knows.
bool CanEncodeStrip(ExrCompression compression);

// Returns the chunks of the rows [first, last) of a picture that is `width` pixels wide. The
// channels are in the order of their names, which is that of files. `first` is a multiple of
// RowsPerChunk; in the file row 0 has the number `top`.
std::string EncodeStrip(ExrCompression compression, const std::vector<WrittenChannel>& channels,
                        int width, int first, int last, int top = 0);

}  // namespace skywave
