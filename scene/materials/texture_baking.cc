#include "scene/materials/texture_baking.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <vector>

#include "scene/materials/texture_files.h"

namespace skywave {
namespace {

constexpr std::size_t kMaxOperands = 4;

bool LieAlike(const Texture& a, const Texture& b) {
  return a.transform == b.transform && a.wrap_u == b.wrap_u && a.wrap_v == b.wrap_v;
}

bool RepeatsInUnitSquare(const Texture& texture) {
  const glm::mat3x2& t = texture.transform;
  const auto whole = [](float scale) { return scale != 0 && scale == std::floor(scale); };
  return texture.wrap_u == TextureWrap::kRepeat && texture.wrap_v == TextureWrap::kRepeat &&
         t[0].y == 0 && t[1].x == 0 && whole(t[0].x) && whole(t[1].y);
}

// Returns the texel that stands for one beyond the image.
int Wrap(int i, int size, TextureWrap wrap) {
  return wrap == TextureWrap::kRepeat ? ((i % size) + size) % size : std::clamp(i, 0, size - 1);
}

}  // namespace

std::uint32_t UnfilteredImages::Of(std::uint32_t image, std::size_t& baked, Scene& scene,
                                   const std::function<void(const std::string&)>& warn) {
  const auto [found, is_new] = known.try_emplace(image, image);
  if (!is_new) return found->second;
  const CompactImage& texels = scene.images[image];
  const int longest = std::max(texels.width, texels.height);
  const int by = std::min(kMaxBakedSide / longest, kCheckTexels);
  const int width = texels.width * by, height = texels.height * by;
  const std::size_t count = std::size_t(width) * std::size_t(height);
  if (longest > kMaxUnfilteredSide || baked + count > kMaxBakedTexels) {
    warn(
        fmt::format("the filter {} is not supported for so many images, or for images of more "
                    "than {} texels per side: texels are interpolated",
                    name, kMaxUnfilteredSide));
    return image;
  }
  baked += count;
  Image squares(width, height);
  for (int y = 0; y < height; ++y) {
    for (int x = 0; x < width; ++x) {
      std::copy_n(texels.Pixel(x / by, y / by).data(), 3, squares.Pixel(x, y));
    }
  }
  return found->second = AddTextureImage(scene, std::move(squares));
}

glm::vec3 LookUpImage(const CompactImage& image, const Texture& texture, const glm::dvec2& at) {
  const double x = at.x * image.width - 0.5, y = at.y * image.height - 0.5;
  const double fx = x - std::floor(x), fy = y - std::floor(y);
  glm::dvec3 sum(0);
  for (int i = 0; i < 4; ++i) {
    const double weight = (i % 2 ? fx : 1 - fx) * (i / 2 ? fy : 1 - fy);
    const auto texel = image.Pixel(Wrap(int(std::floor(x)) + i % 2, image.width, texture.wrap_u),
                                   Wrap(int(std::floor(y)) + i / 2, image.height, texture.wrap_v));
    if (weight > 0) sum += weight * glm::dvec3(texel[0], texel[1], texel[2]);
  }
  return sum;
}

Image CheckerSelector() {
  Image image(2 * kCheckTexels, 2 * kCheckTexels);
  for (int y = 0; y < image.height; ++y) {
    for (int x = 0; x < image.width; ++x) {
      const bool odd = (x / kCheckTexels + (image.height - 1 - y) / kCheckTexels) % 2 == 1;
      std::fill_n(image.Pixel(x, y), 3, odd ? 1.0f : 0.0f);
    }
  }
  return image;
}

std::optional<Texture> BakeTexture(std::span<const TextureOperand> operands,
                                   const CombineTexels& combine, Scene& scene) {
  std::vector<const Texture*> varying;
  for (const TextureOperand& operand : operands) {
    if (operand.texture) varying.push_back(operand.texture);
  }
  const bool alike = std::all_of(varying.begin(), varying.end(),
                                 [&](const Texture* t) { return LieAlike(*t, *varying[0]); });
  if (!alike && !std::all_of(varying.begin(), varying.end(),
                             [](const Texture* t) { return RepeatsInUnitSquare(*t); })) {
    return std::nullopt;
  }

  double width = 1, height = 1;
  for (const Texture* texture : varying) {
    const CompactImage& image = scene.images[texture->image];
    const glm::mat3x2& t = texture->transform;
    width = std::max(width, image.width * (alike ? 1.0 : std::abs(double(t[0].x))));
    height = std::max(height, image.height * (alike ? 1.0 : std::abs(double(t[1].y))));
  }
  Image baked(int(std::min(width, double(kMaxBakedSide))),
              int(std::min(height, double(kMaxBakedSide))));
  std::array<glm::vec3, kMaxOperands> values;
  for (int y = 0; y < baked.height; ++y) {
    for (int x = 0; x < baked.width; ++x) {
      const glm::dvec2 at((x + 0.5) / baked.width, (y + 0.5) / baked.height);
      for (std::size_t i = 0; i < operands.size(); ++i) {
        values[i] = operands[i].factor;
        const Texture* texture = operands[i].texture;
        if (!texture) continue;
        const glm::dvec2 inside =
            alike ? at : glm::dvec2(glm::dmat3x2(texture->transform) * glm::dvec3(at, 1));
        values[i] *= LookUpImage(scene.images[texture->image], *texture, inside);
      }
      const glm::vec3 value = combine({values.data(), operands.size()});
      for (int c = 0; c < 3; ++c) baked.Pixel(x, y)[c] = value[c];
    }
  }
  Texture result;
  if (alike) result = *varying[0];
  result.image = AddTextureImage(scene, std::move(baked));
  return result;
}

}  // namespace skywave
