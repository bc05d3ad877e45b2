// Pictures as other programs write them: windows, primaries, layers, exposures, deep PNG, and bytes
// that do no harm. Expected numbers come from the definitions of the formats.
#include <ImfChromaticitiesAttribute.h>
#include <ImfStandardAttributes.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <string>
#include <vector>

#include "image/image.h"
#include "image/jpeg.h"
#include "tests/support/deep_png.h"
#include "tests/support/image_test_files.h"

namespace skywave {
namespace {

// The picture of a file with a display window is that window: what the data leave out is black, and
// what lies beyond it is not seen.
TEST_F(ImageFiles, ExrDataStandWhereTheyBelongInTheDisplayWindow) {
  const Image image = Numbered(9, 5);
  const Imath::Box2i data({-3, 20}, {5, 24});
  for (const Imf::LineOrder order : {Imf::INCREASING_Y, Imf::DECREASING_Y}) {
    for (const Imf::Compression compression : {Imf::NO_COMPRESSION, Imf::PIZ_COMPRESSION}) {
      Imf::Header header(Imath::Box2i({0, 10}, {19, 22}), data);
      header.lineOrder() = order, header.compression() = compression;
      WriteExrKind(Path("a.exr"), header, image,
                   {{"R", Imf::FLOAT}, {"G", Imf::FLOAT}, {"B", Imf::FLOAT}, {"Z", Imf::FLOAT}});
      const LayeredImage read = ReadLayeredImage(Path("a.exr"), {"Z"});
      ASSERT_EQ(read.image.width, 20);
      ASSERT_EQ(read.image.height, 13);
      for (int y = 0; y < 13; ++y) {
        for (int x = 0; x < 20; ++x) {
          const int column = x + 3, row = y + 10 - 20;
          const bool has = column < 9 && row >= 0 && row < 5;
          for (int c = 0; c < 3; ++c) {
            EXPECT_EQ(read.image.Pixel(x, y)[c], has ? image.Pixel(column, row)[c] : 0.0f);
          }
          EXPECT_EQ(read.layers[0].values[std::size_t(20 * y + x)], has ? -1.0f : 0.0f);
        }
      }
    }
  }
}

TEST_F(ImageFiles, ExrOfAWindowFarLargerThanItsDataIsRefused) {
  Imf::Header header(Imath::Box2i({0, 0}, {8191, 4095}), Imath::Box2i({0, 0}, {8, 4}));
  WriteExrKind(Path("a.exr"), header, Numbered(9, 5));
  ExpectUnreadable([&] { ReadImage(Path("a.exr")); }, "display window");
}

// White stays white, and the red of Rec. 2020 is outside of Rec. 709. The matrix is that of ITU-R
// BT.2087-0, annex 1, inverted: 1.6605, -0.5876, -0.0728 is its first row.
TEST_F(ImageFiles, ExrColoursOfOtherPrimariesBecomeThoseOfRec709) {
  Image image(2, 1);
  image.rgb = {1, 1, 1, 1, 0, 0};
  Imf::Header header = HeaderFor(image, Imf::ZIP_COMPRESSION);
  Imf::addChromaticities(header, Imf::Chromaticities({0.708f, 0.292f}, {0.17f, 0.797f},
                                                     {0.131f, 0.046f}, {0.3127f, 0.329f}));
  WriteExrKind(Path("a.exr"), header, image);
  const Image read = ReadImage(Path("a.exr"));
  const float expected[] = {1, 1, 1, 1.6605f, -0.1246f, -0.0182f};
  for (std::size_t i = 0; i < 6; ++i) EXPECT_NEAR(read.rgb[i], expected[i], 2e-4f) << i;
  // X, Y and Z themselves: those of white D65 are white, whatever the white of the space.
  Image xyz(1, 1);
  xyz.rgb = {0.9505f, 1, 1.089f};
  Imf::Header of_xyz = HeaderFor(xyz, Imf::ZIP_COMPRESSION);
  Imf::addChromaticities(of_xyz, Imf::Chromaticities({1, 0}, {0, 1}, {0, 0}, {1 / 3.f, 1 / 3.f}));
  WriteExrKind(Path("a.exr"), of_xyz, xyz);
  for (const float value : ReadImage(Path("a.exr")).rgb) EXPECT_NEAR(value, 1, 2e-3f);
  // Those of Rec. 709 itself, and chromaticities that make no space, change no bit.
  for (const Imf::Chromaticities& same :
       {Imf::Chromaticities(), Imf::Chromaticities({0, 0}, {0, 0}, {0, 0}, {0, 0})}) {
    Imf::addChromaticities(header, same);
    WriteExrKind(Path("b.exr"), header, Numbered(2, 1));
    ExpectSame(ReadImage(Path("b.exr")), Numbered(2, 1));
  }
}

TEST_F(ImageFiles, ExrColoursAreFoundUnderOtherNames) {
  const Image image = Numbered(9, 5);
  const auto named = [&](const std::string& r, const std::string& g, const std::string& b) {
    Imf::Header header = HeaderFor(image, Imf::ZIP_COMPRESSION);
    std::vector<std::string> pixels = {TypedPixels(image, "R", Imf::FLOAT),
                                       TypedPixels(image, "G", Imf::FLOAT),
                                       TypedPixels(image, "B", Imf::FLOAT)};
    Imf::FrameBuffer frame;
    const std::string names[] = {r, g, b};
    for (std::size_t c = 0; c < 3; ++c) {
      header.channels().insert(names[c], Imf::Channel(Imf::FLOAT));
      frame.insert(names[c], Imf::Slice::Make(Imf::FLOAT, pixels[c].data(), header.dataWindow()));
    }
    Imf::OutputFile file(Path("a.exr").c_str(), header, 0);
    file.setFrameBuffer(frame);
    file.writePixels(image.height);
  };
  named("r", "g", "b");
  ExpectSame(ReadImage(Path("a.exr")), image);
  const std::string layer = "ViewLayer.Combined.";  // as Blender names it
  named(layer + "R", layer + "G", layer + "B");
  ExpectSame(ReadImage(Path("a.exr")), image);
  WriteExrKind(Path("a.exr"), HeaderFor(image, Imf::ZIP_COMPRESSION), image, {{"G", Imf::FLOAT}});
  EXPECT_EQ(ReadImage(Path("a.exr")).rgb[0], image.rgb[1]) << "the only channel";
}

// Luminance Y and (R - Y) / Y, (B - Y) / Y: G follows from the weights of Rec. 709.
TEST_F(ImageFiles, ExrOfLuminanceAndChromaIsConverted) {
  Image made(1, 1);
  const double r = 0.5, g = 0.25, b = 2, y = 0.2126 * r + 0.7152 * g + 0.0722 * b;
  const float values[] = {float(y), float(r / y - 1), float(b / y - 1)};
  Imf::Header header = HeaderFor(made, Imf::ZIP_COMPRESSION);
  Imf::FrameBuffer frame;
  const char* const names[] = {"Y", "RY", "BY"};
  for (int c = 0; c < 3; ++c) {
    header.channels().insert(names[c], Imf::Channel(Imf::FLOAT));
    frame.insert(names[c], Imf::Slice::Make(Imf::FLOAT, &values[c], header.dataWindow()));
  }
  {
    Imf::OutputFile file(Path("a.exr").c_str(), header, 0);
    file.setFrameBuffer(frame);
    file.writePixels(1);
  }
  const Image read = ReadImage(Path("a.exr"));
  EXPECT_NEAR(read.rgb[0], r, 1e-4);
  EXPECT_NEAR(read.rgb[1], g, 1e-4);
  EXPECT_NEAR(read.rgb[2], b, 1e-4);
}

std::string Rgbe(const std::string& header, const std::string& resolution,
                 const std::string& pixels) {
  return header + "FORMAT=32-bit_rle_rgbe\n\n" + resolution + "\n" + pixels;
}
const std::string kTwoPixels("\x80\x40\x20\x88\x80\x80\x80\x88", 8);  // 128, 64, 32 and 128s

TEST_F(ImageFiles, RgbeIsDividedByWhatItWasMultipliedBy) {
  const Image image =
      ReadImage(Put("a.hdr", Rgbe("#?RADIANCE\nEXPOSURE=  4.0\nEXPOSURE=.5\nCOLORCORR= 1 2 4\n",
                                  "-Y 1 +X 2", kTwoPixels)));
  EXPECT_EQ(image.rgb, (std::vector<float>{64, 16, 4, 64, 32, 16}));
  for (const char* line : {"EXPOSURE=0", "EXPOSURE=x", "COLORCORR=1 1", "EXPOSURE=-1"}) {
    ExpectUnreadable(
        [&] {
          ReadImage(Put("a.hdr",
                        Rgbe(std::string("#?RADIANCE\n") + line + "\n", "-Y 1 +X 2", kTwoPixels)));
        },
        "the Radiance header's line");
  }
}

TEST_F(ImageFiles, RgbeOfOtherPrimariesAndOfXyzIsConverted) {
  const Image wide =
      ReadImage(Put("a.hdr", Rgbe("#?RADIANCE\nPRIMARIES=.708 .292 .17 .797 .131 .046 .3127 .329\n",
                                  "-Y 1 +X 2", kTwoPixels)));
  // The first row of the matrix, times 128, 64 and 32.
  EXPECT_NEAR(wide.rgb[0], 128 * (1.6605f - 0.5876f / 2 - 0.0728f / 4), 0.05f);
  EXPECT_NEAR(wide.rgb[3], 128, 0.01f);
  // Some programs write primaries of zeros.
  const Image none = ReadImage(
      Put("b.hdr", Rgbe("#?RADIANCE\nPRIMARIES=0 0 0 0 0 0 0 0\n", "-Y 1 +X 2", kTwoPixels)));
  EXPECT_EQ(none.rgb, (std::vector<float>{128, 64, 32, 128, 128, 128}));
  const std::string header = "#?RADIANCE\nFORMAT=32-bit_rle_xyze\n\n-Y 1 +X 2\n";
  const Image xyz = ReadImage(Put("c.hdr", header + kTwoPixels));
  EXPECT_NEAR(xyz.rgb[0], 3.2406f * 128 - 1.5372f * 64 - 0.4986f * 32, 0.1f);
  EXPECT_NEAR(xyz.rgb[1], -0.9689f * 128 + 1.8758f * 64 + 0.0415f * 32, 0.1f);
}

TEST_F(ImageFiles, RgbeOfOtherProgramsIsRead) {
  const std::vector<float> expected = {128, 64, 32, 128, 128, 128};
  EXPECT_EQ(
      ReadImage(Put("a.hdr", Rgbe("#?RADIANCE \n", "-Y        1 +X        2", kTwoPixels))).rgb,
      expected);
  EXPECT_EQ(ReadImage(Put("b.hdr", Rgbe("#?AUTOPANO\n", "-Y 1 +X 2 ", kTwoPixels))).rgb, expected);
}

// The run lengths of the old coding make any number of pixels of a few bytes.
TEST_F(ImageFiles, RgbeOfFewBytesIsNoLargePicture) {
  std::string runs = "\x80\x40\x20\x88";
  for (int i = 0; i < 300; ++i) runs += "\x01\x01\x01\xff";
  ExpectUnreadable([&] { ReadImage(Put("a.hdr", Rgbe("#?RADIANCE\n", "-Y 8192 +X 16384", runs))); },
                   "is refused");
}

TEST_F(ImageFiles, PfmMayHaveCommentsAndAScale) {
  const std::vector<float> values = {1, 2, 3, 4, 5, 6};
  const std::string pixels(reinterpret_cast<const char*>(values.data()), 24);
  const auto read = [&](const std::string& header) {
    return ReadImage(Put("a.pfm", header + pixels)).rgb;
  };
  EXPECT_EQ(read("PF\n# made by a program\n2  1\n-1.0\n"), values);
  EXPECT_EQ(read("PF 2 1 # two pixels\n\n -1\n"), values);
  EXPECT_EQ(read("PF\r\n2 1\r\n-1\r\n"), values);
  EXPECT_EQ(read("PF\n2 1\n-2.5\n"), (std::vector<float>{2.5f, 5, 7.5f, 10, 12.5f, 15}));
  std::string swapped = pixels;
  for (std::size_t i = 0; i < 24; i += 4) std::reverse(&swapped[i], &swapped[i] + 4);
  EXPECT_EQ(ReadImage(Put("b.pfm", "PF\n2 1\n+1.0\n" + swapped)).rgb, values);
}

TEST(TextureImages, PngOfSixteenBitsKeepsThemAllInterlacedOrNot) {
  const int width = 13, height = 11;
  std::vector<std::uint16_t> rgb(std::size_t(3 * width * height));
  for (std::size_t i = 0; i < rgb.size(); ++i) rgb[i] = std::uint16_t(40503 * (i + 1));
  for (const int interlace : {PNG_INTERLACE_NONE, PNG_INTERLACE_ADAM7}) {
    const Image image =
        DecodeTexture("a.png", DeepPng(width, height, interlace, rgb), Encoding::kLinear);
    ASSERT_EQ(image.rgb.size(), rgb.size());
    for (std::size_t i = 0; i < rgb.size(); ++i) ASSERT_EQ(image.rgb[i], float(rgb[i] / 65535.0));
  }
}

// Bytes between the parts of a JPEG, which cameras leave there, do no harm; others do.
TEST(TextureImages, JpegMayHaveBytesBetweenItsParts) {
  const std::string jpeg = EncodeJpeg(2, 1, {10, 20, 30, 40, 50, 60}, 90);
  const std::size_t table = jpeg.find("\xff\xdb");
  ASSERT_NE(table, std::string::npos);
  const std::string padded = jpeg.substr(0, table) + std::string(3, '\0') + jpeg.substr(table);
  EXPECT_EQ(DecodeTexture("a.jpg", padded, Encoding::kLinear).rgb,
            DecodeTexture("a.jpg", jpeg, Encoding::kLinear).rgb);
}

TEST_F(ImageFiles, FilesOfOtherKindsAreNamed) {
  const std::pair<std::string, const char*> kinds[] = {
      {std::string("II*\0", 4), "TIFF"},
      {"DDS |", "DDS"},
      {"version https://git-lfs.github.com/spec/v1\n", "git lfs pull"},
      {EncodePng(1, 1, {1, 2, 3}), "no radiance"},
      {"", "is empty"},
      {"hello", "is neither OpenEXR, Radiance RGBE nor PFM"}};
  for (const auto& [bytes, reason] : kinds) {
    ExpectUnreadable([&, text = bytes] { ReadImage(Put("a.exr", text)); }, reason);
  }
}

}  // namespace
}  // namespace skywave
