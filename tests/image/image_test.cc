// Pictures survive every file format unchanged and upright.

#include "image/image.h"

#include <ImfBoxAttribute.h>
#include <ImfChromaticitiesAttribute.h>
#include <ImfDoubleAttribute.h>
#include <ImfEnvmapAttribute.h>
#include <ImfFloatAttribute.h>
#include <ImfInputFile.h>
#include <ImfIntAttribute.h>
#include <ImfKeyCodeAttribute.h>
#include <ImfMatrixAttribute.h>
#include <ImfPreviewImage.h>
#include <ImfRationalAttribute.h>
#include <ImfStandardAttributes.h>
#include <ImfStringAttribute.h>
#include <ImfThreading.h>
#include <ImfTimeCodeAttribute.h>
#include <ImfVecAttribute.h>
#include <gtest/gtest.h>
#include <half.h>

#include <limits>

#include "base/error.h"
#include "tests/support/image_test_files.h"

namespace skywave {
namespace {

constexpr float kInf = std::numeric_limits<float>::infinity();
constexpr float kNan = std::numeric_limits<float>::quiet_NaN();

Image Unusual() {
  Image image(3, 2);
  image.rgb = {kNan,   -kNan, kInf,  -kInf, -0.0f, 1e-45f, 3.4028235e38f, -1,           0.1f, 1e6f,
               1e-38f, 65504, 65520, 1e-7f, 0,     1,      0x1.8p-20f,    0x1.FFFFFEp3f};
  image.rgb[0] = std::bit_cast<float>(0x7fc12345u);  // a NaN with a payload
  return image;
}

TEST_F(ImageFiles, ExrKeepsEveryBit) {
  WriteExr(Path("a.exr"), Unusual());
  ExpectSame(ReadImage(Path("a.exr")), Unusual());
  WriteExr(Path("b.exr"), Numbered(70, 37));  // several chunks of 16 rows, the last one incomplete
  ExpectSame(ReadImage(Path("b.exr")), Numbered(70, 37));
}

TEST_F(ImageFiles, ExrBytesOnlyDependOnTheInput) {
  const Metadata metadata = {{"scene", "cornell"}, {"samples", "64"}};
  WriteExr(Path("a.exr"), Numbered(40, 20), metadata);
  WriteExr(Path("b.exr"), Numbered(40, 20), metadata);
  EXPECT_EQ(ReadFile(Path("a.exr")), ReadFile(Path("b.exr")));
  EXPECT_EQ(Imf::globalThreadCount(), 0);
}

TEST_F(ImageFiles, ExrLeavesTheThreadsOfTheHostAlone) {
  Imf::setGlobalThreadCount(2);
  WriteExr(Path("a.exr"), Numbered(40, 20));
  ExpectSame(ReadImage(Path("a.exr")), Numbered(40, 20));
  EXPECT_EQ(Imf::globalThreadCount(), 2);
  Imf::setGlobalThreadCount(0);
}

TEST_F(ImageFiles, ExrLayersComeBack) {
  const Image image = Numbered(5, 3);
  const std::vector<float> depth = {1e10f, 1, 2, 3, 4, 5, 6, 7, 8, 9, 10, 11, 12, -1, 0.5f};
  const std::vector<float> red(15, 0.25f);
  WriteExr(Path("a.exr"), image, {}, {{"depth.Z", depth}, {"albedo.R", red}});
  ExpectSame(ReadImage(Path("a.exr")), image);
  Imf::InputFile file(Path("a.exr").c_str());
  std::vector<float> back(15), red_back(15);
  Imf::FrameBuffer frame;
  const auto slice = [&](std::vector<float>& to) {
    return Imf::Slice::Make(Imf::FLOAT, to.data(), file.header().dataWindow());
  };
  frame.insert("depth.Z", slice(back));
  frame.insert("albedo.R", slice(red_back));
  file.setFrameBuffer(frame);
  file.readPixels(0, 2);
  EXPECT_EQ(back, depth);
  EXPECT_EQ(red_back, red);
}

TEST_F(ImageFiles, ExrBytesDoNotDependOnThreads) {
  const Image image = Numbered(40, 300);
  const NamedChannel depth = {"depth.Z", std::vector<float>(40 * 300, 2)};
  for (const ExrCompression compression : ValuesOf<ExrCompression>()) {
    WriteExr(Path("a.exr"), image, {}, {depth}, {.compression = compression, .threads = 1});
    WriteExr(Path("b.exr"), image, {}, {depth}, {.compression = compression, .threads = 3});
    EXPECT_EQ(ReadFile(Path("a.exr")), ReadFile(Path("b.exr"))) << ToString(compression);
  }
}

// Strips end where chunks end, so a file is the one that the library writes in one go. What the
// library deflates has other bytes in each of its versions, so that it is compared as read.
TEST_F(ImageFiles, ExrEqualsThatOfTheLibrary) {
  const Image image = Numbered(40, 300);
  for (const ExrCompression compression : ValuesOf<ExrCompression>()) {
    WriteExr(Path("a.exr"), image, {}, {}, {.compression = compression});
    Imf::Header header = HeaderFor(image, Imf::Compression(compression));
    header.zipCompressionLevel() = 4;
    Imf::addChromaticities(header, Imf::Chromaticities());  // those of Rec. 709
    header.insert("colorInteropID", Imf::StringAttribute("lin_rec709_scene"));
    WriteExrKind(Path("b.exr"), header, image);
    if (compression == ExrCompression::kZip || compression == ExrCompression::kZips) {
      ExpectSame(ReadImage(Path("a.exr")), image);
      ExpectSame(ReadImage(Path("b.exr")), image);
    } else {
      EXPECT_EQ(ReadFile(Path("a.exr")), ReadFile(Path("b.exr"))) << ToString(compression);
    }
  }
}

// The display window is the larger picture; the library and ReadDataWindow find the part there.
TEST_F(ImageFiles, APartIsWrittenWithItsPlace) {
  const Image image = Numbered(40, 37);
  for (const ExrCompression compression : ValuesOf<ExrCompression>()) {
    SCOPED_TRACE(ToString(compression));
    WriteExr(Path("a.exr"), image, {}, {},
             {.compression = compression, .placement = {5, 19, 64, 60}});
    Imf::InputFile file(Path("a.exr").c_str(), 0);
    EXPECT_EQ(file.header().dataWindow(), Imath::Box2i({5, 19}, {44, 55}));
    EXPECT_EQ(file.header().displayWindow(), Imath::Box2i({0, 0}, {63, 59}));
    std::vector<float> red(image.rgb.size() / 3);
    Imf::FrameBuffer frame;
    frame.insert("R", Imf::Slice::Make(Imf::FLOAT, red.data(), file.header().dataWindow()));
    file.setFrameBuffer(frame);
    file.readPixels(19, 55);
    const LayeredImage back = ReadDataWindow(Path("a.exr"));
    EXPECT_EQ(back.placement.x, 5);
    EXPECT_EQ(back.placement.y, 19);
    const bool loses = compression >= ExrCompression::kPxr24;
    if (!loses) ExpectSame(back.image, image);
    for (std::size_t i = 0; i < red.size(); ++i) {
      ASSERT_EQ(red[i], back.image.rgb[3 * i]) << i;
      if (!loses) {
        ASSERT_EQ(red[i], image.rgb[3 * i]) << i;
      }
    }
    const Image placed = ReadImage(Path("a.exr"));
    ASSERT_EQ(placed.width, 64);
    ASSERT_EQ(placed.height, 60);
    EXPECT_EQ(placed.Pixel(44, 55)[1], back.image.Pixel(39, 36)[1]);
    EXPECT_EQ(placed.Pixel(45, 55)[1], 0);
  }
  // A picture of the same size may be shifted.
  WriteExr(Path("a.exr"), image, {}, {}, {.placement = {1, 0, 40, 37}});
  EXPECT_EQ(ReadDataWindow(Path("a.exr")).placement.x, 1);
  EXPECT_EQ(ReadImage(Path("a.exr")).Pixel(1, 0)[0], image.Pixel(0, 0)[0]);
  WriteExr(Path("a.exr"), image);
  EXPECT_EQ(ReadDataWindow(Path("a.exr")).placement.width, 0);
}

// Large chunks are deflated to other bytes, which the library has to read and which are not many
// more, if they are fewer than those of the pixels.
TEST_F(ImageFiles, LargeChunksAreReadByTheLibrary) {
  Image image = Numbered(6000, 70);
  std::fill_n(image.rgb.begin(), 6000 * 20 * 3, 1.0f);
  for (std::size_t i = 6000 * 40 * 3; i < image.rgb.size(); ++i) {  // does not shrink
    image.rgb[i] = std::bit_cast<float>(std::uint32_t(i * i) * 2654435761u & 0xbfffffff);
  }
  for (const auto compression : {ExrCompression::kZip, ExrCompression::kZips}) {
    WriteExr(Path("a.exr"), image, {}, {}, {.compression = compression});
    WriteExrKind(Path("b.exr"), HeaderFor(image, Imf::Compression(compression)), image);
    const double bytes = double(ReadFile(Path("a.exr")).size());
    EXPECT_LT(bytes, 1.05 * double(ReadFile(Path("b.exr")).size())) << ToString(compression);
    EXPECT_LT(bytes, 0.8 * double(image.rgb.size() * sizeof(float))) << ToString(compression);
    Image back(image.width, image.height);
    Imf::InputFile file(Path("a.exr").c_str(), 0);
    Imf::FrameBuffer frame;
    for (std::size_t c = 0; c < 3; ++c) {
      frame.insert(std::string(1, "RGB"[c]),
                   Imf::Slice::Make(Imf::FLOAT, &back.rgb[c], file.header().dataWindow(),
                                    3 * sizeof(float)));
    }
    file.setFrameBuffer(frame);
    file.readPixels(0, image.height - 1);
    ExpectSame(back, image);
    ExpectSame(ReadImage(Path("a.exr")), image);
  }
}

TEST_F(ImageFiles, HalfRoundsColoursAlone) {
  Image image(2, 1);
  image.rgb = {0.1f, 1e6f, -1e6f, kInf, 2049, 6e-8f};
  const std::vector<NamedChannel> layers = {{"albedo.G", {0.3f, 1}},
                                            {"depth.Z", {0.3f, 1e10f}},
                                            {"variance.R", {1e-12f, 1e9f}},
                                            {"half.G", {0.3f, 1}},
                                            {"half-variance.B", {1e-12f, 1}}};
  for (const ExrCompression compression : {ExrCompression::kZip, ExrCompression::kPiz}) {
    WriteExr(Path("a.exr"), image, {}, layers, {.compression = compression, .half = true});
    const LayeredImage back = ReadLayeredImage(
        Path("a.exr"), {"albedo.G", "depth.Z", "variance.R", "half.G", "half-variance.B"});
    EXPECT_EQ(back.image.rgb, (std::vector<float>{float(half(0.1f)), 65504, -65504, kInf, 2048,
                                                  float(half(6e-8f))}));
    EXPECT_EQ(back.layers[0].values, (std::vector<float>{float(half(0.3f)), 1}));
    for (const std::size_t i : {1, 2, 3, 4}) EXPECT_EQ(back.layers[i].values, layers[i].values);
  }
}

TEST_F(ImageFiles, LayersAreReadByName) {
  const Image image = Numbered(40, 35);  // several chunks
  NamedChannel depth = {"depth.Z", std::vector<float>(40 * 35)}, albedo = {"albedo.R", {}};
  for (std::size_t i = 0; i < depth.values.size(); ++i) depth.values[i] = 0.5f * float(i);
  albedo.values.assign(depth.values.rbegin(), depth.values.rend());
  WriteExr(Path("a.exr"), image, {}, {depth, albedo, {"uv.U", std::vector<float>(40 * 35)}});
  EXPECT_EQ(ReadLayerNames(Path("a.exr")),
            (std::vector<std::string>{"albedo.R", "depth.Z", "uv.U"}));
  const LayeredImage both = ReadLayeredImage(Path("a.exr"), {"depth.Z", "albedo.R"});
  ExpectSame(both.image, image);
  ASSERT_EQ(both.layers.size(), 2u);
  EXPECT_EQ(both.layers[0].name, "depth.Z");
  EXPECT_EQ(both.layers[0].values, depth.values);
  EXPECT_EQ(both.layers[1].name, "albedo.R");
  EXPECT_EQ(both.layers[1].values, albedo.values);
  EXPECT_TRUE(ReadLayeredImage(Path("a.exr"), {}).layers.empty());
}

TEST_F(ImageFiles, LayersOfEveryKindOfExr) {
  const Image image = Numbered(40, 35);
  for (const Imf::Compression compression : {Imf::ZIP_COMPRESSION, Imf::PIZ_COMPRESSION}) {
    for (const Imf::PixelType type : {Imf::HALF, Imf::FLOAT, Imf::UINT}) {
      // In a grey picture, a channel G is a layer.
      WriteExrKind(Path("a.exr"), HeaderFor(image, compression), image,
                   {{"A", Imf::HALF}, {"G", type}, {"Y", Imf::FLOAT}});
      const LayeredImage grey = ReadLayeredImage(Path("a.exr"), {"G"});
      for (std::size_t i = 0; i < grey.image.rgb.size(); ++i) {
        ASSERT_EQ(grey.image.rgb[i], image.rgb[i - i % 3]);
        ASSERT_EQ(grey.layers[0].values[i / 3], image.rgb[i - i % 3 + 1]);
      }
    }
  }
}

TEST_F(ImageFiles, MissingLayersAreNamed) {
  const auto message = [&](const std::string& name) {
    try {
      ReadLayeredImage(Path(name), {"depth.Z", "variance.G"});
    } catch (const InputError& error) {
      return std::string(error.what());
    }
    return std::string();
  };
  const auto expect = [&](const std::string& name, const std::string& part) {
    EXPECT_NE(message(name).find(part), std::string::npos) << message(name);
  };
  const std::vector<float> values(20);
  WriteExr(Path("a.exr"), Numbered(5, 4), {}, {{"depth.Z", values}, {"uv.U", values}});
  expect("a.exr", "no layer variance.G; its layers are depth.Z, uv.U");
  WriteExr(Path("b.exr"), Numbered(5, 4));
  expect("b.exr", "no layer depth.Z; it has none at all");
  EXPECT_TRUE(ReadLayerNames(Path("b.exr")).empty());
  WritePfm(Path("c.pfm"), Numbered(5, 4));
  expect("c.pfm", "only OpenEXR files have layers");
  EXPECT_TRUE(ReadLayerNames(Path("c.pfm")).empty());
}

TEST_F(ImageFiles, ExrMetadataComesBack) {
  const Metadata metadata = {
      {"a", ""}, {"b", "line\nline \xc3\xa9"}, {std::string(100, 'c'), std::string(100000, 'x')}};
  WriteExr(Path("a.exr"), Numbered(4, 4), metadata);
  // The header also names the space of the colours.
  Metadata read = ReadExrMetadata(Path("a.exr"));
  std::erase_if(read, [](const auto& text) { return text.first == "colorInteropID"; });
  EXPECT_EQ(read, metadata);
  ExpectSame(ReadImage(Path("a.exr")), Numbered(4, 4));
  // The order is that of the file, which OpenEXR sorts by name.
  WriteExr(Path("b.exr"), Numbered(4, 4), {{"z", "1"}, {"y", "2"}});
  EXPECT_EQ(ReadExrMetadata(Path("b.exr")),
            (Metadata{{"colorInteropID", "lin_rec709_scene"}, {"y", "2"}, {"z", "1"}}));
}

TEST_F(ImageFiles, ExrOfEveryLosslessCompression) {
  const Image image = Numbered(70, 67);
  for (const Imf::Compression compression :
       {Imf::NO_COMPRESSION, Imf::RLE_COMPRESSION, Imf::ZIPS_COMPRESSION, Imf::ZIP_COMPRESSION,
        Imf::PIZ_COMPRESSION}) {
    WriteExrKind(Path("a.exr"), HeaderFor(image, compression), image);
    ExpectSame(ReadImage(Path("a.exr")), image);
  }
}

TEST_F(ImageFiles, ExrOfEveryPixelType) {
  const Image image = Numbered(9, 5);
  for (const Imf::PixelType type : {Imf::HALF, Imf::FLOAT, Imf::UINT}) {
    WriteExrKind(Path("a.exr"), HeaderFor(image, Imf::ZIP_COMPRESSION), image,
                 {{"R", type}, {"G", type}, {"B", type}});
    ExpectSame(ReadImage(Path("a.exr")), image);
  }
}

TEST_F(ImageFiles, ExrAlphaAndLayersAreLeftOut) {
  const Image image = Numbered(9, 5);
  WriteExrKind(Path("a.exr"), HeaderFor(image, Imf::PIZ_COMPRESSION), image,
               {{"A", Imf::HALF},
                {"B", Imf::FLOAT},
                {"G", Imf::HALF},
                {"R", Imf::UINT},
                {"Y", Imf::FLOAT},
                {"diffuse.R", Imf::FLOAT}});
  ExpectSame(ReadImage(Path("a.exr")), image);
}

TEST_F(ImageFiles, ExrLuminanceAloneIsGrey) {
  Image image = Numbered(9, 5);
  WriteExrKind(Path("a.exr"), HeaderFor(image, Imf::ZIP_COMPRESSION), image,
               {{"A", Imf::FLOAT}, {"Y", Imf::HALF}});
  for (std::size_t i = 0; i < image.rgb.size(); ++i) image.rgb[i] = image.rgb[i - i % 3];
  ExpectSame(ReadImage(Path("a.exr")), image);
}

TEST_F(ImageFiles, ExrWithoutColoursIsRefused) {
  const Image image = Numbered(9, 5);
  for (const ExrChannels& channels : {ExrChannels{{"R", Imf::FLOAT}, {"G", Imf::FLOAT}},
                                      ExrChannels{{"left.R", Imf::FLOAT}, {"right.R", Imf::FLOAT}},
                                      ExrChannels{{"RY", Imf::FLOAT}, {"BY", Imf::FLOAT}}}) {
    WriteExrKind(Path("a.exr"), HeaderFor(image, Imf::ZIP_COMPRESSION), image, channels);
    EXPECT_THROW(ReadImage(Path("a.exr")), InputError);
  }
}

TEST_F(ImageFiles, ExrTilesOfEveryLevelMode) {
  const Image image = Numbered(37, 21);
  for (const Imf::LevelMode levels : {Imf::ONE_LEVEL, Imf::MIPMAP_LEVELS, Imf::RIPMAP_LEVELS}) {
    for (const Imf::LevelRoundingMode rounding : {Imf::ROUND_DOWN, Imf::ROUND_UP}) {
      for (const unsigned side : {8u, 64u}) {
        Imf::Header header = HeaderFor(image, Imf::ZIP_COMPRESSION);
        header.setTileDescription(Imf::TileDescription(side, side / 2, levels, rounding));
        WriteExrKind(Path("a.exr"), header, image);
        ExpectSame(ReadImage(Path("a.exr")), image);
      }
    }
  }
}

TEST_F(ImageFiles, PfmKeepsEveryBit) {
  WritePfm(Path("a.pfm"), Unusual());
  ExpectSame(ReadImage(Path("a.pfm")), Unusual());
}

TEST_F(ImageFiles, PfmInBothByteOrdersAndGrey) {
  // The picture has two rows of one pixel; the file starts with the lower one.
  const std::string little("\0\0\x80\x3f\0\0\0\x40", 8);  // 1, 2
  const std::string big("\x3f\x80\0\0\x40\0\0\0", 8);
  for (const std::string& file :
       {"Pf 1 2 -1.0\n" + little, "Pf\n1 2\n1\n" + big, "Pf\n1\t2\n1e0\n" + big}) {
    const Image image = ReadImage(Put("a.pfm", file));
    ASSERT_EQ(image.width, 1);
    ASSERT_EQ(image.height, 2);
    EXPECT_EQ(image.rgb, (std::vector<float>{2, 2, 2, 1, 1, 1}));
  }
  const std::string colour("\x3f\x80\0\0\x40\0\0\0\xc0\0\0\0", 12);
  EXPECT_EQ(ReadImage(Put("b.pfm", "PF 1 1 2.5e3\n" + colour)).rgb,
            (std::vector<float>{2500, 5000, -5000}));
}

TEST_F(ImageFiles, TopLeftStaysTopLeft) {
  Image image(9, 5);
  image.Pixel(0, 0)[0] = 1;
  image.Pixel(8, 0)[1] = 1;
  image.Pixel(0, 4)[2] = 1;
  for (const char* const name : {"a.exr", "a.pfm", "a.hdr", "b.EXR", "b.Pfm", "b.HDR"}) {
    WriteImage(Path(name), image);
    ExpectSame(ReadImage(Path(name)), image);
  }
}

TEST_F(ImageFiles, EndingDecidesWhatIsWrittenAndContentWhatIsRead) {
  WriteImage(Path("a.exr"), Numbered(3, 3), {{"key", "value"}});
  EXPECT_EQ(ReadExrMetadata(Path("a.exr")),
            (Metadata{{"colorInteropID", "lin_rec709_scene"}, {"key", "value"}}));
  std::filesystem::rename(Path("a.exr"), Path("a.hdr"));
  ExpectSame(ReadImage(Path("a.hdr")), Numbered(3, 3));
  for (const char* const name : {"a.png", "a", "exr", "a.exr/b"}) {
    try {
      WriteImage(Path(name), Numbered(3, 3));
      ADD_FAILURE() << name;
    } catch (const InputError& error) {
      EXPECT_EQ(error.exit_code(), kExitUsage) << name;
    }
  }
}

// Other programs keep cameras, times and primaries. None of them matters, and none may be refused.
TEST_F(ImageFiles, ExrAttributesOfEveryTypeAreRead) {
  const Image image = Numbered(9, 5);
  Imf::Header header = HeaderFor(image, Imf::ZIP_COMPRESSION);
  header.insert("b2f", Imf::Box2fAttribute(Imath::Box2f({0, 0}, {1, 1})));
  header.insert("b2i", Imf::Box2iAttribute(Imath::Box2i({0, 0}, {1, 1})));
  header.insert("chromaticities", Imf::ChromaticitiesAttribute(Imf::Chromaticities()));
  header.insert("d", Imf::DoubleAttribute(1));
  header.insert("envmap", Imf::EnvmapAttribute(Imf::ENVMAP_LATLONG));
  header.insert("whiteLuminance", Imf::FloatAttribute(100));
  header.insert("i", Imf::IntAttribute(1));
  header.insert("keyCode", Imf::KeyCodeAttribute(Imf::KeyCode()));
  header.insert("m33f", Imf::M33fAttribute(Imath::M33f()));
  header.insert("m33d", Imf::M33dAttribute(Imath::M33d()));
  header.insert("worldToCamera", Imf::M44fAttribute(Imath::M44f()));
  header.insert("m44d", Imf::M44dAttribute(Imath::M44d()));
  header.insert("framesPerSecond", Imf::RationalAttribute(Imf::Rational(24, 1)));
  header.insert("timeCode", Imf::TimeCodeAttribute(Imf::TimeCode()));
  header.insert("v2i", Imf::V2iAttribute(Imath::V2i(0, 0)));
  header.insert("v2f", Imf::V2fAttribute(Imath::V2f(0, 0)));
  header.insert("v2d", Imf::V2dAttribute(Imath::V2d(0, 0)));
  header.insert("v3i", Imf::V3iAttribute(Imath::V3i(0, 0, 0)));
  header.insert("v3f", Imf::V3fAttribute(Imath::V3f(0, 0, 0)));
  header.insert("v3d", Imf::V3dAttribute(Imath::V3d(0, 0, 0)));
  header.setPreviewImage(Imf::PreviewImage(4, 3));
  WriteExrKind(Path("a.exr"), header, image);
  ExpectSame(ReadImage(Path("a.exr")), image);
}

}  // namespace
}  // namespace skywave
