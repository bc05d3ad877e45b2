// Tests the conversion of a picture to 8 bits: repair, tone mapping and PNG.

#include <png.h>

#include <algorithm>
#include <cmath>
#include <limits>

#include "base/error.h"
#include "tests/support/image_test_files.h"

namespace skywave {
namespace {

constexpr float kInf = std::numeric_limits<float>::infinity();
constexpr float kNan = std::numeric_limits<float>::quiet_NaN();

Image Grey(const std::vector<float>& values) {
  Image image(int(values.size()), 1);
  for (std::size_t i = 0; i < image.rgb.size(); ++i) image.rgb[i] = values[i / 3];
  return image;
}

// Returns the bytes of one channel after checking that all three are equal.
std::vector<int> MapGrey(const std::vector<float>& values, const ToneMapping& mapping) {
  const std::vector<std::uint8_t> rgb = ToneMap(Grey(values), mapping);
  std::vector<int> grey;
  for (std::size_t i = 0; i < rgb.size(); i += 3) {
    EXPECT_EQ(rgb[i], rgb[i + 1]);
    EXPECT_EQ(rgb[i], rgb[i + 2]);
    grey.push_back(rgb[i]);
  }
  return grey;
}

Image SixColors() {
  Image colors(3, 2);
  colors.rgb = {.1f, .5f, .9f, .8f, .3f, .05f, .05f, .6f, .2f,
                .4f, .1f, .7f, 3,   .2f, .1f,  .6f,  .2f, .3f};
  return colors;
}

TEST(RepairRadiance, CountsPixelsByTheirWorstChannel) {
  Image image(6, 1);
  image.rgb = {kNan, kInf, -1, 1, -kInf, -1, 2, -0.5f, 3, 4, 5, 6, -0.0f, 0, 0, 1, 2, kNan};
  const BadPixels bad = RepairRadiance(image);
  EXPECT_EQ(bad.nan, 2u);
  EXPECT_EQ(bad.infinite, 1u);
  EXPECT_EQ(bad.negative, 1u);
  EXPECT_EQ(bad.total(), 4u);
  EXPECT_EQ(image.rgb,
            (std::vector<float>{0, 65504, 0, 1, 0, 0, 2, 0, 3, 4, 5, 6, 0, 0, 0, 1, 2, 0}));
  EXPECT_EQ(RepairRadiance(image).total(), 0u);
  // Light brighter than a file can hold is as bright as the brightest that it holds.
  Image sun(2, 1);
  sun.rgb = {kInf, 1, 2, 1e6f, 3, 4};
  EXPECT_EQ(RepairRadiance(sun).infinite, 1u);
  EXPECT_EQ(sun.rgb[0], 1e6f);
}

TEST(ToneMap, ClippedValuesFollowSrgb) {
  // 12.92 * 0.001 * 255 = 3.29; 0.18 -> 117.6; 0.2140411 is half of the code range -> 127.5; 0.5 ->
  // slightly above 187.5.
  EXPECT_EQ(MapGrey({0, 0.001f, 0.18f, 0.2141f, 0.5f, 1, 7}, {}),
            (std::vector<int>{0, 3, 118, 128, 188, 255, 255}));
  EXPECT_EQ(MapGrey({-1, kNan, -kInf, kInf}, {}), (std::vector<int>{0, 0, 0, 255}));
  // On both sides of the knee at 0.0031308, whose code is 10.3, and in the dark greys below it.
  EXPECT_EQ(MapGrey({0.002f, 0.003f, 0.0035f, 0.005f, 0.01f, 0.02f, 0.03f, 0.05f, 0.1f}, {}),
            (std::vector<int>{7, 10, 11, 16, 25, 39, 48, 63, 89}));
}

TEST(ToneMap, ExposureIsInStops) {
  const std::vector<float> values = {0.01f, 0.1f, 0.25f, 0.4f};
  std::vector<float> doubled = values;
  for (float& value : doubled) value *= 2;
  EXPECT_EQ(MapGrey(values, {.exposure_stops = 1}), MapGrey(doubled, {}));
  EXPECT_EQ(MapGrey({8}, {.exposure_stops = -4}), MapGrey({0.5f}, {}));
}

TEST(PhotographicExposure, FollowsTheFormula) {
  // Sunny sixteen: f/16 at 1/100 s and ISO 100 is EV 14.64 and saturates at 1.2 * 16^2 * 100.
  const PhotographicExposure sunny = {.iso = 100, .shutter_seconds = 0.01f, .f_number = 16};
  EXPECT_NEAR(ExposureValue100(sunny), 14.6439, 1e-4);
  EXPECT_NEAR(std::exp2(-ExposureStops(sunny)), 30720, 1);
  // One stop more is twice the time, twice the speed, or the f-number over the square root of two.
  for (const PhotographicExposure& brighter :
       {PhotographicExposure{.iso = 100, .shutter_seconds = 0.02f, .f_number = 16},
        PhotographicExposure{.iso = 200, .shutter_seconds = 0.01f, .f_number = 16},
        PhotographicExposure{.iso = 100, .shutter_seconds = 0.01f, .f_number = 11.3137085f}}) {
    EXPECT_NEAR(ExposureStops(brighter) - ExposureStops(sunny), 1, 1e-5);
  }
}

TEST(ToneMap, FilmicValuesFollowTheFit) {
  // (2.51 x^2 + 0.03 x) / (2.43 x^2 + 0.59 x + 0.14) maps 0.18 to 0.26695 and 1 to 0.80380.
  const ToneMapping filmic = {.curve = ToneCurve::kFilmic};
  EXPECT_EQ(MapGrey({0, 0.18f, 1, 1e4f, 1e30f, kInf, kNan, -1}, filmic),
            (std::vector<int>{0, 141, 232, 255, 255, 255, 0, 0}));
}

// The values are those of the published constants, worked out apart from the program.
TEST(ToneMap, AcesFollowsHill) {
  const ToneMapping aces = {.curve = ToneCurve::kAces};
  const std::vector<int> grey = MapGrey({0, 0.18f, 1, 1e30f, kInf, kNan, -1}, aces);
  EXPECT_EQ(grey, (std::vector<int>{0, 91, 206, 255, 255, 0, 0}));
  // Bright red loses saturation, which channels by themselves do not.
  Image red(1, 1);
  red.rgb = {20, 0, 0};
  const std::vector<std::uint8_t> mapped = ToneMap(red, aces);
  EXPECT_EQ(mapped[0], 255);
  EXPECT_GT(mapped[1], 50);
  EXPECT_EQ(ToneMap(red, {.curve = ToneCurve::kFilmic})[1], 0);
}

// Colours mix by both matrices, none of whose numbers is small enough not to be seen in one of
// these.
TEST(ToneMap, AcesMixesColoursAsHillDoes) {
  Image colors(3, 2);
  colors.rgb = {.1f, .5f, .9f, .8f, .3f, .05f, .05f, .6f, .2f,
                .4f, .1f, .7f, .1f, .9f, .4f,  .6f,  .2f, .3f};
  EXPECT_EQ(ToneMap(colors, {.curve = ToneCurve::kAces}),
            (std::vector<std::uint8_t>{82, 164, 199, 197, 130, 48, 59, 176, 108, 146, 62, 183, 110,
                                       201, 155, 177, 102, 127}));
}

TEST(ToneMap, ReinhardKeepsHueAndEndsAtWhite) {
  const ToneMapping reinhard = {.curve = ToneCurve::kReinhard};
  // L (1 + L / 16) / (1 + L): 0.18 becomes 0.15426, 1 becomes 0.53125, and 4 becomes 1.
  EXPECT_EQ(MapGrey({0, 0.18f, 1, 3.999f, 4, kInf}, reinhard),
            (std::vector<int>{0, 109, 193, 255, 255, 255}));
  Image image(1, 1);
  image.rgb = {0.4f, 0.2f, 0.1f};
  const std::vector<std::uint8_t> mapped = ToneMap(image, reinhard);
  const double luminance = 0.2126 * 0.4 + 0.7152 * 0.2 + 0.0722 * 0.1;
  const double scale = (1 + luminance / 16) / (1 + luminance);
  EXPECT_EQ(mapped, ToneMap(image, {.exposure_stops = float(std::log2(scale))}));
}

TEST(AutomaticExposure, MedianOfLitPixelsBecomesGrey) {
  EXPECT_EQ(AutomaticExposureStops(Grey({0.18f})), 0);
  std::vector<float> dark(40, 0.09f);
  dark.push_back(1000);
  EXPECT_EQ(AutomaticExposureStops(Grey(dark)), 1);
  EXPECT_EQ(AutomaticExposureStops(Grey({0, 0, 0, 0, 0.72f})), -2);
  EXPECT_EQ(AutomaticExposureStops(Grey({0.18f, kNan, kInf, -5, 0.18f})), 0);
  EXPECT_EQ(AutomaticExposureStops(Grey({0, kNan})), 0);
  EXPECT_EQ(AutomaticExposureStops(Grey({1e-38f})), 100);
  // Sixteenths of a stop: log2(0.18 / 0.17) is 0.0825.
  EXPECT_EQ(AutomaticExposureStops(Grey({0.17f})), 0.0625f);
}

TEST(AutomaticExposure, ObjectsAreMeteredAndNotWhatIsBehindThem) {
  const Image image = Grey({0.01f, 0.045f, 0.18f, 0.18f, 0.18f, 0.18f, 0.18f});
  EXPECT_EQ(AutomaticExposureStops(image), 0);
  EXPECT_EQ(AutomaticExposureStops(image, std::vector<float>{1, 0.5f, 1, 0.49f, 0, 0, 0}), 2);
  EXPECT_EQ(AutomaticExposureStops(image, std::vector<float>(7)), 0);
  // What an object of no light covers says nothing.
  EXPECT_EQ(AutomaticExposureStops(Grey({0, 0.36f}), std::vector<float>{1, 0}), -1);
}

TEST(AutomaticExposure, KeepsTheBrightestTwentiethInRangeByTwoStopsAtMost) {
  // Of 100 pixels, 10 are brighter than the others: the picture is as dark as makes them .9.
  std::vector<float> values(100, 0.18f);
  std::fill(values.end() - 10, values.end(), 1.8f);
  EXPECT_EQ(AutomaticExposureStops(Grey(values)), -1);
  std::fill(values.end() - 10, values.end(), 1e4f);
  EXPECT_EQ(AutomaticExposureStops(Grey(values)), -2);
  // Four of a hundred are let go.
  std::fill(values.begin(), values.end() - 4, 0.18f);
  EXPECT_EQ(AutomaticExposureStops(Grey(values)), 0);
  // A backdrop counts there, too: objects are not made grey at any price.
  std::fill(values.begin(), values.end(), 0.9f);
  values[0] = 0.09f;
  std::vector<float> coverage(100);
  coverage[0] = 1;
  EXPECT_EQ(AutomaticExposureStops(Grey(values), coverage), 0);
}

// The values are those of the published constants, worked out apart from the program.
TEST(ToneMap, AgxFollowsWrenschInThePrimariesOfRec2020) {
  const ToneMapping agx = {.curve = ToneCurve::kAgx};
  EXPECT_EQ(MapGrey({0, 0.04f, 0.18f, 0.8f, 1, 4, 1e6f, kInf, kNan, -1}, agx),
            (std::vector<int>{0, 61, 128, 194, 202, 239, 255, 255, 0, 0}));
  EXPECT_EQ(ToneMap(SixColors(), agx),
            (std::vector<std::uint8_t>{129, 178, 202, 199, 152, 103, 118, 181, 137, 165, 126, 193,
                                       252, 168, 147, 185, 139, 152}));
}

TEST(ToneMap, NeutralFollowsKhronos) {
  const ToneMapping neutral = {.curve = ToneCurve::kNeutral};
  EXPECT_EQ(MapGrey({0, 0.04f, 0.18f, 0.8f, 1, 4, 1e6f, kInf, kNan, -1}, neutral),
            (std::vector<int>{0, 25, 105, 226, 240, 253, 255, 255, 0, 0}));
  EXPECT_EQ(ToneMap(SixColors(), neutral),
            (std::vector<std::uint8_t>{70, 178, 235, 227, 141, 34, 34, 198, 113, 162, 69, 212, 252,
                                       141, 134, 197, 111, 139}));
}

TEST(ToneMap, KeepsChannelsApart) {
  Image image(1, 2);
  image.rgb = {1, 0, 0.5f, 0, 1, 0};
  EXPECT_EQ(ToneMap(image, {}), (std::vector<std::uint8_t>{255, 0, 188, 0, 255, 0}));
}

class Png : public ImageFiles {};

TEST_F(Png, PixelsComeBackTheRightWayUp) {
  std::vector<std::uint8_t> rgb(5 * 3 * 3);
  for (std::size_t i = 0; i < rgb.size(); ++i) rgb[i] = std::uint8_t(i * 5);
  WritePng(Path("a.png"), 5, 3, rgb);

  png_image png = {};
  png.version = PNG_IMAGE_VERSION;
  ASSERT_TRUE(png_image_begin_read_from_file(&png, Path("a.png").c_str()));
  EXPECT_EQ(png.width, 5u);
  EXPECT_EQ(png.height, 3u);
  EXPECT_EQ(png.format, unsigned(PNG_FORMAT_RGB));
  std::vector<std::uint8_t> back(rgb.size());
  ASSERT_TRUE(png_image_finish_read(&png, nullptr, back.data(), 0, nullptr));
  EXPECT_EQ(back, rgb);
}

// Pictures of several bands, with every kind of neighbour, and of fewer columns than a filter
// needs.
TEST_F(Png, BandsComeBack) {
  for (const auto& [width, height] : {std::pair(70, 200), {1, 129}, {2, 64}, {300, 65}}) {
    std::vector<std::uint8_t> rgb(std::size_t(width) * height * 3);
    for (std::size_t i = 0; i < rgb.size(); ++i) {
      const std::size_t y = i / (3 * std::size_t(width));
      rgb[i] = std::uint8_t(y % 3 == 0 ? i : y % 3 == 1 ? i * i / 7 : 255 * (i % 2));
    }
    const std::string bytes = EncodePng(width, height, rgb);
    const Image image = DecodeTexture("bands", bytes, Encoding::kLinear);
    ASSERT_EQ(image.width, width);
    ASSERT_EQ(image.height, height);
    for (std::size_t i = 0; i < rgb.size(); ++i) {
      ASSERT_EQ(std::lround(image.rgb[i] * 255), rgb[i]) << i;
    }
  }
}

TEST_F(Png, BytesOnlyDependOnTheInput) {
  const std::vector<std::uint8_t> rgb(64 * 64 * 3, 77);
  WritePng(Path("a.png"), 64, 64, rgb);
  WritePng(Path("b.png"), 64, 64, rgb);
  EXPECT_EQ(ReadFile(Path("a.png")), ReadFile(Path("b.png")));
}

TEST_F(Png, ImpossibleSizeIsAnError) {
  EXPECT_THROW(WritePng(Path("a.png"), 0, 0, {}), InputError);
  EXPECT_FALSE(std::filesystem::exists(Path("a.png")));
}

// Middle grey stays where it is, and about it a step of radiance is shown larger than by the plain
// curve: a tenth more light is then 1.6 tenths more in the picture.
TEST(ToneMap, ContrastIsSteepAboutMiddleGrey) {
  Image image(4, 1);
  const float values[] = {0, 0.18f, 0.198f, 1e6f};
  for (int x = 0; x < 4; ++x) std::fill_n(image.Pixel(x, 0), 3, values[x]);
  const std::vector<std::uint8_t> shown = ToneMap(image, {.curve = ToneCurve::kContrast});
  const std::vector<std::uint8_t> plain = ToneMap(image, {});
  const auto light = [](std::uint8_t code) {
    return std::pow((code / 255.0 + 0.055) / 1.055, 2.4);
  };
  EXPECT_EQ(shown[0], 0);
  EXPECT_EQ(shown[3], plain[3]);
  EXPECT_NEAR(light(shown[6]) / light(plain[3]), 1.166, 0.025);
  EXPECT_EQ(shown[9], 255);
}

}  // namespace
}  // namespace skywave
