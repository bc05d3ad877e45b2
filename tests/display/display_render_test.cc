// Tests what a viewer gets of a render, from the outside: the bits of the EXR, and nothing else on
// the way to it.
#include <ImfChannelList.h>
#include <ImfFrameBuffer.h>
#include <ImfHeader.h>
#include <ImfInputFile.h>
#include <gtest/gtest.h>

#include <map>
#include <string>
#include <vector>

#include "image/image.h"
#include "tests/support/program.h"
#include "tests/support/viewer.h"

namespace skywave {
namespace {

using DisplayRender = Program;

std::map<std::string, std::vector<float>> ChannelsOfExr(const std::string& path) {
  Imf::InputFile file(path.c_str());
  const Imath::Box2i window = file.header().dataWindow();
  const int width = window.max.x - window.min.x + 1, height = window.max.y - window.min.y + 1;
  std::map<std::string, std::vector<float>> channels;
  Imf::FrameBuffer buffer;
  for (auto i = file.header().channels().begin(); i != file.header().channels().end(); ++i) {
    std::vector<float>& values = channels[i.name()];
    values.resize(std::size_t(width) * std::size_t(height));
    buffer.insert(i.name(), Imf::Slice::Make(Imf::FLOAT, values.data(), window));
  }
  file.setFrameBuffer(buffer);
  file.readPixels(window.min.y, window.max.y);
  return channels;
}

// Bits, because layers may have NaN, and 0 and -0 are equal.
void ExpectSameBits(const std::map<std::string, std::vector<float>>& shown,
                    const std::map<std::string, std::vector<float>>& written) {
  ASSERT_EQ(shown.size(), written.size());
  for (const auto& [name, values] : written) {
    ASSERT_TRUE(shown.contains(name)) << name;
    ASSERT_EQ(shown.at(name).size(), values.size());
    EXPECT_EQ(std::memcmp(shown.at(name).data(), values.data(), values.size() * sizeof(float)), 0)
        << name;
  }
}

TEST_F(DisplayRender, EveryTileAndLayerHasTheBitsOfTheFile) {
  Viewer viewer;
  const Result result =
      Run("render gallery --size 210x150 --crop 190x133+13+7 --spp 64 --aovs "
          "albedo,normal,depth,direct --max-depth 3 -o a.exr --display " +
          viewer.address());
  ASSERT_EQ(result.exit_code, 0) << result.err;
  const auto pictures = viewer.Close();
  ASSERT_EQ(pictures.size(), 1u);
  const ViewedPicture& picture = pictures.at("a.exr");
  EXPECT_EQ(picture.width, 190);
  EXPECT_EQ(picture.height, 133);
  const auto written = ChannelsOfExr(Path("a.exr"));
  EXPECT_GE(written.size(), 3u + 3 + 3 + 1 + 3);
  ExpectSameBits(picture.channels, written);
  // Each of the 9 blocks is sent at the end, so there have been others on the way; and what they
  // showed was right.
  EXPECT_GT(picture.updates, 9);
  EXPECT_EQ(picture.replaced, 0);
}

TEST_F(DisplayRender, PassesAndSplatsEndWithTheBitsOfTheFile) {
  Viewer viewer;
  const Result result = Run(
      "render room --integrator vcm --size 64x48 --spp 4 -o b.exr --display " + viewer.address());
  ASSERT_EQ(result.exit_code, 0) << result.err;
  ExpectSameBits(viewer.Close().at("b.exr").channels, ChannelsOfExr(Path("b.exr")));
}

TEST_F(DisplayRender, APictureIsTheSameWithoutAViewer) {
  const std::string render = "render spheres --size 40x30 --spp 4 ";
  ASSERT_EQ(Run(render + "-o without.exr").exit_code, 0);
  std::string address;
  { address = Viewer(Viewer::Habit::kIgnores).address(); }
  const Result result = Run(render + "-o with.exr --display " + address);
  EXPECT_EQ(result.exit_code, 0);
  EXPECT_NE(result.err.find("note: the viewer at " + address + " cannot be reached ("),
            std::string::npos)
      << result.err;
  EXPECT_EQ(Bytes("without.exr"), Bytes("with.exr"));
  EXPECT_EQ(Run(render + "-o with.exr --display nobody:x").exit_code, 64);
}

TEST_F(DisplayRender, AViewerThatDoesNotReadEndsNoRender) {
  Viewer viewer(Viewer::Habit::kIgnores);
  const Result result =
      Run("render spheres --size 1200x900 --spp 1 -o a.exr --display " + viewer.address());
  EXPECT_EQ(result.exit_code, 0);
  EXPECT_NE(result.err.find(" does not read\n"), std::string::npos) << result.err;
}

}  // namespace
}  // namespace skywave
