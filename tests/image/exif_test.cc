// Tests the reader of exposures in JPEGs against bytes written by hand, in both orders of bytes,
// and against every truncation of them.
#include "image/exif.h"

#include <gtest/gtest.h>

#include <string>

namespace skywave {
namespace {

struct Writer {
  bool big_endian;
  std::string bytes;
  void Put(std::uint32_t value, int size) {
    for (int i = 0; i < size; ++i) {
      const int shift = 8 * (big_endian ? size - 1 - i : i);
      bytes += char((value >> shift) & 0xFF);
    }
  }
  void Entry(std::uint32_t tag, std::uint32_t type, std::uint32_t value, int size = 4) {
    Put(tag, 2), Put(type, 2), Put(1, 4), Put(value, size);
    bytes.append(std::size_t(4 - size), '\0');
  }
};

// A JPEG of 1/125 s, f/5.6, ISO 400, after a segment of another application.
std::string Jpeg(bool big_endian) {
  Writer tiff = {big_endian, big_endian ? "MM" : "II"};
  tiff.Put(42, 2), tiff.Put(8, 4);
  tiff.Put(2, 2);
  tiff.Entry(0x0112, 3, 1, 2);
  tiff.Entry(0x8769, 4, 38);
  tiff.Put(0, 4);
  tiff.Put(3, 2);  // at 38
  tiff.Entry(0x829A, 5, 80);
  tiff.Entry(0x829D, 5, 88);
  tiff.Entry(0x8827, 3, 400, 2);
  tiff.Put(0, 4);
  tiff.Put(1, 4), tiff.Put(125, 4);  // at 80
  tiff.Put(28, 4), tiff.Put(5, 4);
  const std::string exif = std::string("Exif\0\0", 6) + tiff.bytes;
  const auto segment = [](char kind, const std::string& contents) {
    const std::size_t length = contents.size() + 2;
    return std::string("\xFF") + kind + char(length >> 8) + char(length & 0xFF) + contents;
  };
  return "\xFF\xD8" + segment('\xE0', "JFIF") + segment('\xE1', exif) + "\xFF\xDA";
}

TEST(Exif, TellsTheExposureInEitherOrderOfBytes) {
  for (const bool big_endian : {false, true}) {
    const CameraExposure camera = ReadCameraExposure(Jpeg(big_endian) + "rest of the file");
    EXPECT_DOUBLE_EQ(camera.seconds.value_or(0), 1 / 125.0);
    EXPECT_DOUBLE_EQ(camera.f_number.value_or(0), 5.6);
    EXPECT_DOUBLE_EQ(camera.iso.value_or(0), 400);
  }
}

TEST(Exif, DamagedFilesTellNothingThatIsNotThere) {
  const std::string whole = Jpeg(false);
  for (std::size_t size = 0; size + 2 < whole.size(); ++size) {
    const CameraExposure camera = ReadCameraExposure(whole.substr(0, size));
    EXPECT_FALSE(camera.seconds || camera.f_number || camera.iso) << size << " bytes";
  }
  EXPECT_FALSE(ReadCameraExposure("\x89PNG\r\n\x1a\n").seconds);
  std::string no_time = whole;
  no_time[whole.find(std::string("\x01\0\0\0\x7D", 5))] = 0;
  const CameraExposure camera = ReadCameraExposure(no_time);
  EXPECT_FALSE(camera.seconds);
  EXPECT_TRUE(camera.iso);
}

}  // namespace
}  // namespace skywave
