// Compares texture lookups with a double reference that shares only the records with the kernel,
// and tests the tables that they read.

#include "kernels/surface/texture.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <bit>
#include <cmath>
#include <initializer_list>
#include <iterator>
#include <limits>
#include <tuple>

#include "kernels/surface/layers.h"
#include "kernels/surface/surface.h"
#include "scene/materials/texture_tables.h"
#include "tests/support/oracle_texture.h"
#include "tests/support/random_rows.h"
#include "tests/support/shading_rows.h"
#include "tests/support/targets.h"

namespace skywave {
namespace {

// Returns the value of a packed texel by its definition.
std::array<double, 3> Unpack(std::uint32_t packed) {
  const double scale = std::ldexp(1.0, int(packed >> 27) - 31);
  return {(packed & 511) * scale, (packed >> 9 & 511) * scale, (packed >> 18 & 511) * scale};
}

TEST(PackTexel, IsOffByAtMostA512thOfTheBrightestChannel) {
  Random random(61);
  for (int i = 0; i < 20000; ++i) {
    const double scale = std::exp2(random.Between(-20, 8));
    const float rgb[3] = {float(scale * random.Float()), float(scale * random.Float()),
                          float(scale * random.Float())};
    const double brightest = std::max({rgb[0], rgb[1], rgb[2]});
    const auto back = Unpack(PackTexel(rgb));
    for (int c = 0; c < 3; ++c) ASSERT_NEAR(back[c], rgb[c], brightest / 512) << i;
  }
}

TEST(PackTexel, KeepsWhatItCanHold) {
  const auto back = [](float r, float g, float b) {
    const float rgb[3] = {r, g, b};
    return Unpack(PackTexel(rgb));
  };
  EXPECT_EQ(back(1, 0.5f, 0), (std::array<double, 3>{1, 0.5, 0}));
  EXPECT_EQ(back(511, 256, 1), (std::array<double, 3>{511, 256, 1}));
  EXPECT_EQ(back(0, 0, 0), (std::array<double, 3>{0, 0, 0}));
  EXPECT_EQ(back(-1, NAN, 1e30f), (std::array<double, 3>{0, 0, 511}));
  EXPECT_EQ(back(0.9999f, 0, 0)[0], 1) << "rounded up to the next exponent";
  EXPECT_EQ(back(0, 1e-30f, 0)[1], 0);
}

TEST(HalfSize, IsTheMeanOverTheArea) {
  Random random(62);
  for (const auto& [width, height] : {std::pair{8, 4}, {7, 5}, {3, 2}, {1, 9}, {1, 1}, {2, 1}}) {
    Image image(width, height);
    double mean = 0;
    for (float& value : image.rgb) mean += value = random.Float();
    const Image half = HalfSize(image);
    EXPECT_EQ(half.width, std::max(width / 2, 1));
    EXPECT_EQ(half.height, std::max(height / 2, 1));
    double half_mean = 0;
    for (const float value : half.rgb) half_mean += value;
    EXPECT_NEAR(half_mean / half.rgb.size(), mean / image.rgb.size(), 1e-6)
        << width << " x " << height;
  }
  // Three texels become one and a half: the middle one counts for both.
  Image line(3, 1);
  line.rgb = {0, 0, 0, 1, 1, 1, 4, 4, 4};
  EXPECT_NEAR(HalfSize(line).rgb[0], 5.0 / 3, 1e-6);
  Image five(5, 1);
  for (int i = 0; i < 15; ++i) five.rgb[i] = float(i / 3);
  EXPECT_NEAR(HalfSize(five).rgb[0], (0 + 1 + 0.5 * 2) / 2.5, 1e-6);
}

// Images of several sizes, with all wrap modes and random transforms, on random triangles at random
// distances.
class TextureRows : public testing::Test {
 protected:
  static constexpr std::uint32_t kTextures = 9, kTriangles = 300;
  static constexpr float kAngle = 0.002f;

  TextureRows() : surfaces_(kFullWave), materials_(kTextures + 1) {
    Random random(63);
    for (const auto& [width, height] : {std::pair{16, 16}, {7, 3}, {1, 5}, {64, 9}}) {
      Image image(width, height);
      for (float& value : image.rgb) value = random.Float();
      scene_.images.push_back(std::move(image));
    }
    const auto between = [&](double low, double high) { return float(random.Between(low, high)); };
    for (std::uint32_t i = 0; i < kTextures; ++i) {
      Texture texture = {
          .image = i % 4, .wrap_u = TextureWrap(i % 3), .wrap_v = TextureWrap(i / 3)};
      // Others have all levels of the same image.
      texture.one_level = i == kTextures - 1;
      texture.uv_set = UvSet(i / 2 % 2);
      texture.transform = {between(-2, 2), between(-1, 1), between(-1, 1),
                           between(-2, 2), between(-3, 3), between(-3, 3)};
      scene_.textures.push_back(texture);
      materials_[i + 1].color_texture = i + 1;
      materials_[i + 1].roughness_texture = (i + 4) % kTextures + 1;
      materials_[i + 1].alpha = 0.9f, materials_[i + 1].eta[0] = 0.8f;
    }
    materials_[0].alpha = 0.3f, materials_[0].eta[0] = 0.6f;
    for (std::uint32_t i = 0; i < kTriangles; ++i) {
      tangents_.push_back(i % 3 == 0 ? kMirroredTangent : 0);
    }
    for (std::vector<TriangleUvs>& set : uvs_) {
      for (std::uint32_t i = 0; i < kTriangles; ++i) {
        TriangleUvs uvs = {};
        for (auto& corner : uvs.uv) corner[0] = between(-2, 3), corner[1] = between(-2, 3);
        uvs.density = between(0.1, 3);
        set.push_back(uvs);
      }
    }
    MakeTables();
    const SurfaceColumns& s = surfaces_;
    FillWithGarbage(s, kFullWave);
    for (std::uint32_t i = 0; i < kFullWave; ++i) {
      s.u[i] = between(0, 1), s.v[i] = between(0, 1 - s.u[i]);
      s.t[i] = float(std::pow(10, random.Between(-1, 4)));
      const Vec ng = random.Direction();
      Put(ng, i, s.ng_x, s.ng_y, s.ng_z);
      Put(random.DirectionAbout(ng), i, s.wo_x, s.wo_y, s.wo_z);
      s.triangle[i] = random.Word() % kTriangles;
      s.material[i] = random.Word() % (kTextures + 1) | (i % 2 == 0 ? kBackFace : 0);
      s.color_r[i] = 0.9f, s.color_g[i] = 0.5f, s.color_b[i] = 0.2f;
    }
  }

  void MakeTables() {
    tables_ = MakeTextureTables(scene_, "test");
    tables_.uvs = uvs_[0];
    AppendSecondUvs(uvs_[1], scene_.textures, tables_);
  }

  // Returns what row i sees in a texture, in double. `certain` becomes false if rounding may affect
  // the level.
  glm::dvec3 Reference(std::uint32_t i, std::uint32_t index, bool& certain) const {
    const SurfaceColumns& s = surfaces_;
    const TriangleUvs& t = uvs_[std::size_t(scene_.textures[index].uv_set)][s.triangle[i]];
    const double b1 = s.u[i], b2 = s.v[i], b0 = 1 - b1 - b2;
    const glm::dvec2 uv(b0 * t.uv[0][0] + b1 * t.uv[1][0] + b2 * t.uv[2][0],
                        b0 * t.uv[0][1] + b1 * t.uv[1][1] + b2 * t.uv[2][1]);
    const Texture& texture = scene_.textures[index];
    const CompactImage& image = scene_.images[texture.image];
    const glm::dmat3x2 m(texture.transform);
    const double scale =
        std::sqrt(std::abs(m[0][0] * m[1][1] - m[1][0] * m[0][1]) * image.width * image.height);
    const double cosine =
        std::max(0.01, Dot(Get(i, s.ng_x, s.ng_y, s.ng_z), Get(i, s.wo_x, s.wo_y, s.wo_z)));
    const double texels = s.t[i] * kAngle * t.density * scale / std::sqrt(cosine);
    const double wanted = texture.one_level ? 0 : std::max(0.0, std::log2(texels));
    certain = wanted == 0 || std::abs(wanted - std::round(wanted)) > 1e-4;
    // The pyramid is rebuilt here.
    Image level = image.Floats();
    for (int k = 0; k < int(wanted) && (level.width > 1 || level.height > 1); ++k) {
      level = HalfSize(level);
    }
    for (std::size_t k = 0; k < level.rgb.size(); k += 3) {
      const auto texel = Unpack(PackTexel(&level.rgb[k]));
      for (std::size_t c = 0; c < 3; ++c) level.rgb[k + c] = float(texel[c]);
    }
    return Bilinear(level, m * glm::dvec3(uv, 1) * glm::dvec2(level.width, level.height),
                    texture.wrap_u, texture.wrap_v);
  }

  Scene scene_;
  soa::Table<SurfaceColumns> surfaces_;
  std::vector<MaterialRecord> materials_;
  std::vector<TriangleUvs> uvs_[2];  // by set and triangle
  std::vector<std::uint32_t> tangents_;
  TextureTables tables_;
};

TEST_F(TextureRows, ColorsAreMultipliedByWhatTheReferenceSees) {
  const SurfaceColumns& s = surfaces_;
  TextureColors(tables_.view(), materials_.data(), kAngle, kFullWave, s);
  std::uint32_t compared = 0;
  for (std::uint32_t i = 0; i < kFullWave; ++i) {
    const std::uint32_t material = s.material[i] & kMaterialMask;
    glm::dvec3 seen(1);
    bool certain = true;
    if (material != 0) seen = Reference(i, material - 1, certain);
    if (!certain) continue;
    ++compared;
    // An ulp of a coordinate of 20 is 1e-4 of a texel of 64.
    ASSERT_NEAR(s.color_r[i], 0.9 * seen.x, 5e-4) << "row " << i;
    ASSERT_NEAR(s.color_g[i], 0.5 * seen.y, 5e-4) << "row " << i;
    ASSERT_NEAR(s.color_b[i], 0.2 * seen.z, 5e-4) << "row " << i;
  }
  EXPECT_GT(compared, kFullWave * 9 / 10);
}

TEST_F(TextureRows, RoughnessIsGreenAndMetallicBlue) {
  const SurfaceColumns& s = surfaces_;
  PrepareMetallicRoughness(tables_.view(), materials_.data(), kAngle, kFullWave, s);
  for (std::uint32_t i = 0; i < kFullWave; ++i) {
    const std::uint32_t material = s.material[i] & kMaterialMask;
    if (material == 0) {
      ASSERT_EQ(s.varying_0[i], 0.3f);
      ASSERT_EQ(s.varying_1[i], 0.6f);
      continue;
    }
    bool certain = true;
    const glm::dvec3 seen = Reference(i, (material + 3) % kTextures, certain);
    if (!certain) continue;
    ASSERT_NEAR(s.varying_0[i], std::max(1e-3, 0.9 * seen.y * seen.y), 1e-3) << "row " << i;
    ASSERT_NEAR(s.varying_1[i], 0.8 * seen.z, 5e-4) << "row " << i;
  }
  PrepareMetallicRoughness({}, materials_.data(), kAngle, kFullWave, s);
  for (std::uint32_t i = 0; i < kFullWave; ++i) {
    ASSERT_EQ(s.varying_0[i], materials_[s.material[i] & kMaterialMask].alpha);
    ASSERT_EQ(s.varying_1[i], materials_[s.material[i] & kMaterialMask].eta[0]);
  }
}

TEST_F(TextureRows, WidthsOfMetalsAreGreenAndThoseOfTheirCoatsRed) {
  const SurfaceColumns& s = surfaces_;
  materials_[0].multiscatter[1] = 0.2f;
  for (std::uint32_t i = 1; i <= kTextures; ++i) materials_[i].multiscatter[1] = 0.7f;
  PrepareCoatWidths(tables_.view(), materials_.data(), kAngle, kFullWave, s);
  for (std::uint32_t i = 0; i < kFullWave; ++i) {
    const std::uint32_t material = s.material[i] & kMaterialMask;
    if (material == 0) {
      ASSERT_EQ(s.varying_0[i], 0.3f);
      ASSERT_EQ(s.varying_1[i], 0.2f);
      continue;
    }
    bool certain = true;
    const glm::dvec3 seen = Reference(i, (material + 3) % kTextures, certain);
    if (!certain) continue;
    ASSERT_NEAR(s.varying_0[i], std::max(1e-3, 0.9 * seen.y * seen.y), 1e-3) << "row " << i;
    ASSERT_NEAR(s.varying_1[i], std::max(1e-3, 0.7 * seen.x * seen.x), 1e-3) << "row " << i;
  }
}

// Every texture of the layers stands in its byte (kernels/surface/layers-inl.h); without textures
// all of them are 1.
TEST_F(TextureRows, LayersAreTheirBytes) {
  const SurfaceColumns& s = surfaces_;
  for (std::uint32_t i = 1; i <= kTextures; ++i) {
    MaterialRecord& m = materials_[i];
    std::uint32_t* const textures[] = {&m.sheen_texture,          &m.sheen_alpha_texture,
                                       &m.coat_alpha_texture,     &m.specular_texture,
                                       &m.specular_color_texture, &m.film_texture,
                                       &m.film_thickness_texture};
    for (std::uint32_t k = 0; k < std::size(textures); ++k) {
      *textures[k] = (i + k) % kTextures + 1;
    }
  }
  PrepareLayers(tables_.view(), materials_.data(), nullptr, kAngle, kFullWave, s);
  std::uint32_t compared = 0;
  for (std::uint32_t i = 0; i < kFullWave; ++i) {
    const float* const columns[] = {s.varying_0, s.varying_1, s.varying_2, s.varying_3};
    const auto held = [&](std::size_t column, int byte) {
      return (std::bit_cast<std::uint32_t>(columns[column][i]) >> (8 * byte) & 255) / 255.0;
    };
    const std::uint32_t material = s.material[i] & kMaterialMask;
    bool certain = true;
    const auto seen = [&](std::uint32_t shift) {
      return material == 0 ? glm::dvec3(1) : Reference(i, (material + shift) % kTextures, certain);
    };
    const glm::dvec3 base = seen(3), sheen = glm::sqrt(seen(0)), color = glm::sqrt(seen(4));
    // Where a column and a byte hold what.
    const std::tuple<std::size_t, int, double> bytes[] = {
        {0, 0, base.y},    {0, 1, base.z},    {0, 2, seen(2).y}, {0, 3, seen(1).y}, {1, 0, sheen.x},
        {1, 1, sheen.y},   {1, 2, sheen.z},   {2, 0, color.x},   {2, 1, color.y},   {2, 2, color.z},
        {2, 3, seen(3).y}, {3, 0, seen(5).y}, {3, 1, seen(6).y}, {3, 2, 1}};
    if (!certain) continue;
    ++compared;
    for (const auto& [column, byte, value] : bytes) {
      ASSERT_NEAR(held(column, byte), value, 0.003) << "row " << i << ", " << column << byte;
    }
  }
  EXPECT_GT(compared, kFullWave / 2);
}

// The grain is the tangent, turned by the material and by the image, as seen from the side of the
// mesh's normals, or the other way round where a triangle mirrors images.
TEST_F(TextureRows, GrainsTurnCounterClockwise) {
  const SurfaceColumns& s = surfaces_;
  Image image(1, 1);
  image.rgb = {0.5f + 0.5f * float(std::cos(0.4)), 0.5f + 0.5f * float(std::sin(0.4)), 0.6f};
  scene_.images.push_back(image);
  for (Texture& texture : scene_.textures) texture.image = std::uint32_t(scene_.images.size() - 1);
  MakeTables();
  for (std::uint32_t i = 1; i <= kTextures; ++i) {
    materials_[i].anisotropy_texture = i;
    materials_[i].grain[0] = float(0.8 * std::cos(0.9)),
    materials_[i].grain[1] = float(0.8 * std::sin(0.9));
  }
  for (std::uint32_t i = 0; i < kFullWave; ++i) {
    s.varying_0[i] = float(std::cos(0.2)), s.varying_1[i] = float(std::sin(0.2));
  }
  PrepareLayers(tables_.view(), materials_.data(), tangents_.data(), kAngle, kFullWave, s);
  for (std::uint32_t i = 0; i < kFullWave; ++i) {
    if ((s.material[i] & kMaterialMask) == 0) continue;
    const auto v1 = std::bit_cast<std::uint32_t>(s.varying_1[i]),
               v3 = std::bit_cast<std::uint32_t>(s.varying_3[i]);
    ASSERT_NEAR((v3 >> 16 & 255) / 255.0, 0.6, 0.003);
    const bool back = (s.material[i] & kBackFace) != 0;
    const std::uint32_t turn = v1 >> 24 | v3 >> 24 << 8;
    // From behind, the tangent's angle in the frame is the opposite one.
    const bool mirrored = tangents_[s.triangle[i]] == kMirroredTangent;
    const double angle = (back ? -0.2 : 0.2) + (mirrored ? -1 : 1) * (0.4 + 0.9);
    const double expected = HeldTurn(angle);
    const double share =
        (1 + std::sin(expected) / (std::fabs(std::cos(expected)) + std::fabs(std::sin(expected)))) /
        2;
    ASSERT_NEAR(turn / 65535.0, share, 0.003) << back << mirrored;
  }
}

TEST_F(TextureRows, BitsDoNotDependOnTargetOrNumberOfRows) {
  const auto texture_rows = [&](std::uint32_t n) {
    const SurfaceColumns& s = surfaces_;
    std::fill_n(s.color_r, kFullWave, 0.9f), std::fill_n(s.color_g, kFullWave, 0.5f);
    std::fill_n(s.color_b, kFullWave, 0.2f);
    std::fill_n(s.varying_0, kFullWave, -1.0f), std::fill_n(s.varying_1, kFullWave, -1.0f);
    TextureColors(tables_.view(), materials_.data(), kAngle, n, s);
    PrepareMetallicRoughness(tables_.view(), materials_.data(), kAngle, n, s);
    std::vector<float> values;
    const auto keep = [&](std::initializer_list<const float*> columns) {
      for (const float* column : columns) values.insert(values.end(), column, column + kFullWave);
    };
    keep({s.color_r, s.color_g, s.color_b, s.varying_0, s.varying_1});
    for (float* column : {s.varying_0, s.varying_1, s.varying_2, s.varying_3}) {
      std::fill_n(column, kFullWave, 0.25f);
    }
    PrepareLayers(tables_.view(), materials_.data(), tangents_.data(), kAngle, n, s);
    // Words may be those of NaN, which equal nothing.
    for (float* column : {s.varying_0, s.varying_1, s.varying_2, s.varying_3}) {
      for (std::uint32_t i = 0; i < kFullWave; ++i) {
        const auto word = std::bit_cast<std::uint32_t>(column[i]);
        values.push_back(float(word >> 16)), values.push_back(float(word & 0xFFFF));
      }
    }
    return values;
  };
  const std::vector<float> all = texture_rows(kFullWave);
  ForEachTarget([&] {
    for (const std::uint32_t n : kRowCounts) {
      const std::vector<float> some = texture_rows(n);
      for (std::uint32_t i = 0; i < kFullWave; ++i) {
        for (std::uint32_t c = 0; c < 5; ++c) {
          const std::uint32_t at = c * kFullWave + i;
          const float untouched = c >= 3 ? -1.0f : c == 0 ? 0.9f : c == 1 ? 0.5f : 0.2f;
          ASSERT_EQ(some[at], i < n ? all[at] : untouched) << n << " rows, row " << i;
        }
      }
    }
  });
}

// Rows after the last one may hold leftovers of other stages, which are not valid positions on an
// image.
TEST_F(TextureRows, RowsAfterTheLastAreNotLookedUp) {
  constexpr std::uint32_t kRows = 3;
  const SurfaceColumns& s = surfaces_;
  for (std::uint32_t i = 0; i < kFullWave; ++i) s.material[i] = 1;
  const auto colors = [&] {
    std::fill_n(s.color_r, kFullWave, 0.9f);
    TextureColors(tables_.view(), materials_.data(), kAngle, kRows, s);
    return std::vector<float>(s.color_r, s.color_r + kRows);
  };
  ForEachTarget([&] {
    const std::vector<float> expected = colors();
    for (const float left : {1e9f, -1e9f, 1e30f, -1e30f, std::numeric_limits<float>::infinity(),
                             std::numeric_limits<float>::quiet_NaN()}) {
      std::fill_n(s.u + kRows, kFullWave - kRows, left);
      std::fill_n(s.v + kRows, kFullWave - kRows, left);
      EXPECT_EQ(colors(), expected) << left;
    }
  });
}

TEST_F(TextureRows, ColoursOfVerticesAreInterpolated) {
  const SurfaceColumns& s = surfaces_;
  Random random(64);
  std::vector<std::uint32_t> colors;
  for (std::uint32_t i = 0; i < 3 * kTriangles; ++i) {
    const float rgb[3] = {random.Float(), random.Float(), random.Float()};
    colors.push_back(PackTexel(rgb));
  }
  ForEachTarget([&] {
    for (const std::uint32_t n : kRowCounts) {
      std::fill_n(s.color_r, kFullWave, 0.9f), std::fill_n(s.color_g, kFullWave, 0.5f);
      TintByVertices(colors.data(), n, s);
      for (std::uint32_t i = 0; i < kFullWave; ++i) {
        double red = 1, green = 1;
        if (i < n) {
          const std::uint32_t* corner = &colors[3 * s.triangle[i]];
          const double b[3] = {1.0 - s.u[i] - s.v[i], s.u[i], s.v[i]};
          red = green = 0;
          for (int c = 0; c < 3; ++c) {
            red += b[c] * double(Unpack(corner[c])[0]),
                green += b[c] * double(Unpack(corner[c])[1]);
          }
        }
        // The tolerance covers the rounding of three products and sums of numbers below 1.
        ASSERT_NEAR(s.color_r[i], 0.9f * red, 5e-7) << n << " rows, row " << i;
        ASSERT_NEAR(s.color_g[i], 0.5f * green, 5e-7) << n << " rows, row " << i;
      }
    }
  });
}

}  // namespace
}  // namespace skywave
