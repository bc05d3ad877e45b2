#include "job/backplate.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <cstdint>

#include "image/primaries.h"

namespace skywave {
namespace {

// The pixels of a line that make one of a scaled line, and their weights, which add up to 1.
struct Footprint {
  int first = 0;
  std::vector<double> weights;
};

// Returns the footprints of `to` pixels that show the middle of a line of `from` pixels, each of
// which is `scale` new ones wide: a tent over two pixels, of the wider of both kinds.
std::vector<Footprint> FootprintsOf(int from, int to, double scale) {
  const double radius = std::max(1.0, 1 / scale);
  std::vector<Footprint> footprints;
  for (int i = 0; i < to; ++i) {
    const double center = (i + 0.5 - 0.5 * to) / scale + 0.5 * from;
    const int first = std::max(int(std::ceil(center - radius - 0.5)), 0);
    const int last = std::min(int(std::floor(center + radius - 0.5)), from - 1);
    Footprint& footprint = footprints.emplace_back(Footprint{first, {}});
    double sum = 0;
    for (int k = first; k <= last; ++k) {
      const double weight = std::max(1 - std::abs(k + 0.5 - center) / radius, 0.0);
      footprint.weights.push_back(weight);
      sum += weight;
    }
    for (double& weight : footprint.weights) weight /= sum;
  }
  return footprints;
}

// Returns a picture whose rows are made of those of `image`, columns and rows exchanged.
Image ScaledRows(const Image& image, const std::vector<Footprint>& footprints) {
  Image turned(image.height, int(footprints.size()));
  for (int y = 0; y < image.height; ++y) {
    for (int x = 0; x < turned.height; ++x) {
      const Footprint& at = footprints[std::size_t(x)];
      for (int c = 0; c < 3; ++c) {
        double sum = 0;
        for (std::size_t k = 0; k < at.weights.size(); ++k) {
          sum += at.weights[k] * double(image.Pixel(at.first + int(k), y)[c]);
        }
        turned.Pixel(y, x)[c] = float(sum);
      }
    }
  }
  return turned;
}

Image Scaled(const Image& image, int width, int height) {
  const double scale = std::max(double(width) / image.width, double(height) / image.height);
  return ScaledRows(ScaledRows(image, FootprintsOf(image.width, width, scale)),
                    FootprintsOf(image.height, height, scale));
}

}  // namespace

Backplate ReadBackplate(const std::string& path, int width, int height, RgbSpace space) {
  Backplate plate = {.image = {}, .of_screen = IsOfScreen(path), .note = ""};
  if (IsRgba(path)) {
    const std::vector<float> alpha = ReadTexture(path, Encoding::kAlpha).rgb;
    plate.has_alpha = std::any_of(alpha.begin(), alpha.end(), [](float a) { return a < 1; });
  }
  plate.image = plate.of_screen ? ReadTexture(path, Encoding::kSrgb) : ReadImage(path);
  ConvertColors(FromRec709(space), plate.image);
  const Image& image = plate.image;
  if (image.width == width && image.height == height) return plate;
  const bool same_shape = std::int64_t{image.width} * height == std::int64_t{image.height} * width;
  plate.note =
      fmt::format("{}: {} x {} pixels are scaled to {} x {}{}", path, image.width, image.height,
                  width, height, same_shape ? "" : ", and what is beyond the film is cut off");
  plate.image = Scaled(image, width, height);
  return plate;
}

Image PutOver(const Image& foreground, const std::vector<float>& alpha, const Backplate& backplate,
              const CropWindow& window, float factor) {
  Image composite(foreground.width, foreground.height);
  for (int y = 0; y < composite.height; ++y) {
    for (int x = 0; x < composite.width; ++x) {
      const float* const behind = backplate.image.Pixel(window.x + x, window.y + y);
      const float* const front = foreground.Pixel(x, y);
      const float shown = 1 - alpha[std::size_t(y) * std::size_t(composite.width) + std::size_t(x)];
      for (int c = 0; c < 3; ++c) {
        composite.Pixel(x, y)[c] = front[c] + shown * factor * behind[c];
      }
    }
  }
  return composite;
}

}  // namespace skywave
