// Tests skywave compare from the outside.
#include <gtest/gtest.h>

#include <nlohmann/json.hpp>
#include <string>
#include <vector>

#include "base/error.h"
#include "image/image.h"
#include "tests/support/made_image.h"
#include "tests/support/program.h"

namespace skywave {
namespace {

Image Picture() {
  return MadeImage(8, 4, [](int x, int y) {
    const int i = 3 * (8 * y + x);
    return glm::vec3(1 + i % 5, 1 + (i + 1) % 5, 1 + (i + 2) % 5);
  });
}

class CompareCli : public Program {
 protected:
  void SetUp() override {
    Program::SetUp();
    WriteExr(Path("map.exr"), Picture());
  }
};

TEST_F(CompareCli, EqualPicturesHaveNoError) {
  const Result result = Run("compare map.exr map.exr --json c.json --map d.png");
  EXPECT_EQ(result.exit_code, 0);
  const auto json = nlohmann::json::parse(Bytes("c.json"));
  for (const char* const key : {"mse", "rmse", "relative_mse", "mean_absolute",
                                "squared_channel_sum", "thesis_luminance", "max_absolute"}) {
    EXPECT_EQ(json.at(key).get<double>(), 0) << key;
    EXPECT_NE(result.out.find(key), std::string::npos) << key;
  }
  EXPECT_EQ(json.at("different_pixels"), 0);
  EXPECT_TRUE(Files().contains("d.png"));
}

TEST_F(CompareCli, ADifferenceIsFound) {
  Image other = Picture();
  other.Pixel(3, 2)[1] += 0.5f;
  WriteExr(Path("other.exr"), other);
  ASSERT_EQ(Run("compare other.exr map.exr --json c.json").exit_code, 0);
  const auto json = nlohmann::json::parse(Bytes("c.json"));
  EXPECT_EQ(json.at("max_absolute").get<double>(), 0.5);
  EXPECT_EQ(json.at("max_at"), nlohmann::json({3, 2}));
  EXPECT_EQ(json.at("different_pixels"), 1);
  EXPECT_NEAR(json.at("mse").get<double>(), 0.25 / 3 / 32, 1e-9);
}

// Writes the pixels of Picture() from (x, y) on, which say where they lie.
void WritePart(const std::string& path, int x, int y, int width, int height,
               const std::vector<NamedChannel>& layers = {}) {
  const Image whole = Picture();
  const Image part = MadeImage(width, height, [&](int i, int j) {
    const float* const rgb = whole.Pixel(x + i, y + j);
    return glm::vec3(rgb[0], rgb[1], rgb[2]);
  });
  WriteExr(path, part, {}, layers, {.placement = {x, y, whole.width, whole.height}});
}

TEST_F(CompareCli, PartsAreComparedWhereBothHavePixels) {
  WritePart(Path("left.exr"), 1, 0, 5, 3);
  WritePart(Path("right.exr"), 3, 1, 5, 3);
  const Result parts = Run("compare left.exr right.exr --json c.json --map d.png");
  ASSERT_EQ(parts.exit_code, 0) << parts.err;
  auto json = nlohmann::json::parse(Bytes("c.json"));
  EXPECT_EQ(json.at("different_pixels"), 0);
  EXPECT_EQ(json.at("window"), nlohmann::json({3, 1, 3, 2}));
  EXPECT_NE(parts.out.find("3x2+3+1"), std::string::npos) << parts.out;
  EXPECT_EQ(ReadTexture(Path("d.png"), Encoding::kSrgb).width, 3);
  // A shifted part is another one, though it has the same bytes of pixels.
  const Image left = ReadDataWindow(Path("left.exr")).image;
  WriteExr(Path("shifted.exr"), left, {}, {}, {.placement = {2, 1, 8, 4}});
  ASSERT_EQ(Run("compare left.exr shifted.exr --json c.json").exit_code, 0);
  json = nlohmann::json::parse(Bytes("c.json"));
  EXPECT_GT(json.at("different_pixels"), 0);
  EXPECT_GE(json.at("max_at")[0], 2) << "places are those of the whole picture";
  // A PNG of the part says nothing of its place; a picture of another size does not fit.
  WriteImage(Path("left.pfm"), left);
  ASSERT_EQ(Run("compare left.pfm left.exr --json c.json").exit_code, 0);
  EXPECT_EQ(nlohmann::json::parse(Bytes("c.json")).at("different_pixels"), 0);
  WritePart(Path("corner.exr"), 0, 3, 1, 1);
  const Result apart = Run("compare corner.exr left.exr");
  EXPECT_EQ(apart.exit_code, kExitBadInput);
  EXPECT_NE(apart.err.find("corner.exr"), std::string::npos) << apart.err;
  WriteExr(Path("small.exr"), Image(5, 4));
  EXPECT_EQ(Run("compare small.exr left.exr").exit_code, kExitBadInput);
}

// The noise of a part is cut as its pixels are.
TEST_F(CompareCli, NoiseIsThatOfThePixelsThatAreCompared) {
  const std::vector<float> few(15, 4.0f);
  std::vector<float> variance(15, 0.0f);
  variance[5 * 1 + 2] = 1;  // pixel (3, 1) of the picture
  std::vector<NamedChannel> layers = {{"samples.V", few}};
  for (const char letter : {'R', 'G', 'B'}) {
    layers.push_back({std::string("variance.") + letter, variance});
  }
  WritePart(Path("left.exr"), 1, 0, 5, 3, layers);
  WritePart(Path("right.exr"), 3, 1, 5, 3);
  ASSERT_EQ(Run("compare left.exr right.exr --json c.json").exit_code, 0);
  EXPECT_EQ(nlohmann::json::parse(Bytes("c.json")).at("noise").at("values"), 3);
}

// What a file says of noise is that of its picture, not that of a layer.
TEST_F(CompareCli, ALayerCountsAsExact) {
  const std::vector<float> few(32, 4.0f), ones(32, 1.0f);
  std::vector<NamedChannel> layers = {{"samples.V", few}};
  for (const char letter : {'R', 'G', 'B'}) {
    layers.push_back({std::string("variance.") + letter, ones});
    layers.push_back({std::string("albedo.") + letter, ones});
  }
  WritePart(Path("noisy.exr"), 0, 0, 8, 4, layers);
  ASSERT_EQ(Run("compare noisy.exr noisy.exr --json c.json").exit_code, 0);
  EXPECT_TRUE(nlohmann::json::parse(Bytes("c.json")).contains("noise"));
  ASSERT_EQ(Run("compare noisy.exr:albedo noisy.exr:albedo --json c.json").exit_code, 0);
  EXPECT_FALSE(nlohmann::json::parse(Bytes("c.json")).contains("noise"));
}

// The map shows an error of `full-scale` in the brightest colour, and smaller ones in darker
// colours.
TEST_F(CompareCli, TheFullScaleOfAnErrorMapIsItsBrightestColour) {
  const Image reference = MadeImage(8, 4, [](int, int) { return glm::vec3(1); });
  Image other = reference;
  for (int c = 0; c < 3; ++c) other.Pixel(3, 2)[c] += 0.25f;
  WriteExr(Path("other.exr"), other);
  WriteExr(Path("reference.exr"), reference);
  const auto brightest = [&](const std::string& scale) {
    EXPECT_EQ(Run("compare other.exr reference.exr --map e.png --full-scale " + scale).exit_code,
              0);
    const Image map = DecodeTexture("e.png", Bytes("e.png"), Encoding::kLinear);
    return Luminance(map.Pixel(3, 2));
  };
  const double full = brightest("0.2");
  EXPECT_NEAR(full, 0.2126 * 0.99 + 0.7152 * 0.99 + 0.0722 * 0.65, 0.01);
  EXPECT_NEAR(brightest("0.1"), full, 1e-6);
  EXPECT_LT(brightest("0.5"), 0.6 * full);
  EXPECT_LT(brightest("100"), 0.05 * full);
}

}  // namespace
}  // namespace skywave
