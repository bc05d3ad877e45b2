// Small pictures for the page of a batch.
#pragma once

#include <cstddef>
#include <string>

namespace skywave {

// Longer side of a thumbnail [pixels].
inline constexpr int kThumbnailSide = 160;
// A page embeds at most this many thumbnails, some 25 MB; further pictures are shown from their
// files.
inline constexpr std::size_t kMostThumbnails = 4000;

struct Thumbnail {
  int width = 0, height = 0;  // 0: there is none
  std::string jpeg;
};

// Returns a thumbnail of the picture in the file `png`, averaged in linear light; a smaller picture
// keeps its size. Returns none for a file that cannot be read.
Thumbnail MakeThumbnail(const std::string& png);

}  // namespace skywave
