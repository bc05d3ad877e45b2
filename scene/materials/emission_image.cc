#include "scene/materials/emission_image.h"

#include <algorithm>
#include <cmath>

#include "kernels/surface/texture.h"

namespace skywave {
namespace {

constexpr double kFewest = 16, kMost = 1024;  // number of points of a mean

// Returns a texel as PackTexel keeps it, but for rounding.
glm::vec3 Texel(const CompactImage& image, int x, int y) {
  const auto rgb = image.Pixel(x, y);
  // In this order max turns NaN into 0.
  return glm::min(glm::max(glm::vec3(0), glm::vec3(rgb[0], rgb[1], rgb[2])),
                  glm::vec3(kBrightestTexel));
}

float Wrap(TextureWrap how, float x) {
  switch (how) {
    case TextureWrap::kRepeat:
      return x - std::floor(x);
    case TextureWrap::kMirror:
      return std::abs(x - 2 * std::floor(0.5f * x + 0.5f));
    case TextureWrap::kClamp:
      break;
  }
  return x;
}

struct TexelRange {
  int first, last;
};
// Returns the texels [first, last] of a line of `count` that bilinear lookups between two
// coordinates may see: all of them where the image repeats in between.
TexelRange Touched(TextureWrap wrap, double low, double high, int count) {
  if (wrap == TextureWrap::kClamp) {
    low = std::clamp(low, 0.0, 1.0), high = std::clamp(high, 0.0, 1.0);
  } else {
    const double period = wrap == TextureWrap::kMirror ? 2 : 1;
    const double turns = period * std::floor(low / period);
    low -= turns, high -= turns;
    if (wrap == TextureWrap::kMirror && low >= 1 && high <= 2) {
      const double turned = 2 - high;
      high = 2 - low, low = turned;
    }
  }
  const double first = std::floor(low * count - 0.5), last = std::floor(high * count - 0.5) + 1;
  if (wrap == TextureWrap::kRepeat ? first >= 0 && last < count : low >= 0 && high <= 1) {
    return {std::max(int(first), 0), std::min(int(last), count - 1)};
  }
  return {0, count - 1};
}

}  // namespace

EmissionImage::EmissionImage(const CompactImage& image, const Texture& texture)
    : image_(image), texture_(texture) {
  const auto stride = std::size_t(image.width) + 1;
  lit_.resize(stride * (std::size_t(image.height) + 1));
  for (int y = 0; y < image.height; ++y) {
    const std::size_t row = (std::size_t(y) + 1) * stride;
    std::uint32_t lit = 0;
    for (int x = 0; x < image.width; ++x) {
      const glm::vec3 color = Texel(image, x, y);
      brightest_ = glm::max(brightest_, color);
      lit += color != glm::vec3(0);
      lit_[row + std::size_t(x) + 1] = lit_[row - stride + std::size_t(x) + 1] + lit;
    }
  }
}

// Returns the texel that a place lies in.
glm::vec3 EmissionImage::Nearest(const glm::vec2& at) const {
  // min and max turn NaN into a number.
  const auto texel = [](float x, int size) {
    return int(std::min(std::max(0.0f, x * float(size)), float(size - 1)));
  };
  return Texel(image_, texel(Wrap(texture_.wrap_u, at.x), image_.width),
               texel(Wrap(texture_.wrap_v, at.y), image_.height));
}

// Returns whether some texel is not black in the box about a triangle.
bool EmissionImage::IsLit(const std::array<glm::vec2, 3>& at) const {
  const glm::vec2 low = glm::min(at[0], glm::min(at[1], at[2]));
  const glm::vec2 high = glm::max(at[0], glm::max(at[1], at[2]));
  const TexelRange x = Touched(texture_.wrap_u, low.x, high.x, image_.width);
  const TexelRange y = Touched(texture_.wrap_v, low.y, high.y, image_.height);
  const auto sum = [&](int column, int row) {
    return lit_[std::size_t(row) * (std::size_t(image_.width) + 1) + std::size_t(column)];
  };
  return sum(x.last + 1, y.last + 1) - sum(x.first, y.last + 1) - sum(x.last + 1, y.first) +
             sum(x.first, y.first) !=
         0;
}

glm::vec3 EmissionImage::Mean(const std::array<glm::vec2, 3>& uv) const {
  // The points follow the additive recurrence of the plastic number (Roberts 2018).
  constexpr double kStepX = 0.7548776662466927, kStepY = 0.5698402909980532;
  std::array<glm::vec2, 3> at;
  for (std::size_t i = 0; i < 3; ++i) at[i] = texture_.transform * glm::vec3(uv[i], 1);
  if (!IsLit(at)) return glm::vec3(0);
  const glm::dvec2 a(at[1] - at[0]), b(at[2] - at[0]);
  const double texels = 0.5 * std::abs(a.x * b.y - a.y * b.x) * image_.width * image_.height;
  const int points = texels < kMost ? int(std::max(texels, kFewest)) : int(kMost);
  glm::dvec3 sum(0);
  for (int i = 0; i < points; ++i) {
    const double x = std::fmod(0.5 + i * kStepX, 1.0), y = std::fmod(0.5 + i * kStepY, 1.0);
    const double root = std::sqrt(x);
    sum += Nearest(glm::vec2(glm::dvec2(at[0]) + (1 - root) * a + y * root * b));
  }
  const glm::vec3 mean(sum / double(points));
  return mean == glm::vec3(0) ? brightest_ / float(kMost) : mean;
}

}  // namespace skywave
