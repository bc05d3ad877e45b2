#include "scene/texture_tables.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "base/error.h"

namespace skywave {
namespace {

constexpr std::size_t kMaxTexels = std::size_t{1} << 29;
// Coordinates beyond this have lost the place within a texel anyway.
constexpr float kMaxCoordinate = 1e6f;

// Halves one direction: `stride` between neighbours, `lines` of `count` texels.
std::vector<double> HalveLines(const std::vector<double>& from, std::size_t count,
                               std::size_t lines, bool along_rows) {
  const std::size_t half = std::max<std::size_t>(count / 2, 1);
  const double step = double(count) / double(half);
  std::vector<double> to(half * lines * 3);
  for (std::size_t line = 0; line < lines; ++line) {
    for (std::size_t i = 0; i < half; ++i) {
      const double begin = double(i) * step, end = begin + step;
      for (auto k = std::size_t(begin); k < count && double(k) < end; ++k) {
        const double share = (std::min(end, double(k + 1)) - std::max(begin, double(k))) / step;
        const std::size_t source = along_rows ? line * count + k : k * lines + line;
        const std::size_t target = along_rows ? line * half + i : i * lines + line;
        for (std::size_t c = 0; c < 3; ++c) to[3 * target + c] += share * from[3 * source + c];
      }
    }
  }
  return to;
}

std::uint32_t AppendLevels(Image image, TextureTables& tables, const std::string& path) {
  std::uint32_t count = 0;
  while (true) {
    if (tables.texels.size() + image.rgb.size() / 3 > kMaxTexels) {
      throw InputError(InputPosition::File(path),
                       fmt::format("the textures have more than {} texels", kMaxTexels));
    }
    tables.levels.push_back({std::uint32_t(tables.texels.size()), std::uint32_t(image.width),
                             std::uint32_t(image.height), 0});
    for (std::size_t i = 0; i < image.rgb.size(); i += 3) {
      tables.texels.push_back(PackTexel(&image.rgb[i]));
    }
    ++count;
    if (image.width == 1 && image.height == 1) return count;
    image = HalfSize(image);
  }
}

}  // namespace

Image HalfSize(const Image& image) {
  const auto width = std::size_t(image.width), height = std::size_t(image.height);
  std::vector<double> pixels(image.rgb.begin(), image.rgb.end());
  pixels = HalveLines(pixels, width, height, true);
  const std::size_t half_width = std::max<std::size_t>(width / 2, 1);
  pixels = HalveLines(pixels, height, half_width, false);
  Image half(int(half_width), std::max(image.height / 2, 1));
  std::transform(pixels.begin(), pixels.end(), half.rgb.begin(),
                 [](double value) { return float(value); });
  return half;
}

TextureView TextureTables::view() const {
  if (records.empty()) return {};
  return {records.data(), levels.data(), texels.data(), uvs.data()};
}

std::size_t TextureTables::bytes() const {
  return records.size() * sizeof(TextureRecord) + levels.size() * sizeof(TextureLevel) +
         texels.size() * sizeof(std::uint32_t) + uvs.size() * sizeof(TriangleUvs);
}

TextureTables MakeTextureTables(const Scene& scene, const std::string& path) {
  TextureTables tables;
  struct Pyramid {
    std::uint32_t first, count;
  };
  std::vector<Pyramid> pyramids;
  for (const Image& image : scene.images) {
    const auto first = std::uint32_t(tables.levels.size());
    pyramids.push_back({first, AppendLevels(image, tables, path)});
  }
  for (const Texture& texture : scene.textures) {
    if (texture.image >= scene.images.size()) {
      throw InputError(InputPosition::File(path), "a texture has no image");
    }
    const Image& image = scene.images[texture.image];
    TextureRecord record = {.first_level = pyramids[texture.image].first,
                            .levels = pyramids[texture.image].count,
                            .wrap_u = texture.wrap_u,
                            .wrap_v = texture.wrap_v,
                            .transform = {},
                            .texels = 0,
                            .unused = {}};
    for (int column = 0; column < 3; ++column) {
      for (int row = 0; row < 2; ++row) {
        const float number = texture.transform[column][row];
        if (!(std::abs(number) <= kMaxCoordinate)) {
          throw InputError(InputPosition::File(path),
                           "a texture has a transform that is not finite or too large");
        }
        record.transform[3 * row + column] = number;
      }
    }
    const float* t = record.transform;
    record.texels =
        std::sqrt(std::abs(t[0] * t[4] - t[1] * t[3]) * float(image.width) * float(image.height));
    tables.records.push_back(record);
  }
  return tables;
}

TriangleUvs MakeTriangleUvs(const Mesh& mesh, const glm::uvec3& corners) {
  TriangleUvs record = {};
  if (mesh.uvs.empty()) return record;
  for (int i = 0; i < 3; ++i) {
    for (int axis = 0; axis < 2; ++axis) {
      const float value = mesh.uvs[corners[i]][axis];
      // min and max turn NaN into a number.
      record.uv[i][axis] = std::min(std::max(-kMaxCoordinate, value), kMaxCoordinate);
    }
  }
  const glm::vec3 &a = mesh.positions[corners.x], &b = mesh.positions[corners.y],
                  &c = mesh.positions[corners.z];
  const float area = glm::length(glm::cross(b - a, c - a));
  const float s1 = record.uv[1][0] - record.uv[0][0], t1 = record.uv[1][1] - record.uv[0][1];
  const float s2 = record.uv[2][0] - record.uv[0][0], t2 = record.uv[2][1] - record.uv[0][1];
  const float density = std::sqrt(std::abs(s1 * t2 - s2 * t1) / area);
  record.density = std::isfinite(density) ? density : 0.0f;
  return record;
}

}  // namespace skywave
