// Tests the spaces of red, green and blue: their matrices, and what files say of them.
#include <gtest/gtest.h>

#include <string>

#include "image/primaries.h"
#include "tests/support/temporary_folder.h"

namespace skywave {
namespace {

// Rows of ITU-R BT.2087 (table of M2) and of the Academy's transform of Rec. 709 to AP1, with
// Bradford's adaptation from D65 to the white of ACES.
constexpr double kToRec2020[3][3] = {
    {0.6274, 0.3293, 0.0433}, {0.0691, 0.9195, 0.0114}, {0.0164, 0.0880, 0.8956}};
constexpr double kToAcescg[3][3] = {
    {0.613097, 0.339523, 0.047379}, {0.070194, 0.916354, 0.013452}, {0.020616, 0.109570, 0.869815}};

void ExpectMatrix(RgbSpace space, const double (&rows)[3][3]) {
  const glm::dmat3 matrix = FromRec709(space);
  for (int row = 0; row < 3; ++row) {
    for (int column = 0; column < 3; ++column) {
      EXPECT_NEAR(matrix[column][row], rows[row][column], 1e-4) << row << " " << column;
    }
  }
}

TEST(RgbSpace, MatricesArePublishedOnes) {
  ExpectMatrix(RgbSpace::kRec2020, kToRec2020);
  ExpectMatrix(RgbSpace::kAcescg, kToAcescg);
  EXPECT_EQ(FromRec709(RgbSpace::kRec709), glm::dmat3(1));
}

TEST(RgbSpace, WhiteIsWhiteInAll) {
  for (const Named<RgbSpace>& named : kEnumNames<RgbSpace>) {
    const glm::dvec3 white = FromRec709(named.value) * glm::dvec3(1);
    for (int c = 0; c < 3; ++c) EXPECT_NEAR(white[c], 1, 1e-9) << named.name;
    EXPECT_EQ(SpaceOf(PrimariesOf(named.value)), named.value);
  }
}

Image Colors() {
  Image image(2, 1);
  image.rgb = {0.25f, 0.5f, 4, 1, 0.125f, 0.0625f};
  return image;
}

TEST(RgbSpace, FilesSayTheirsAndAreReadAsRec709) {
  const TemporaryFolder folder;
  for (const Named<RgbSpace>& named : kEnumNames<RgbSpace>) {
    Image stored = Colors();
    ConvertColors(FromRec709(named.value), stored);
    const std::string path = folder.Path(std::string(named.name) + ".exr");
    WriteExr(path, stored, {}, {{"albedo.R", {0.5f, 0.25f}}}, {.space = named.value});

    const LayeredImage own = ReadOwnColors(path, {"albedo.R"});
    EXPECT_EQ(own.space, named.value);
    EXPECT_EQ(own.image.rgb, stored.rgb);
    EXPECT_EQ(own.layers[0].values, (std::vector<float>{0.5f, 0.25f}));

    const Image read = ReadImage(path), expected = Colors();
    for (std::size_t i = 0; i < read.rgb.size(); ++i) {
      EXPECT_NEAR(read.rgb[i], expected.rgb[i], 1e-5f) << named.name << " " << i;
    }
    EXPECT_EQ(ReadDataWindow(path).space, RgbSpace::kRec709);
    std::string id;
    for (const auto& [name, text] : ReadExrMetadata(path)) {
      if (name == "colorInteropID") id = text;
    }
    EXPECT_EQ(id, InteropId(named.value));
  }
}

// Other primaries than those of the spaces become Rec. 709, whoever reads.
TEST(RgbSpace, OnlyOwnColorsStay) {
  const Image image = Colors();
  EXPECT_EQ(static_cast<const Image&>(InRec709(image, RgbSpace::kRec709)).rgb, image.rgb);
  Image wide = Colors();
  ConvertColors(FromRec709(RgbSpace::kAcescg), wide);
  const InRec709 back(wide, RgbSpace::kAcescg);
  const Image& same = back;
  for (std::size_t i = 0; i < same.rgb.size(); ++i) EXPECT_NEAR(same.rgb[i], image.rgb[i], 1e-5f);
}

}  // namespace
}  // namespace skywave
