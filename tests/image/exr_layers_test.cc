// Tests pictures that are a layer or a part of an OpenEXR file: "FILE:LAYER".
#include <ImfChannelList.h>
#include <ImfFrameBuffer.h>
#include <ImfHeader.h>
#include <ImfMultiPartOutputFile.h>
#include <ImfOutputPart.h>
#include <ImfPartType.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <string>
#include <vector>

#include "base/error.h"
#include "base/files.h"
#include "image/image.h"
#include "tests/support/temporary_folder.h"

namespace skywave {
namespace {

Image Filled(float value) {
  Image image(4, 2);
  std::fill(image.rgb.begin(), image.rgb.end(), value);
  return image;
}

class ExrLayers : public testing::Test {
 protected:
  std::string Path(const std::string& name) { return folder_.Path(name); }

  void WriteLayers(const std::string& name) {
    const auto channel = [](const char* of, float value) {
      return NamedChannel{of, std::vector<float>(8, value)};
    };
    WriteExr(
        Path(name), Filled(1), {},
        {channel("sky.R", 2), channel("sky.G", 3), channel("sky.B", 4), channel("view.sun.r", 5),
         channel("view.sun.g", 6), channel("view.sun.b", 7), channel("depth.Z", 8)});
  }

  // Writes parts of those names, whose pixels are 10, 11 and so on.
  void WriteParts(const std::string& name, const std::vector<std::string>& parts) {
    std::vector<Imf::Header> headers;
    for (const std::string& part : parts) {
      Imf::Header& header = headers.emplace_back(4, 2);
      header.setName(part);
      header.setType(Imf::SCANLINEIMAGE);
      for (const char* const channel : {"R", "G", "B"}) {
        header.channels().insert(channel, Imf::Channel(Imf::FLOAT));
      }
    }
    Imf::MultiPartOutputFile file(Path(name).c_str(), headers.data(), int(headers.size()));
    for (std::size_t i = 0; i < parts.size(); ++i) {
      std::vector<float> values(8, 10 + float(i));
      Imf::FrameBuffer frame;
      for (const char* const channel : {"R", "G", "B"}) {
        frame.insert(channel, Imf::Slice::Make(Imf::FLOAT, values.data(), headers[i].dataWindow()));
      }
      Imf::OutputPart part(file, int(i));
      part.setFrameBuffer(frame);
      part.writePixels(2);
    }
  }

  std::string ErrorOf(const std::string& name) {
    try {
      ReadImage(Path(name), kTrusted);
    } catch (const InputError& error) {
      return error.what();
    }
    return "";
  }

  static constexpr ReadLimits kTrusted = {.trust_input = true};
  TemporaryFolder folder_;
};

TEST_F(ExrLayers, AreReadByTheirNames) {
  WriteLayers("a.exr");
  EXPECT_EQ(ReadImage(Path("a.exr")).rgb, Filled(1).rgb);
  const Image sky = ReadImage(Path("a.exr:sky"));
  EXPECT_EQ((std::vector<float>(sky.rgb.begin(), sky.rgb.begin() + 3)),
            (std::vector<float>{2, 3, 4}));
  const Image sun = ReadTexture(Path("a.exr:view.sun"), Encoding::kSrgb);
  EXPECT_EQ((std::vector<float>(sun.rgb.begin(), sun.rgb.begin() + 3)),
            (std::vector<float>{5, 6, 7}));
  EXPECT_EQ(ReadImage(Path("a.exr:depth")).rgb, Filled(8).rgb);
  EXPECT_EQ(ReadImage(Path("a.exr:depth.Z")).rgb, Filled(8).rgb);
  EXPECT_EQ(ReadImage(Path("a.exr:view")).rgb, sun.rgb);  // the only one within
}

TEST_F(ExrLayers, ArePictureAndLayersBesideIt) {
  WriteLayers("a.exr");
  const LayeredImage sky = ReadLayeredImage(Path("a.exr:sky"), {"depth.Z"});
  EXPECT_EQ(sky.image.rgb[1], 3);
  EXPECT_EQ(sky.layers[0].values[0], 8);
  const std::vector<std::string> beside = ReadLayerNames(Path("a.exr:sky"));
  EXPECT_EQ(std::count(beside.begin(), beside.end(), "sky.R"), 0);
  EXPECT_EQ(std::count(beside.begin(), beside.end(), "R"), 1);
}

TEST_F(ExrLayers, MayBePartsOfAFile) {
  WriteParts("parts.exr", {"left", "right"});
  EXPECT_EQ(ReadImage(Path("parts.exr"), kTrusted).rgb, Filled(10).rgb);
  EXPECT_EQ(ReadImage(Path("parts.exr:right"), kTrusted).rgb, Filled(11).rgb);
  EXPECT_NE(ErrorOf("parts.exr:middle").find("has no layer middle; there are left, right"),
            std::string::npos)
      << ErrorOf("parts.exr:middle");
}

TEST_F(ExrLayers, ThatAreNotThereAreNamedWithThoseThatAre) {
  WriteLayers("a.exr");
  const std::string error = ErrorOf("a.exr:sea");
  EXPECT_NE(error.find("has no layer sea; there are depth, sky, view.sun"), std::string::npos)
      << error;
  WriteExr(Path("plain.exr"), Filled(1));
  EXPECT_NE(ErrorOf("plain.exr:sky").find("has no layer sky; it has none at all"),
            std::string::npos);
  WritePfm(Path("a.pfm"), Filled(1));
  EXPECT_NE(ErrorOf("a.pfm:sky").find("only OpenEXR files have layers"), std::string::npos);
}

// A name with a colon is that of a file where there is one.
TEST_F(ExrLayers, DoNotHideFilesWithColons) {
  WriteLayers("a.exr");
  WriteExr(Path("a.exr:sky"), Filled(9));
  EXPECT_EQ(ReadImage(Path("a.exr:sky")).rgb, Filled(9).rgb);
  EXPECT_EQ(SplitFileName("nowhere.exr:sky").path, "nowhere.exr:sky");
  EXPECT_THROW(ReadImage(Path("b.exr:sky")), InputError);
}

}  // namespace
}  // namespace skywave
