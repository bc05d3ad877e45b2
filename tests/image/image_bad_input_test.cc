// Damaged, truncated, hostile and missing files end in an InputError: no crash, no partial picture,
// and no memory beyond what the size of the file justifies.

#include <ImfDeepFrameBuffer.h>
#include <ImfDeepScanLineOutputFile.h>
#include <ImfMultiPartOutputFile.h>
#include <ImfOutputPart.h>
#include <ImfRgbaFile.h>
#include <ImfStringVectorAttribute.h>
#include <zlib.h>

#include <atomic>
#include <cstdlib>
#include <filesystem>
#include <fstream>
#include <new>

#include "base/error.h"
#include "tests/support/image_test_files.h"

// Every allocation of the program, OpenEXR's included, is measured.
namespace {
std::atomic<std::size_t> largest_allocation{0};
}  // namespace

// It is not inlined because g++ would take new and free for a mismatched pair.
[[gnu::noinline]] void* operator new(std::size_t size) {
  if (size > largest_allocation) largest_allocation = size;
  if (void* const memory = std::malloc(size ? size : 1)) return memory;
  throw std::bad_alloc();
}
void* operator new[](std::size_t size) { return operator new(size); }
void* operator new(std::size_t size, const std::nothrow_t&) noexcept { return std::malloc(size); }
void* operator new[](std::size_t size, const std::nothrow_t&) noexcept { return std::malloc(size); }
[[gnu::noinline]] void operator delete(void* memory) noexcept { std::free(memory); }
void operator delete[](void* memory) noexcept { operator delete(memory); }
void operator delete(void* memory, std::size_t) noexcept { operator delete(memory); }
void operator delete[](void* memory, std::size_t) noexcept { operator delete(memory); }

namespace skywave {
namespace {

// [bytes] The largest single allocation for a file of a few hundred bytes: a damaged width within
// the limits can make OpenEXR's buffer of 32 rows this large.
constexpr std::size_t kSmall = std::size_t{16} << 20;

class BadInput : public ImageFiles {
 protected:
  // Returns small valid files, one for every path through the readers.
  std::vector<std::string> ValidFiles() const {
    const Image image = Numbered(11, 5);
    std::vector<std::string> files;
    for (const char* const name : {"a.exr", "a.pfm", "a.hdr"}) {
      WriteImage(Path(name), image);
      files.push_back(ReadFile(Path(name)));
    }
    for (const Imf::Compression compression :
         {Imf::NO_COMPRESSION, Imf::RLE_COMPRESSION, Imf::PIZ_COMPRESSION}) {
      WriteExrKind(Path("b.exr"), HeaderFor(image, compression), image);
      files.push_back(ReadFile(Path("b.exr")));
    }
    Imf::Header tiled = HeaderFor(image, Imf::ZIPS_COMPRESSION);
    tiled.setTileDescription(Imf::TileDescription(4, 4, Imf::MIPMAP_LEVELS));
    tiled.insert("views", Imf::StringVectorAttribute({"left", "right"}));
    WriteExrKind(Path("b.exr"), tiled, image,
                 {{"A", Imf::HALF}, {"B", Imf::HALF}, {"G", Imf::HALF}, {"R", Imf::HALF}});
    files.push_back(ReadFile(Path("b.exr")));
    WriteRgbe(Path("b.hdr"), Numbered(4, 3));  // plain pixels
    files.push_back(ReadFile(Path("b.hdr")));
    return files;
  }

  // Reads `bytes` as a picture and returns true if it is one. Anything but a whole picture or an
  // InputError is a failure.
  bool Reads(const std::string& bytes, const ReadLimits& limits = {}) {
    const std::string path = Path("input");
    std::ofstream(path, std::ios::binary) << bytes;
    largest_allocation = 0;
    try {
      const Image image = ReadImage(path, limits);
      EXPECT_LT(largest_allocation, kSmall);
      EXPECT_GE(image.width, 1);
      EXPECT_GE(image.height, 1);
      EXPECT_EQ(image.rgb.size(), std::size_t(image.width) * image.height * 3);
      return true;
    } catch (const InputError& error) {
      EXPECT_LT(largest_allocation, kSmall) << error.what();
      EXPECT_NE(std::string(error.what()).find(path), std::string::npos) << error.what();
      message_ = error.what();
      return false;
    }
  }
  const std::string& message() const { return message_; }

 private:
  std::string message_;
};

TEST_F(BadInput, EveryPrefixIsRefused) {
  for (const std::string& file : ValidFiles()) {
    ASSERT_TRUE(Reads(file)) << message();
    for (std::size_t length = 0; length < file.size(); ++length) {
      EXPECT_FALSE(Reads(file.substr(0, length))) << length << " of " << file.size();
    }
  }
}

TEST_F(BadInput, EveryFlippedBitIsSurvived) {
  int refused = 0;
  for (const std::string& file : ValidFiles()) {
    for (std::size_t bit = 0; bit < std::min<std::size_t>(file.size(), 700) * 8; ++bit) {
      std::string damaged = file;
      damaged[bit / 8] = char(damaged[bit / 8] ^ (1 << bit % 8));
      refused += !Reads(damaged);
    }
  }
  EXPECT_GT(refused, 1000);
}

// A map of 2^31 texels, whose file has all the bytes that its header promises, in no memory.
TEST_F(BadInput, MapsOfTooManyTexelsAreRefusedByTheirLimit) {
  const std::string header = "PF\n65536 32768\n-1\n";
  std::ofstream(Path("huge.pfm"), std::ios::binary) << header;
  std::filesystem::resize_file(Path("huge.pfm"), header.size() + (std::uintmax_t{12} << 31));
  largest_allocation = 0;
  try {
    ReadImage(Path("huge.pfm"));
    ADD_FAILURE() << "not refused";
  } catch (const InputError& error) {
    EXPECT_NE(std::string(error.what()).find("larger than the limit of 8589934592 bytes"),
              std::string::npos)
        << error.what();
  }
  EXPECT_LT(largest_allocation, kSmall);
  EXPECT_FALSE(Reads(header + "0123456789ab"));
  EXPECT_NE(message().find("65536 x 32768 is over the limit of 32768 x 32768 and 268435456 pixels"),
            std::string::npos)
      << message();
}

TEST_F(BadInput, HugeSizesAreRefusedBeforeAnythingIsAllocated) {
  for (const char* const size : {"999999999 999999999", "32769 1", "1 32769", "32768 32768", "0 5",
                                 "5 0", "-5 5", "99999999999999999999 1", "32768 8192"}) {
    EXPECT_FALSE(Reads("PF\n" + std::string(size) + "\n-1\n0123456789ab")) << size;
    std::string hdr = "#?RADIANCE\nFORMAT=32-bit_rle_rgbe\n\n-Y " + std::string(size);
    hdr.replace(hdr.rfind(' '), 1, " +X ");
    EXPECT_FALSE(Reads(hdr + "\n0123456789ab")) << size;
  }
  WriteExr(Path("a.exr"), Numbered(4, 4));
  const std::string exr = ReadFile(Path("a.exr"));
  const std::size_t box = exr.find("dataWindow") + 21;
  for (const auto& [width, height] :
       std::initializer_list<std::pair<std::uint32_t, std::uint32_t>>{{0x7fffffff, 0x7fffffff},
                                                                      {0x80000000, 4},
                                                                      {32769, 1},
                                                                      {1, 32769},
                                                                      {32768, 32768},
                                                                      {32768, 8192},
                                                                      {0, 4},
                                                                      {4, 0},
                                                                      {5, 4},
                                                                      {4, 17}}) {
    std::string damaged = exr;
    const std::uint32_t x_max = width - 1, y_max = height - 1;
    std::memcpy(&damaged[box + 8], &x_max, 4);
    std::memcpy(&damaged[box + 12], &y_max, 4);
    EXPECT_FALSE(Reads(damaged)) << width << " " << height;
  }
}

// The header and chunk table are flawless and describe a picture of gigabytes; only the chunks are
// too short.
TEST_F(BadInput, ExrOfFewBytesCannotClaimAHugePicture) {
  constexpr std::uint32_t kWidth = 32768, kHeight = 8192, kRowsPerChunk = 32;
  const Image image = Numbered(4, 4);
  WriteExrKind(Path("a.exr"), HeaderFor(image, Imf::PIZ_COMPRESSION), image);
  std::string exr = ReadFile(Path("a.exr"));
  exr.resize(exr.find("screenWindowWidth") + 33);  // name, type, size, value, end of header
  const std::size_t box = exr.find("dataWindow") + 21;
  const auto put = [](std::uint64_t number, int bytes, char* place) {
    std::memcpy(place, &number, std::size_t(bytes));
  };
  put(kWidth - 1, 4, &exr[box + 8]);
  put(kHeight - 1, 4, &exr[box + 12]);
  constexpr std::uint32_t kChunks = kHeight / kRowsPerChunk;
  const std::size_t table = exr.size(), chunks = table + kChunks * 8;
  exr.resize(chunks + kChunks * 9);
  for (std::uint32_t i = 0; i < kChunks; ++i) {
    put(chunks + i * 9, 8, &exr[table + i * 8]);
    put(i * kRowsPerChunk, 4, &exr[chunks + i * 9]);
    put(1, 4, &exr[chunks + i * 9 + 4]);
  }
  EXPECT_FALSE(Reads(exr));
  EXPECT_NE(message().find("too short"), std::string::npos) << message();
}

TEST_F(BadInput, LimitsOfTheCallerAreEnforced) {
  ReadLimits narrow, low, few;
  narrow.max_width = 10;
  low.max_height = 4;
  few.max_pixels = 54;
  for (const std::string& file : ValidFiles()) {
    if (file.find("-Y 3") != std::string::npos) continue;  // the one smaller picture
    for (const ReadLimits& limits : {narrow, low, few}) {
      EXPECT_FALSE(Reads(file, limits));
      EXPECT_NE(message().find("limit"), std::string::npos) << message();
    }
  }
}

TEST_F(BadInput, ErrorsSayWhereInTheFile) {
  EXPECT_FALSE(Reads("PF\n4 nine\n-1\n"));
  EXPECT_NE(message().find("(byte 3)"), std::string::npos) << message();
  // The scan line of 8 pixels contains a run of 100.
  EXPECT_FALSE(Reads("#?RADIANCE\nFORMAT=32-bit_rle_rgbe\n\n-Y 1 +X 8\n\x02\x02" +
                     std::string("\0\x08\xe4\x01", 4)));
  EXPECT_NE(message().find("(byte 50)"), std::string::npos) << message();
}

TEST_F(BadInput, TextWithoutAHeaderIsRefused) {
  const std::string pixels(4 * 8 * 4, '\x40');
  for (const char* const header :
       {"#RADIANCE\nFORMAT=32-bit_rle_rgbe\n\n-Y 4 +X 8\n", "#?RADIANCE\n\n-Y 4 +X 8\n",
        "#?RADIANCE\nFORMAT=32-bit_rle_abce\n\n-Y 4 +X 8\n",
        "#?RADIANCE\nFORMAT=32-bit_rle_rgbe\n\n-Y 4 -Y 8\n",
        "#?RADIANCE\nFORMAT=32-bit_rle_rgbe\n\n-Y 4 +X\n",
        "#?RADIANCE\nFORMAT=32-bit_rle_rgbe\n\n*Y 4 +X 8\n",
        "#?RADIANCE\nFORMAT=32-bit_rle_rgbe\n\n-Y 4x +X 8\n",
        "#?RADIANCE\nFORMAT=32-bit_rle_rgbe\n\n-Y 4 +X 8 9\n", "PX\n4 8\n-1\n", "PF\n4 8\n0\n",
        "PF\n4 8\nnan\n", "PF\n4 8\n-1x\n", "PF\n4\n\n8 -1\n", "P6\n4 8\n255\n",
        "\x89PNG\r\n\x1a\n"}) {
    EXPECT_FALSE(Reads(header + pixels)) << header;
  }
  EXPECT_TRUE(Reads("#?RADIANCE\nFORMAT=32-bit_rle_rgbe\n\n-Y 4 +X 8\n" + pixels)) << message();
  EXPECT_FALSE(Reads("#?RADIANCE\n" + std::string(200000, 'x')));
  EXPECT_FALSE(Reads("PF\n" + std::string(200000, '1')));
  EXPECT_FALSE(Reads("Pf\n4 4\n-1\n" + std::string(65, '\0'))) << "a byte too many";
}

// OpenEXR leaves the rest of such chunks uninitialised.
TEST_F(BadInput, ExrChunksThatDecodeToTooLittleAreRefused) {
  const Image image(16, 1);
  const auto with_pixels = [&](Imf::Compression compression, const std::string& stored) {
    WriteExrKind(Path("a.exr"), HeaderFor(image, compression), image);
    std::string exr = ReadFile(Path("a.exr"));
    std::uint64_t chunk = 0;  // the only one; its offset directly follows the header
    for (std::size_t i = exr.size(); i-- > 8;) {
      std::memcpy(&chunk, &exr[i - 8], 8);
      if (chunk == i) break;
    }
    const std::uint32_t size = std::uint32_t(stored.size());
    std::memcpy(&exr[chunk + 4], &size, 4);
    return exr.substr(0, chunk + 8) + stored;
  };
  // The data has 16 pixels of 12 bytes: one run of 128 bytes and one of 64, or of 63.
  EXPECT_TRUE(Reads(with_pixels(Imf::RLE_COMPRESSION, {127, 0, 63, 0}))) << message();
  EXPECT_FALSE(Reads(with_pixels(Imf::RLE_COMPRESSION, {127, 0, 62, 0})));
  EXPECT_FALSE(Reads(with_pixels(Imf::RLE_COMPRESSION, {127, 0, 64, 0})));
  EXPECT_FALSE(Reads(with_pixels(Imf::RLE_COMPRESSION, {127, 0, 63})));
  for (const uLong decoded : {192, 191, 193, 1}) {
    const std::string zeros(decoded, '\0');
    std::string deflated(200, '\0');
    uLongf size = uLongf(deflated.size());
    ASSERT_EQ(compress(reinterpret_cast<Bytef*>(deflated.data()), &size,
                       reinterpret_cast<const Bytef*>(zeros.data()), decoded),
              Z_OK);
    deflated.resize(size);
    EXPECT_EQ(Reads(with_pixels(Imf::ZIP_COMPRESSION, deflated)), decoded == 192) << decoded;
  }
}

// Once in a process of their own and once in this one.
TEST_F(BadInput, RiskyKindsOfExrAreRead) {
  ReadLimits trusting;
  trusting.trust_input = true;
  const Image image = Numbered(40, 36);
  for (const Imf::Compression compression :
       {Imf::PXR24_COMPRESSION, Imf::B44_COMPRESSION, Imf::B44A_COMPRESSION, Imf::DWAA_COMPRESSION,
        Imf::DWAB_COMPRESSION}) {
    WriteExrKind(Path("a.exr"), HeaderFor(image, compression), image,
                 {{"R", Imf::HALF}, {"G", Imf::HALF}, {"B", Imf::HALF}});
    const Image back = ReadImage(Path("a.exr"));
    ExpectSame(ReadImage(Path("a.exr"), trusting), back);
    ASSERT_EQ(back.rgb.size(), image.rgb.size());
    // All except PXR24 are lossy; 255 is the largest value of the picture.
    const float tolerance = compression == Imf::PXR24_COMPRESSION ? 0 : 64;
    for (std::size_t i = 0; i < image.rgb.size(); ++i) {
      EXPECT_NEAR(back.rgb[i], image.rgb[i], tolerance) << int(compression) << " " << i;
    }
  }
}

// The first part is a depth.
TEST_F(BadInput, FirstPartWithAPictureIsRead) {
  const Image image = Numbered(9, 5);
  std::string pixels[3];
  Imf::FrameBuffer frames[2];
  Imf::Header headers[2];
  for (int part = 0; part < 2; ++part) {
    headers[part] = HeaderFor(image, Imf::ZIP_COMPRESSION);
    headers[part].setName(part == 0 ? "depth" : "colours");
    headers[part].setType("scanlineimage");
  }
  for (int c = 0; c < 3; ++c) {
    const auto& [name, type] = kFloatRgb[std::size_t(c)];
    pixels[c] = TypedPixels(image, name, type);
    const Imf::Slice slice = Imf::Slice::Make(type, pixels[c].data(), headers[0].dataWindow());
    headers[1].channels().insert(name, type);
    frames[1].insert(name, slice);
    if (c > 0) continue;
    headers[0].channels().insert("Z", type);
    frames[0].insert("Z", slice);
  }
  {
    Imf::MultiPartOutputFile file(Path("a.exr").c_str(), headers, 2, false, 0);
    for (int part = 0; part < 2; ++part) {
      Imf::OutputPart output(file, part);
      output.setFrameBuffer(frames[part]);
      output.writePixels(image.height);
    }
  }
  ExpectSame(ReadImage(Path("a.exr")), image);
  ReadLimits trusting;
  trusting.trust_input = true;
  ExpectSame(ReadImage(Path("a.exr"), trusting), image);
  const std::string whole = ReadFile(Path("a.exr"));
  for (std::size_t length = 0; length < whole.size(); length += 41) {
    EXPECT_FALSE(Reads(whole.substr(0, length))) << length << " of " << whole.size();
  }
}

// One opaque sample per pixel.
TEST_F(BadInput, DeepPicturesAreComposited) {
  const Image image = Numbered(6, 4);
  Imf::Header header = HeaderFor(image, Imf::ZIPS_COMPRESSION);
  header.setType("deepscanline");
  std::vector<std::vector<float>> values(5, std::vector<float>(24));
  std::vector<std::vector<float*>> places(5, std::vector<float*>(24));
  std::vector<unsigned> counts(24, 1);
  Imf::DeepFrameBuffer frame;
  frame.insertSampleCountSlice(Imf::Slice(Imf::UINT, reinterpret_cast<char*>(counts.data()),
                                          sizeof(unsigned), 6 * sizeof(unsigned)));
  const char* const names[] = {"R", "G", "B", "A", "Z"};
  for (std::size_t c = 0; c < 5; ++c) {
    for (std::size_t i = 0; i < 24; ++i) {
      values[c][i] = c < 3 ? image.rgb[3 * i + c] : 1;
      places[c][i] = &values[c][i];
    }
    header.channels().insert(names[c], Imf::Channel(Imf::FLOAT));
    frame.insert(names[c], Imf::DeepSlice(Imf::FLOAT, reinterpret_cast<char*>(places[c].data()),
                                          sizeof(float*), 6 * sizeof(float*), sizeof(float)));
  }
  {
    Imf::DeepScanLineOutputFile file(Path("a.exr").c_str(), header, 0);
    file.setFrameBuffer(frame);
    file.writePixels(image.height);
  }
  ExpectSame(ReadImage(Path("a.exr")), image);
}

// A slope of colours, which survives that half of the chroma is left out. Filters of the library
// reach over 13 pixels.
TEST_F(BadInput, ChromaOfFewerSamplesIsInterpolated) {
  constexpr int kWidth = 64, kHeight = 48, kRim = 14;
  Image image(kWidth, kHeight);
  std::vector<Imf::Rgba> pixels;
  for (int y = 0; y < kHeight; ++y) {
    for (int x = 0; x < kWidth; ++x) {
      float* const color = image.Pixel(x, y);
      color[0] = 0.2f + 0.4f * float(x) / kWidth, color[1] = 0.4f;
      color[2] = 0.7f - 0.3f * float(y) / kHeight;
      pixels.emplace_back(color[0], color[1], color[2], 1);
    }
  }
  {
    Imf::RgbaOutputFile file(Path("a.exr").c_str(), kWidth, kHeight, Imf::WRITE_YC);
    file.setFrameBuffer(pixels.data(), 1, kWidth);
    file.writePixels(kHeight);
  }
  const Image read = ReadImage(Path("a.exr"));
  ASSERT_EQ(read.rgb.size(), image.rgb.size());
  for (int y = kRim; y < kHeight - kRim; ++y) {
    for (int x = kRim; x < kWidth - kRim; ++x) {
      for (int c = 0; c < 3; ++c) {
        EXPECT_NEAR(read.Pixel(x, y)[c], image.Pixel(x, y)[c], 0.005) << x << " " << y;
      }
    }
  }
}

TEST_F(BadInput, ExrOfOtherKindsThanItsFlagsSayIsRefused) {
  WriteExr(Path("a.exr"), Numbered(4, 4));
  std::string exr = ReadFile(Path("a.exr"));
  for (const int flag : {0x08, 0x10}) {  // deep, several parts
    std::string other = exr;
    other[5] = char(other[5] | flag);
    EXPECT_FALSE(Reads(other)) << flag;
  }
  // Channel B has its name, type and hint, then the sampling rate in x.
  const std::size_t channel_b = exr.find("chlist") + 11;
  ASSERT_EQ(exr[channel_b], 'B');
  exr[channel_b + 10] = 2;
  EXPECT_FALSE(Reads(exr));
  EXPECT_NE(message().find("sub-sampled"), std::string::npos) << message();
}

TEST_F(BadInput, ErrorsReachTerminalsWithoutControlCodes) {
  WriteExrKind(Path("a.exr"), HeaderFor(Numbered(2, 2), Imf::ZIP_COMPRESSION), Numbered(2, 2),
               {{"\x1b[31mX", Imf::FLOAT}, {"Y2", Imf::FLOAT}});
  EXPECT_FALSE(Reads(ReadFile(Path("a.exr"))));
  EXPECT_EQ(message().find('\x1b'), std::string::npos);
  EXPECT_NE(message().find("?[31mX"), std::string::npos) << message();
}

TEST_F(BadInput, MissingFilesAndFolders) {
  for (const std::string& path : {Path("missing.exr"), folder(), std::string()}) {
    try {
      ReadImage(path);
      ADD_FAILURE() << path;
    } catch (const InputError& error) {
      EXPECT_EQ(error.exit_code(), kExitIo) << error.what();
    }
    EXPECT_THROW(ReadExrMetadata(path), InputError);
  }
  EXPECT_THROW(ReadExrMetadata(Put("a.pfm", "PF\n1 1\n-1\n0123456789ab")), InputError);
}

TEST_F(BadInput, UnwritableOutputLeavesNothingBehind) {
  std::filesystem::create_directory(Path("a.exr"));
  std::filesystem::create_directory(Path("a.pfm"));
  std::filesystem::create_directory(Path("a.hdr"));
  std::filesystem::create_directory(Path("a.png"));
  const Image image = Numbered(3, 3);
  const std::vector<std::uint8_t> rgb(27);
  for (const char* const place : {"a", "missing/a"}) {
    for (const char* const ending : {".exr", ".pfm", ".hdr"}) {
      EXPECT_THROW(WriteImage(Path(place) + ending, image), InputError) << place << ending;
    }
    EXPECT_THROW(WritePng(Path(place) + ".png", 3, 3, rgb), InputError) << place;
  }
  // The names are one that OpenEXR reserves, an empty one, and one longer than a file can hold.
  for (const std::string& name : {std::string("channels"), std::string(), std::string(256, 'n')}) {
    EXPECT_THROW(WriteExr(Path("b.exr"), image, {{name, "text"}}), InputError) << name;
  }
  int entries = 0;
  for (const auto& entry : std::filesystem::directory_iterator(folder())) {
    EXPECT_TRUE(entry.is_directory()) << entry.path();
    ++entries;
  }
  EXPECT_EQ(entries, 4);
}

}  // namespace
}  // namespace skywave
