#include "image/placement.h"

#include <algorithm>

namespace skywave {
namespace {

// Returns values of the pixels `to`, of which those of `from` are there. A pixel has `step` values.
std::vector<float> Moved(const std::vector<float>& values, std::size_t step, const PixelBox& from,
                         const PixelBox& to) {
  std::vector<float> moved;
  ResizeLarge(moved, std::size_t(to.width) * std::size_t(to.height) * step);
  const PixelBox both = Common(from, to);
  const auto at = [&](const PixelBox& box, std::int64_t y) {
    return (std::size_t(y - box.y) * std::size_t(box.width) + std::size_t(both.x - box.x)) * step;
  };
  for (std::int64_t y = both.y; y < both.y + both.height && both.width > 0; ++y) {
    std::copy_n(&values[at(from, y)], std::size_t(both.width) * step, &moved[at(to, y)]);
  }
  return moved;
}

}  // namespace

PixelBox WholeOf(const LayeredImage& picture) {
  const Placement& place = picture.placement;
  if (place.width == 0) return {0, 0, picture.image.width, picture.image.height};
  return {0, 0, place.width, place.height};
}

PixelBox PartOf(const LayeredImage& picture) {
  return {picture.placement.x, picture.placement.y, picture.image.width, picture.image.height};
}

PixelBox Common(const PixelBox& a, const PixelBox& b) {
  const std::int64_t x = std::max(a.x, b.x), y = std::max(a.y, b.y);
  return {x, y, std::max<std::int64_t>(std::min(a.x + a.width, b.x + b.width) - x, 0),
          std::max<std::int64_t>(std::min(a.y + a.height, b.y + b.height) - y, 0)};
}

void CutTo(const PixelBox& box, LayeredImage& picture) {
  const PixelBox from = PartOf(picture), whole = WholeOf(picture);
  if (box == from) return;
  picture.image.rgb = Moved(picture.image.rgb, 3, from, box);
  picture.image.width = int(box.width), picture.image.height = int(box.height);
  for (NamedChannel& layer : picture.layers) layer.values = Moved(layer.values, 1, from, box);
  picture.placement = {int(box.x), int(box.y), int(whole.width), int(whole.height)};
}

}  // namespace skywave
