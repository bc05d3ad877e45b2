// Reads and writes Radiance RGBE pictures (Greg Ward's .hdr): a text header, a resolution line and
// scan lines of pixels with a common exponent.
//
// A pixel is exactly mantissa * 2^(exponent - 136); exponent 0 is black. Radiance's own programs
// add half a mantissa step when decoding; most others, and this one, do not. EXPOSURE and COLORCORR
// say by what the numbers were multiplied, and are divided by again; PRIMARIES, if they make a
// space, say what the colours are. GAMMA is not applied. Bytes after the last scan line are
// ignored.

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cassert>
#include <charconv>
#include <cmath>
#include <optional>

#include "base/files.h"
#include "image/byte_cursor.h"
#include "image/formats.h"
#include "image/primaries.h"

namespace skywave {
namespace {

using Rgbe = std::array<std::uint8_t, 4>;

constexpr std::size_t kMaxRgbeHeaderBytes = 1 << 16;
// Run-length coding by channel exists only for scan lines of these lengths.
constexpr int kMinRunLengthWidth = 8;
constexpr int kMaxRunLengthWidth = 0x7fff;

// The order in which the scan lines of a file run through the picture.
struct Layout {
  int lines = 0;         // scan lines in the file
  int line_length = 0;   // pixels per scan line
  bool by_rows = true;   // a scan line is a row (else a column)
  bool x_falls = false;  // from right to left
  bool y_rises = false;  // from bottom to top

  int width() const { return by_rows ? line_length : lines; }
  int height() const { return by_rows ? lines : line_length; }
};

std::string_view TakeLine(ByteCursor& cursor, const char* what) {
  std::string_view line = cursor.TakeUntil('\n', kMaxRgbeHeaderBytes, what);
  if (!line.empty() && line.back() == '\r') line.remove_suffix(1);
  return line;
}

// What the lines of a header say of the numbers in the file.
struct Header {
  bool is_xyz = false;  // the channels are CIE X, Y and Z
  std::array<double, 3> multiplied = {1, 1, 1};
  std::optional<RgbPrimaries> primaries;
};

// Returns the numbers of a line after "NAME=", which has so many.
template <std::size_t kCount>
std::array<double, kCount> TakeNumbers(ByteCursor& cursor, std::string_view line) {
  std::array<double, kCount> numbers = {};
  const std::string_view name = line.substr(0, line.find('='));
  std::string_view rest = line.substr(name.size() + 1);
  for (double& number : numbers) {
    rest.remove_prefix(std::min(rest.find_first_not_of(" \t+"), rest.size()));
    const auto [end, error] = std::from_chars(rest.data(), rest.data() + rest.size(), number);
    if (error != std::errc() || !std::isfinite(number)) {
      cursor.Fail(fmt::format("the Radiance header's line {} has not {} numbers", name, kCount));
    }
    rest.remove_prefix(std::size_t(end - rest.data()));
  }
  return numbers;
}

Header ReadHeader(ByteCursor& cursor) {
  // Programs write their own name after these two characters.
  if (!TakeLine(cursor, "the Radiance header").starts_with("#?")) {
    cursor.Fail("is not a Radiance picture: it does not start with #?");
  }
  Header header;
  bool has_format = false;
  while (true) {
    const std::string_view line = TakeLine(cursor, "the Radiance header");
    if (cursor.offset() > kMaxRgbeHeaderBytes) cursor.Fail("the Radiance header has no end");
    if (line.empty()) break;
    const auto multiply = [&](const std::array<double, 3>& factors) {
      for (std::size_t c = 0; c < 3; ++c) {
        header.multiplied[c] *= factors[c];
        if (!(header.multiplied[c] > 0) || !std::isfinite(header.multiplied[c])) {
          cursor.Fail(fmt::format("the Radiance header's line {} is no exposure", line));
        }
      }
    };
    if (line.starts_with("EXPOSURE=")) {
      const double factor = TakeNumbers<1>(cursor, line)[0];
      multiply({factor, factor, factor});
    } else if (line.starts_with("COLORCORR=")) {
      multiply(TakeNumbers<3>(cursor, line));
    } else if (line.starts_with("PRIMARIES=")) {
      const auto [rx, ry, gx, gy, bx, by, wx, wy] = TakeNumbers<8>(cursor, line);
      const RgbPrimaries primaries = {{rx, ry}, {gx, gy}, {bx, by}, {wx, wy}};
      if (IsRgbSpace(primaries)) header.primaries = primaries;
    } else if (line.starts_with("FORMAT=")) {
      header.is_xyz = line == "FORMAT=32-bit_rle_xyze";
      if (!header.is_xyz && line != "FORMAT=32-bit_rle_rgbe") {
        cursor.Fail(std::string(line) +
                    " is not supported, only FORMAT=32-bit_rle_rgbe and 32-bit_rle_xyze");
      }
      has_format = true;
    }
  }
  if (!has_format) cursor.Fail("the Radiance header has no line FORMAT=32-bit_rle_rgbe");
  return header;
}

// Parses "-Y 512 +X 1024", with the slow axis first. -Y runs down, +X to the right.
Layout ReadResolution(ByteCursor& cursor, const std::string& path, const ReadLimits& limits) {
  const InputPosition position = InputPosition::Byte(path, cursor.offset());
  std::string_view line = TakeLine(cursor, "the Radiance resolution line");
  // Some programs pad the numbers.
  const auto take = [&] {
    line.remove_prefix(std::min(line.find_first_not_of(' '), line.size()));
    const std::string_view word = line.substr(0, line.find(' '));
    line.remove_prefix(word.size());
    return word;
  };
  const std::string_view slow = take();
  const std::int64_t lines = ParseSize(take());
  const std::string_view fast = take();
  const std::int64_t line_length = ParseSize(take());
  const auto is_axis = [](std::string_view word) {
    return word.size() == 2 && (word[0] == '+' || word[0] == '-') &&
           (word[1] == 'X' || word[1] == 'Y');
  };
  if (!is_axis(slow) || !is_axis(fast) || slow[1] == fast[1] || lines < 0 || line_length < 0 ||
      !take().empty()) {
    throw InputError(position, "the Radiance resolution line is not like \"-Y 512 +X 1024\"");
  }
  const bool by_rows = slow[1] == 'Y';
  CheckSize(position, by_rows ? line_length : lines, by_rows ? lines : line_length, limits);
  // The longest runs of these formats, of all four bytes of a pixel, are far shorter on average.
  constexpr std::uint64_t kPixelsPerByte = 128, kFewPixels = 1 << 22;
  const std::uint64_t pixels = std::uint64_t(lines) * std::uint64_t(line_length);
  if (pixels > kFewPixels && pixels / kPixelsPerByte > cursor.left()) {
    throw InputError(position, fmt::format("a picture of {} x {} pixels in {} bytes is refused",
                                           by_rows ? line_length : lines,
                                           by_rows ? lines : line_length, cursor.left()));
  }
  return {.lines = int(lines),
          .line_length = int(line_length),
          .by_rows = by_rows,
          .x_falls = (by_rows ? fast : slow)[0] == '-',
          .y_rises = (by_rows ? slow : fast)[0] == '+'};
}

// Reads one channel after another. A code above 128 repeats one byte (code - 128) times; any other
// code is a count of bytes to copy.
void ReadChannelRuns(ByteCursor& cursor, std::vector<Rgbe>& line) {
  for (int channel = 0; channel < 4; ++channel) {
    for (std::size_t x = 0; x < line.size();) {
      const std::uint8_t code = cursor.U8("a scan line");
      const bool repeat = code > 128;
      const std::size_t count = repeat ? code - 128 : code;
      if (count == 0) cursor.Fail("an empty run in a scan line");
      if (count > line.size() - x) cursor.Fail("a run goes over the end of its scan line");
      const std::string_view source = cursor.Take(repeat ? 1 : count, "a scan line");
      for (std::size_t i = 0; i < count; ++i) {
        line[x++][channel] = std::uint8_t(source[repeat ? 0 : i]);
      }
    }
  }
}

// Reads plain pixels. A pixel with mantissas 1, 1, 1 repeats the previous pixel; its last byte is
// the count. Consecutive pixels of this kind hold the bytes of one count, the lowest first.
void ReadPixelRuns(ByteCursor& cursor, std::vector<Rgbe>& line) {
  int shift = 0;
  for (std::size_t x = 0; x < line.size();) {
    const std::string_view bytes = cursor.Take(4, "a scan line");
    Rgbe pixel;
    for (int i = 0; i < 4; ++i) pixel[i] = std::uint8_t(bytes[i]);
    if (pixel[0] != 1 || pixel[1] != 1 || pixel[2] != 1) {
      line[x++] = pixel;
      shift = 0;
      continue;
    }
    if (x == 0) cursor.Fail("a scan line starts with a repetition of nothing");
    if (shift > 24) cursor.Fail("a repetition has more than four bytes of count");
    const std::size_t count = std::size_t(pixel[3]) << shift;
    if (count > line.size() - x) cursor.Fail("a run goes over the end of its scan line");
    for (std::size_t i = 0; i < count; ++i, ++x) line[x] = line[x - 1];
    shift += 8;
  }
}

void ReadScanLine(ByteCursor& cursor, std::string_view bytes, std::vector<Rgbe>& line) {
  const std::string_view start = bytes.substr(cursor.offset(), 4);
  const bool can_be_coded = line.size() >= kMinRunLengthWidth && line.size() <= kMaxRunLengthWidth;
  if (can_be_coded && start.size() == 4 && start[0] == 2 && start[1] == 2 &&
      std::uint8_t(start[2]) < 128) {
    const std::size_t length = std::size_t(start[2]) << 8 | std::uint8_t(start[3]);
    if (length != line.size()) {
      cursor.Fail("a scan line of " + std::to_string(length) + " pixels instead of " +
                  std::to_string(line.size()));
    }
    cursor.Take(4, "a scan line");
    return ReadChannelRuns(cursor, line);
  }
  ReadPixelRuns(cursor, line);
}

std::array<float, 256> MantissaUnits() {
  std::array<float, 256> units{};  // units[0] stays 0: exponent 0 is black
  for (int e = 1; e < 256; ++e) units[e] = std::ldexp(1.0f, e - 136);
  return units;
}

// Returns the nearest RGBE colour. Values outside the format's range are clamped: negative values,
// NaN and values below 2^-128 to 0, large ones to 255 * 2^119.
Rgbe Encode(const float* rgb) {
  constexpr double kLargest = 0x1.FEp126;  // 255 * 2^119
  double value[3], largest = 0;
  for (int c = 0; c < 3; ++c) {
    value[c] = rgb[c] > 0 ? std::min(double(rgb[c]), kLargest) : 0;
    largest = std::max(largest, value[c]);
  }
  int exponent = 0;
  std::frexp(largest, &exponent);
  // The mantissa of the largest channel is in [128, 256) unless rounding gives 256.
  if (std::nearbyint(std::ldexp(largest, 8 - exponent)) == 256) ++exponent;
  if (largest == 0 || exponent + 128 < 1) return {};
  Rgbe encoded;
  for (int c = 0; c < 3; ++c) {
    encoded[c] = std::uint8_t(std::nearbyint(std::ldexp(value[c], 8 - exponent)));
  }
  encoded[3] = std::uint8_t(exponent + 128);
  return encoded;
}

void AppendChannelRuns(const std::vector<Rgbe>& line, std::string& bytes) {
  constexpr std::size_t kMaxRepeat = 127, kMaxCopy = 128;
  constexpr std::size_t kWorthwhileRepeat = 4;  // shorter runs cost more than copying
  bytes += {2, 2, char(line.size() >> 8), char(line.size() & 255)};
  for (int channel = 0; channel < 4; ++channel) {
    const auto run_length = [&](std::size_t x) {
      std::size_t end = x + 1;
      while (end < line.size() && end - x < kMaxRepeat && line[end][channel] == line[x][channel]) {
        ++end;
      }
      return end - x;
    };
    for (std::size_t x = 0; x < line.size();) {
      if (const std::size_t repeat = run_length(x); repeat >= kWorthwhileRepeat) {
        bytes += {char(128 + repeat), char(line[x][channel])};
        x += repeat;
        continue;
      }
      std::size_t end = x;
      while (end < line.size() && end - x < kMaxCopy && run_length(end) < kWorthwhileRepeat) ++end;
      bytes += char(end - x);
      for (; x < end; ++x) bytes += char(line[x][channel]);
    }
  }
}

}  // namespace

Image DecodeRgbe(const std::string& path, std::string_view bytes, const ReadLimits& limits) {
  ByteCursor cursor(path, bytes);
  const Header header = ReadHeader(cursor);
  const Layout layout = ReadResolution(cursor, path, limits);

  // The picture is allocated after all lines have been read, so that memory follows the contents of
  // the file, not the claims of its header.
  std::vector<Rgbe> pixels;
  std::vector<Rgbe> line(layout.line_length);
  for (int i = 0; i < layout.lines; ++i) {
    ReadScanLine(cursor, bytes, line);
    pixels.insert(pixels.end(), line.begin(), line.end());
  }

  static const std::array<float, 256> kUnits = MantissaUnits();
  Image image(layout.width(), layout.height());
  for (int i = 0; i < layout.lines; ++i) {
    for (int j = 0; j < layout.line_length; ++j) {
      const int column = layout.by_rows ? j : i;
      const int row = layout.by_rows ? i : j;
      float* const pixel = image.Pixel(layout.x_falls ? image.width - 1 - column : column,
                                       layout.y_rises ? image.height - 1 - row : row);
      const Rgbe& rgbe = pixels[std::size_t(i) * layout.line_length + j];
      for (int c = 0; c < 3; ++c) pixel[c] = rgbe[c] * kUnits[rgbe[3]];
    }
  }
  const auto [r, g, b] = header.multiplied;
  if (r != 1 || g != 1 || b != 1) ConvertColors({1 / r, 0, 0, 0, 1 / g, 0, 0, 0, 1 / b}, image);
  if (header.is_xyz) {
    ConvertColors(glm::inverse(XyzFromRgb(kRec709)), image);
  } else if (header.primaries) {
    ConvertToRec709(*header.primaries, image);
  }
  return image;
}

void WriteRgbe(const std::string& path, const Image& image) {
  assert(image.rgb.size() == std::size_t(image.width) * image.height * 3);
  std::string bytes = "#?RADIANCE\nFORMAT=32-bit_rle_rgbe\n\n-Y " + std::to_string(image.height) +
                      " +X " + std::to_string(image.width) + "\n";
  const bool can_be_coded = image.width >= kMinRunLengthWidth && image.width <= kMaxRunLengthWidth;
  std::vector<Rgbe> line(image.width);
  for (int y = 0; y < image.height; ++y) {
    for (int x = 0; x < image.width; ++x) line[x] = Encode(image.Pixel(x, y));
    if (can_be_coded) {
      AppendChannelRuns(line, bytes);
    } else {
      for (const Rgbe& pixel : line) bytes.append(pixel.begin(), pixel.end());
    }
  }
  WriteFileAtomically(path, bytes);
}

}  // namespace skywave
