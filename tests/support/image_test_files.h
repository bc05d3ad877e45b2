// Shared helpers for the tests of image/: a folder per test, example pictures, and EXR files of all
// kinds that WriteExr does not produce.
#pragma once

#include <ImfChannelList.h>
#include <ImfFrameBuffer.h>
#include <ImfHeader.h>
#include <ImfOutputFile.h>
#include <ImfTiledOutputFile.h>
#include <gtest/gtest.h>
#include <half.h>
#include <unistd.h>

#include <bit>
#include <cmath>
#include <cstring>
#include <filesystem>
#include <string>
#include <utility>
#include <vector>

#include "base/error.h"
#include "base/files.h"
#include "image/image.h"

namespace skywave {

// A separate folder for every test, removed at its end.
class ImageFiles : public testing::Test {
 protected:
  void SetUp() override {
    const testing::TestInfo* const test = testing::UnitTest::GetInstance()->current_test_info();
    folder_ = testing::TempDir() + "skywave_" + std::to_string(::getpid()) + "_" + test->name();
    std::filesystem::create_directories(folder_);
  }
  void TearDown() override { std::filesystem::remove_all(folder_); }

  const std::string& folder() const { return folder_; }
  std::string Path(const std::string& name) const { return folder_ + "/" + name; }
  // Writes a file in the test's folder and returns its path.
  std::string Put(const std::string& name, const std::string& bytes) const {
    WriteFileAtomically(Path(name), bytes);
    return Path(name);
  }

 private:
  std::string folder_;
};

// Checks that `read` throws an InputError whose message has `word`.
template <class Read>
void ExpectUnreadable(const Read& read, const std::string& word) {
  try {
    read();
    ADD_FAILURE() << "not refused: " << word;
  } catch (const InputError& error) {
    EXPECT_NE(std::string(error.what()).find(word), std::string::npos) << error.what();
  }
}

// Returns a picture without symmetries, exactly representable in all formats and as integers.
inline Image Numbered(int width, int height) {
  Image image(width, height);
  for (int y = 0; y < height; ++y) {
    for (int x = 0; x < width; ++x) {
      float* const pixel = image.Pixel(x, y);
      pixel[0] = float(128 + (x * 7 + y * 31) % 128);
      pixel[1] = float((x + y * 5) % 256);
      pixel[2] = float((x * 3 + y * 11) % 256);
    }
  }
  return image;
}

inline std::vector<std::uint32_t> Bits(const Image& image) {
  std::vector<std::uint32_t> bits;
  for (const float value : image.rgb) bits.push_back(std::bit_cast<std::uint32_t>(value));
  return bits;
}

inline void ExpectSame(const Image& a, const Image& b) {
  EXPECT_EQ(a.width, b.width);
  EXPECT_EQ(a.height, b.height);
  EXPECT_EQ(Bits(a), Bits(b));
}

// Channels in the file and their types. R and Y hold the picture's red, G its green, B its blue;
// any other name holds -1 everywhere, which no reader may show.
using ExrChannels = std::vector<std::pair<std::string, Imf::PixelType>>;
inline const ExrChannels kFloatRgb = {{"R", Imf::FLOAT}, {"G", Imf::FLOAT}, {"B", Imf::FLOAT}};

// Returns the pixels of one channel in the type of the file.
inline std::string TypedPixels(const Image& image, const std::string& name, Imf::PixelType type) {
  const std::size_t channel = std::string("RGB").find(name == "Y" ? "R" : name);
  std::string bytes;
  for (std::size_t i = 0; i < image.rgb.size(); i += 3) {
    const float value = channel < 3 ? image.rgb[i + channel] : -1;
    const half as_half(value);
    const unsigned as_integer = value < 0 ? 0 : unsigned(value);
    if (type == Imf::HALF) bytes.append(reinterpret_cast<const char*>(&as_half), 2);
    if (type == Imf::FLOAT) bytes.append(reinterpret_cast<const char*>(&value), 4);
    if (type == Imf::UINT) bytes.append(reinterpret_cast<const char*>(&as_integer), 4);
  }
  return bytes;
}

// Writes `image`, tiled if `header` has a tile description. All levels below the first one hold the
// top left part of the picture.
inline void WriteExrKind(const std::string& path, Imf::Header header, const Image& image,
                         const ExrChannels& channels = kFloatRgb) {
  std::vector<std::string> pixels;
  for (const auto& [name, type] : channels) pixels.push_back(TypedPixels(image, name, type));
  Imf::FrameBuffer frame;
  for (std::size_t i = 0; i < channels.size(); ++i) {
    const auto& [name, type] = channels[i];
    header.channels().insert(name, Imf::Channel(type));
    frame.insert(name, Imf::Slice::Make(type, pixels[i].data(), header.dataWindow()));
  }
  if (!header.hasTileDescription()) {
    Imf::OutputFile file(path.c_str(), header, 0);
    file.setFrameBuffer(frame);
    file.writePixels(image.height);
    return;
  }
  Imf::TiledOutputFile file(path.c_str(), header, 0);
  file.setFrameBuffer(frame);
  for (int y = 0; y < file.numYLevels(); ++y) {
    for (int x = 0; x < file.numXLevels(); ++x) {
      if (!file.isValidLevel(x, y)) continue;
      file.writeTiles(0, file.numXTiles(x) - 1, 0, file.numYTiles(y) - 1, x, y);
    }
  }
}

inline Imf::Header HeaderFor(const Image& image, Imf::Compression compression) {
  Imf::Header header(image.width, image.height);
  header.compression() = compression;
  return header;
}

}  // namespace skywave
