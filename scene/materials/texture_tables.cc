#include "scene/materials/texture_tables.h"

#include <fmt/format.h>
#include <tbb/parallel_for.h>

#include <algorithm>
#include <cmath>
#include <map>
#include <set>
#include <tuple>

#include "base/error.h"
#include "kernels/surface/surface.h"

namespace skywave {
namespace {

constexpr std::size_t kMaxTexels = std::size_t{1} << 29;
// Coordinates beyond this have lost the position within a texel anyway.
constexpr float kMaxCoordinate = 1e6f;

// The texels of a line that lie in one of the equal parts that it is halved into, and their shares
// of the part. A part is as long as two texels, or up to three of a line of an odd number.
struct Overlap {
  std::size_t first, count;
  double share[3];
};
std::vector<Overlap> Halve(std::size_t count) {
  const std::size_t half = std::max<std::size_t>(count / 2, 1);
  const double step = double(count) / double(half);
  std::vector<Overlap> parts(half);
  for (std::size_t i = 0; i < half; ++i) {
    const double begin = double(i) * step, end = begin + step;
    parts[i].first = std::size_t(begin);
    for (auto k = parts[i].first; k < count && double(k) < end; ++k) {
      const double share = (std::min(end, double(k + 1)) - std::max(begin, double(k))) / step;
      parts[i].share[parts[i].count++] = share;
    }
  }
  return parts;
}

// Returns HalfSize of an image in which every channel is `value` of what it is.
template <class Value>
Image HalfOf(const CompactImage& image, const Value& value) {
  const std::vector<Overlap> columns = Halve(std::size_t(image.width)),
                             rows = Halve(std::size_t(image.height));
  Image half(int(columns.size()), int(rows.size()));
  tbb::parallel_for(std::size_t{0}, rows.size(), [&](std::size_t row) {
    std::vector<double> line(3 * columns.size());
    std::vector<float> decoded;
    for (std::size_t k = 0; k < rows[row].count; ++k) {
      const float* const from = image.Row(int(rows[row].first + k), decoded);
      for (std::size_t i = 0; i < columns.size(); ++i) {
        double mean[3] = {};
        for (std::size_t j = 0; j < columns[i].count; ++j) {
          const float* const texel = from + 3 * (columns[i].first + j);
          for (std::size_t c = 0; c < 3; ++c) mean[c] += columns[i].share[j] * value(texel[c]);
        }
        for (std::size_t c = 0; c < 3; ++c) line[3 * i + c] += rows[row].share[k] * mean[c];
      }
    }
    std::transform(line.begin(), line.end(), half.Pixel(0, int(row)),
                   [](double mean) { return float(mean); });
  });
  return half;
}

float Itself(float value) { return value; }
// Maps a channel of a normal from [0, 1] to [-1, 1].
float Signed(float value) { return 2 * value - 1; }

// Sets every channel to the mean of the three.
Image Grey(Image image) {
  for (std::size_t i = 0; i < image.rgb.size(); i += 3) {
    std::fill_n(&image.rgb[i], 3, (image.rgb[i] + image.rgb[i + 1] + image.rgb[i + 2]) / 3);
  }
  return image;
}

// Returns the normals of the heights of `texture`, steepened or flattened so that the steepest
// slope is 1. `slope` becomes what it was [height per texel].
Image NormalsOfHeights(const CompactImage& image, const Texture& texture, float& slope) {
  const Image heights = Grey(image.Floats());
  const auto at = [&](int x, int y) {
    const auto inside = [](int i, int count, TextureWrap wrap) {
      return wrap == TextureWrap::kRepeat ? (i + count) % count : std::clamp(i, 0, count - 1);
    };
    return heights.Pixel(inside(x, image.width, texture.wrap_u),
                         inside(y, image.height, texture.wrap_v))[0];
  };
  Image normals(image.width, image.height);
  slope = 0;
  for (int y = 0; y < image.height; ++y) {
    for (int x = 0; x < image.width; ++x) {
      float* normal = normals.Pixel(x, y);
      normal[0] = (at(x - 1, y) - at(x + 1, y)) / 2;
      normal[1] = (at(x, y + 1) - at(x, y - 1)) / 2;
      slope = std::max({slope, std::abs(normal[0]), std::abs(normal[1])});
    }
  }
  if (!(slope > 0)) slope = 1;
  for (std::size_t i = 0; i < normals.rgb.size(); i += 3) {
    normals.rgb[i] /= slope, normals.rgb[i + 1] /= slope, normals.rgb[i + 2] = 1;
  }
  return normals;
}

// Appends the levels of an image in which every channel is `value` of what it is, or its finest one
// alone, and returns how many these are.
template <class Value>
std::uint32_t AppendLevels(const CompactImage& finest, const Value& value, bool one_level,
                           std::uint32_t (*pack)(const float*), TextureTables& tables,
                           const std::string& path) {
  const auto append = [&](const CompactImage& image, const auto& channel) {
    if (tables.texels.size() + image.values() / 3 > kMaxTexels) {
      throw InputError(InputPosition::File(path),
                       fmt::format("the textures have more than {} texels", kMaxTexels));
    }
    tables.levels.push_back({std::uint32_t(tables.texels.size()), std::uint32_t(image.width),
                             std::uint32_t(image.height), 0});
    const std::size_t first = tables.texels.size(), width = std::size_t(image.width);
    tables.texels.resize(first + width * std::size_t(image.height));
    tbb::parallel_for(0, image.height, [&](int row) {
      std::uint32_t* const packed = &tables.texels[first + std::size_t(row) * width];
      std::vector<float> decoded;
      const float* const values = image.Row(row, decoded);
      for (std::size_t x = 0; x < width; ++x) {
        const float* const rgb = values + 3 * x;
        const float texel[3] = {channel(rgb[0]), channel(rgb[1]), channel(rgb[2])};
        packed[x] = pack(texel);
      }
    });
  };
  append(finest, value);
  if (one_level || (finest.width == 1 && finest.height == 1)) return 1;
  CompactImage image = HalfOf(finest, value);
  for (std::uint32_t count = 2;; ++count) {
    append(image, Itself);
    if (image.width == 1 && image.height == 1) return count;
    image = HalfOf(image, Itself);
  }
}

// Returns the number of texels of all levels of an image.
std::size_t TexelsOfLevels(const CompactImage& image, bool one_level) {
  std::size_t width = std::size_t(image.width), height = std::size_t(image.height);
  std::size_t texels = width * height;
  while (!one_level && width * height > 1) {
    width = std::max<std::size_t>(width / 2, 1), height = std::max<std::size_t>(height / 2, 1);
    texels += width * height;
  }
  return texels;
}

// The levels of a texture in the table.
struct Pyramid {
  std::uint32_t first, count;
  float slope;
};

Pyramid AppendPyramid(const CompactImage& image, const Texture& texture, TextureTables& tables,
                      const std::string& path) {
  Pyramid pyramid = {.first = std::uint32_t(tables.levels.size()), .count = 0, .slope = 1};
  const bool one_level = texture.one_level;
  switch (texture.use) {
    case TextureUse::kColor:
      pyramid.count = AppendLevels(image, Itself, one_level, PackTexel, tables, path);
      break;
    case TextureUse::kOpacity:
      pyramid.count =
          AppendLevels(Grey(image.Floats()), Itself, one_level, PackTexel, tables, path);
      break;
    case TextureUse::kNormals:
    case TextureUse::kPbrtNormals:
      pyramid.count = AppendLevels(image, Signed, one_level, PackNormalTexel, tables, path);
      break;
    case TextureUse::kHeights:
      pyramid.count = AppendLevels(NormalsOfHeights(image, texture, pyramid.slope), Itself,
                                   one_level, PackNormalTexel, tables, path);
      break;
  }
  return pyramid;
}

// The directions in which x of an image and its y (upwards) grow on a triangle with uvs; their
// lengths have a common factor.
struct TriangleAxes {
  glm::dvec3 x, y;
};
TriangleAxes ImageAxes(const Mesh& mesh, const glm::uvec3& corners, const Texture& texture) {
  glm::dvec2 place[3];
  const std::vector<glm::vec2>& uvs = mesh.UvsOf(texture.uv_set);
  for (int i = 0; i < 3; ++i) {
    place[i] = glm::dmat3x2(texture.transform) * glm::dvec3(uvs[corners[i]], 1);
    place[i].y = -place[i].y;
  }
  const glm::dvec3 a(mesh.positions[corners.x]);
  const glm::dvec3 e1 = glm::dvec3(mesh.positions[corners.y]) - a;
  const glm::dvec3 e2 = glm::dvec3(mesh.positions[corners.z]) - a;
  const glm::dvec2 d1 = place[1] - place[0], d2 = place[2] - place[0];
  const double area = d1.x * d2.y - d1.y * d2.x;
  return {(e1 * d2.y - e2 * d1.y) * area, (e2 * d1.x - e1 * d2.x) * area};
}

}  // namespace

Image HalfSize(const CompactImage& image) { return HalfOf(image, Itself); }

TextureView TextureTables::view() const {
  if (records.empty()) return {};
  const bool two_uv_sets = std::any_of(records.begin(), records.end(),
                                       [](const TextureRecord& r) { return r.first_uvs != 0; });
  return {.records = records.data(),
          .levels = levels.data(),
          .texels = texels.data(),
          .uvs = uvs.data(),
          .two_uv_sets = two_uv_sets};
}

std::size_t TextureTables::bytes() const {
  return records.size() * sizeof(TextureRecord) + levels.size() * sizeof(TextureLevel) +
         texels.size() * sizeof(std::uint32_t) + uvs.size() * sizeof(TriangleUvs);
}

TextureTables MakeTextureTables(const Scene& scene, const std::string& path) {
  TextureTables tables;
  // The pyramid of an image depends on its use and on how many levels it has; that of heights
  // depends on the wrapping, too.
  using Key = std::tuple<std::uint32_t, TextureUse, bool, TextureWrap, TextureWrap>;
  const auto key_of = [](const Texture& texture) -> Key {
    const bool heights = texture.use == TextureUse::kHeights;
    return {texture.image, texture.use, texture.one_level,
            heights ? texture.wrap_u : TextureWrap::kRepeat,
            heights ? texture.wrap_v : TextureWrap::kRepeat};
  };
  std::set<Key> kinds;
  std::size_t texels = 0;
  for (const Texture& texture : scene.textures) {
    if (texture.image >= scene.images.size()) {
      throw InputError(InputPosition::File(path), "a texture has no image");
    }
    if (!kinds.insert(key_of(texture)).second) continue;
    texels += TexelsOfLevels(scene.images[texture.image], texture.one_level);
  }
  tables.texels.reserve(std::min(texels, kMaxTexels));
  std::map<Key, Pyramid> pyramids;
  for (const Texture& texture : scene.textures) {
    const CompactImage& image = scene.images[texture.image];
    const Key key = key_of(texture);
    auto pyramid = pyramids.find(key);
    if (pyramid == pyramids.end()) {
      pyramid = pyramids.emplace(key, AppendPyramid(image, texture, tables, path)).first;
    }
    tables.slopes.push_back(pyramid->second.slope);
    TextureRecord record = {.first_level = pyramid->second.first,
                            .levels = pyramid->second.count,
                            .wrap_u = texture.wrap_u,
                            .wrap_v = texture.wrap_v,
                            .transform = {},
                            .texels = 0,
                            .first_uvs = 0,
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

TriangleSlopes MakeTriangleSlopes(const Mesh& mesh, const glm::uvec3& corners,
                                  const Texture& texture, int width, int height) {
  if (!mesh.tangents.empty() || mesh.UvsOf(texture.uv_set).empty()) return {};
  const auto [x, y] = ImageAxes(mesh, corners, texture);
  // These are the sides of a texel, up to a common factor. The second one has a part along the
  // first one, and one across it.
  const glm::dvec3 right = x / double(width), up = y / double(height);
  const double length = glm::length(right), part = glm::dot(up, right) / length;
  const double across = glm::length(glm::cross(right, up)) / length;
  const double stretch = std::sqrt(across / length), shear = -part / length / stretch;
  constexpr double kMost = 1e3;
  if (!(stretch < kMost && stretch > 1 / kMost && std::abs(shear) < kMost)) return {};
  return {.along = float(stretch), .across = float(1 / stretch), .shear = float(shear)};
}

TriangleTangents MakeTriangleTangents(const Mesh& mesh, const glm::uvec3& corners,
                                      const Texture& texture) {
  TriangleTangents record = {};
  const auto pack = [](const glm::dvec3& t) {
    const glm::dvec3 unit = glm::normalize(t);
    return EncodeNormal(float(unit.x), float(unit.y), float(unit.z));
  };
  if (!mesh.tangents.empty()) {
    bool usable = true;
    for (int i = 0; i < 3; ++i) {
      const glm::dvec3 tangent(mesh.tangents[corners[i]]);
      const double length = glm::length(tangent);
      usable = usable && std::isfinite(length) && length > 0;
      if (usable) record.tangent[i] = pack(tangent);
    }
    record.side = usable ? (mesh.tangents[corners.x].w < 0 ? -1.0f : 1.0f) : 0.0f;
    return record;
  }
  if (mesh.UvsOf(texture.uv_set).empty()) return record;
  const auto [x, y] = ImageAxes(mesh, corners, texture);
  const glm::dvec3 a(mesh.positions[corners.x]);
  const glm::dvec3 e1 = glm::dvec3(mesh.positions[corners.y]) - a;
  const glm::dvec3 e2 = glm::dvec3(mesh.positions[corners.z]) - a;
  glm::dvec3 outer = glm::cross(e1, e2);
  if (!mesh.normals.empty()) {
    outer = glm::dvec3(mesh.normals[corners.x]) + glm::dvec3(mesh.normals[corners.y]) +
            glm::dvec3(mesh.normals[corners.z]);
  }
  const double side = glm::dot(glm::cross(outer, x), y);
  if (!(glm::length(x) > 0) || !std::isfinite(glm::length(x)) || !(std::abs(side) > 0)) {
    return record;
  }
  std::fill_n(record.tangent, 3, pack(x));
  record.side = side < 0 && texture.use != TextureUse::kPbrtNormals ? -1.0f : 1.0f;
  return record;
}

TriangleUvs MakeTriangleUvs(const Mesh& mesh, UvSet set, const glm::uvec3& corners) {
  TriangleUvs record = {};
  const std::vector<glm::vec2>& uvs = mesh.UvsOf(set);
  if (uvs.empty()) return record;
  for (int i = 0; i < 3; ++i) {
    for (int axis = 0; axis < 2; ++axis) {
      const float value = uvs[corners[i]][axis];
      // In this order min and max turn NaN into a number.
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

void AppendSecondUvs(std::span<const TriangleUvs> uvs, std::span<const Texture> textures,
                     TextureTables& tables) {
  for (std::size_t i = 0; i < textures.size(); ++i) {
    if (textures[i].uv_set != UvSet::kSecond) continue;
    tables.records[i].first_uvs = std::uint32_t(tables.uvs.size());
  }
  tables.uvs.insert(tables.uvs.end(), uvs.begin(), uvs.end());
}

}  // namespace skywave
