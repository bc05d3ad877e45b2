#include "job/batch/thumbnail.h"

#include <algorithm>
#include <cmath>
#include <cstdint>

#include "base/error.h"
#include "image/image.h"
#include "image/jpeg.h"

namespace skywave {
namespace {

constexpr int kQuality = 85;

// Returns the mean of the pixels of `image` in each of `width` x `height` equal boxes. Whole pixels
// are counted, so boxes of a few pixels differ a little in size.
Image Shrunk(const Image& image, int width, int height) {
  Image small(width, height);
  const auto edge = [](int i, int count, int size) { return int(std::int64_t{i} * size / count); };
  for (int y = 0; y < height; ++y) {
    const int top = edge(y, height, image.height), bottom = edge(y + 1, height, image.height);
    for (int x = 0; x < width; ++x) {
      const int left = edge(x, width, image.width), right = edge(x + 1, width, image.width);
      double sum[3] = {};
      for (int v = top; v < bottom; ++v) {
        for (int u = left; u < right; ++u) {
          for (int c = 0; c < 3; ++c) sum[c] += double(image.Pixel(u, v)[c]);
        }
      }
      for (int c = 0; c < 3; ++c) {
        small.Pixel(x, y)[c] = float(sum[c] / ((bottom - top) * (right - left)));
      }
    }
  }
  return small;
}

}  // namespace

Thumbnail MakeThumbnail(const std::string& png) {
  Image image;
  try {
    image = ReadTexture(png, Encoding::kSrgb);
  } catch (const InputError&) {
    return {};
  }
  const double scale = std::min(1.0, double(kThumbnailSide) / std::max(image.width, image.height));
  const auto side = [scale](int pixels) { return std::max(1, int(std::lround(pixels * scale))); };
  const int width = side(image.width), height = side(image.height);
  if (scale < 1) image = Shrunk(image, width, height);
  return {width, height, EncodeJpeg(width, height, ToneMap(image, {}), kQuality)};
}

}  // namespace skywave
