#include "image/exr_header.h"

#include <algorithm>
#include <bit>
#include <map>
#include <set>

#include "image/byte_cursor.h"
#include "image/formats.h"

namespace skywave {
namespace {

constexpr std::uint32_t kMagic = 0x01312f76;
constexpr std::uint32_t kVersion = 2;
constexpr std::uint32_t kVersionMask = 0xff;
constexpr std::uint32_t kTiledFlag = 0x200;
constexpr std::uint32_t kLongNamesFlag = 0x400;
constexpr std::uint32_t kDeepFlag = 0x800;
constexpr std::uint32_t kMultiPartFlag = 0x1000;
constexpr std::uint32_t kKnownFlags =
    kVersionMask | kTiledFlag | kLongNamesFlag | kDeepFlag | kMultiPartFlag;

constexpr std::size_t kMaxShortName = 31;
constexpr std::size_t kMaxLongName = 255;
constexpr std::size_t kMaxHeaderBytes = std::size_t{16} << 20;
constexpr int kMaxAttributes = 1024;
constexpr std::size_t kMaxChannels = 1024;
constexpr std::size_t kMaxParts = 1024;
// Windows farther out occur only in damaged files, and their arithmetic would overflow in the
// library.
constexpr std::int32_t kMaxCoordinate = 1 << 28;

struct Attribute {
  std::string name;
  std::string_view type;
  std::size_t offset = 0;  // [bytes] position of the value in the file
  std::size_t size = 0;    // [bytes] size of the value
};

// Returns the attributes that a header must have, and their types.
const std::map<std::string, std::string_view, std::less<>>& RequiredAttributes() {
  static const std::map<std::string, std::string_view, std::less<>> kRequired = {
      {"channels", "chlist"},        {"compression", "compression"}, {"dataWindow", "box2i"},
      {"displayWindow", "box2i"},    {"lineOrder", "lineOrder"},     {"pixelAspectRatio", "float"},
      {"screenWindowCenter", "v2f"}, {"screenWindowWidth", "float"}};
  return kRequired;
}

// Returns the sizes [bytes] of the types of fixed size, which the library reads without checking
// them.
const std::map<std::string_view, std::size_t>& FixedSizes() {
  static const std::map<std::string_view, std::size_t> kSizes = {{"box2f", 16},
                                                                 {"box2i", 16},
                                                                 {"chromaticities", 32},
                                                                 {"compression", 1},
                                                                 {"deepImageState", 1},
                                                                 {"double", 8},
                                                                 {"envmap", 1},
                                                                 {"float", 4},
                                                                 {"int", 4},
                                                                 {"keycode", 28},
                                                                 {"lineOrder", 1},
                                                                 {"m33d", 72},
                                                                 {"m33f", 36},
                                                                 {"m44d", 128},
                                                                 {"m44f", 64},
                                                                 {"rational", 8},
                                                                 {"tiledesc", 9},
                                                                 {"timecode", 8},
                                                                 {"v2d", 16},
                                                                 {"v2f", 8},
                                                                 {"v2i", 8},
                                                                 {"v3d", 24},
                                                                 {"v3f", 12},
                                                                 {"v3i", 12}};
  return kSizes;
}

// Reads the headers of a file, one after the other; the members are shared by all steps.
class HeaderParser {
 public:
  HeaderParser(const std::string& path, std::string_view bytes, const ReadLimits& limits)
      : path_(path), bytes_(bytes), limits_(limits), cursor_(path, bytes) {}

  std::vector<ExrHeader> Parse() {
    ParseVersion();
    if (!version_.multi_part) return {ParsePart()};
    std::vector<ExrHeader> parts;
    while (!AtEndOfHeaders()) {
      if (parts.size() == kMaxParts) cursor_.Fail("too many parts");
      parts.push_back(ParsePart());
      parts.back().part = int(parts.size()) - 1;
    }
    if (parts.empty()) cursor_.Fail("an EXR without parts");
    std::size_t table = cursor_.offset();
    for (ExrHeader& part : parts) {
      part.end = table;
      table += 8 * std::size_t(part.chunk_count);
    }
    if (table > bytes_.size()) cursor_.Fail("the file ends within the chunk tables");
    return parts;
  }

 private:
  void ParseVersion() {
    if (cursor_.U32("the EXR magic number") != kMagic) cursor_.Fail("is no OpenEXR file");
    const std::uint32_t version = cursor_.U32("the EXR version");
    if ((version & kVersionMask) != kVersion || (version & ~kKnownFlags) != 0) {
      cursor_.Fail("an EXR version or feature that is not supported");
    }
    version_.tiled = version & kTiledFlag;
    version_.deep = version & kDeepFlag;
    version_.multi_part = version & kMultiPartFlag;
    max_name_ = version & kLongNamesFlag ? kMaxLongName : kMaxShortName;
  }

  bool AtEndOfHeaders() {
    const std::size_t at = cursor_.offset();
    if (at < bytes_.size() && bytes_[at] != 0) return false;
    cursor_.Take(1, "the end of the headers");
    return true;
  }

  ExrHeader ParsePart() {
    header_ = version_;
    names_.clear();
    while (true) {
      Attribute attribute;
      attribute.name = cursor_.TakeUntil('\0', max_name_, "an attribute name");
      if (attribute.name.empty()) break;
      attribute.type = cursor_.TakeUntil('\0', max_name_, "an attribute type");
      attribute.size = cursor_.U32("an attribute size");
      attribute.offset = cursor_.offset();
      if (!names_.insert(attribute.name).second) {
        cursor_.Fail("the attribute " + attribute.name + " is there twice");
      }
      cursor_.Take(attribute.size, "an attribute");
      if (names_.size() > kMaxAttributes || cursor_.offset() > kMaxHeaderBytes) {
        cursor_.Fail("the EXR header is too long");
      }
      ParseAttribute(attribute);
    }
    header_.end = cursor_.offset();
    for (const auto& [name, type] : RequiredAttributes()) {
      if (!names_.count(name)) cursor_.Fail("the EXR header has no attribute " + name);
    }
    if (header_.tiled && !names_.count("tiles")) cursor_.Fail("a tiled EXR has no attribute tiles");
    return std::move(header_);
  }

  void ParseAttribute(const Attribute& attribute) {
    const auto fail = [&](const char* reason) {
      throw InputError(InputPosition::Byte(path_, attribute.offset),
                       "the EXR attribute " + attribute.name + reason);
    };
    if (const auto required = RequiredAttributes().find(attribute.name);
        required != RequiredAttributes().end() && required->second != attribute.type) {
      fail(" has the wrong type");
    }
    if (const auto fixed = FixedSizes().find(attribute.type);
        fixed != FixedSizes().end() && fixed->second != attribute.size) {
      fail(" has the wrong size");
    }
    ByteCursor value(path_, bytes_.substr(0, attribute.offset + attribute.size), attribute.offset);
    if (attribute.name == "channels") {
      ParseChannels(value);
    } else if (attribute.name == "compression") {
      ParseCompression(value);
    } else if (attribute.name == "dataWindow") {
      header_.data_window = ParseBox(value);
      if (!header_.multi_part) {
        CheckSize(InputPosition::Byte(path_, attribute.offset), header_.data_window.width(),
                  header_.data_window.height(), limits_);
      }
    } else if (attribute.name == "displayWindow") {
      const ExrBox box = header_.display_window = ParseBox(value);
      if (box.width() < 1 || box.height() < 1) fail(" is empty");
    } else if (attribute.name == "chromaticities" && attribute.type == "chromaticities") {
      ParsePrimaries(value);
    } else if (attribute.name == "chunkCount" && attribute.type == "int") {
      header_.chunk_count = value.I32("the number of chunks");
      if (header_.chunk_count < 0) fail(" is negative");
    } else if (attribute.name == "lineOrder") {
      if (value.U8("the line order") > 2) fail(" is unknown");
    } else if (attribute.name == "tiles") {
      if (attribute.type != "tiledesc") fail(" has the wrong type");
      ParseTiles(value);
    } else if (attribute.type == "string") {
      const std::string_view text = value.Take(attribute.size, "a string");
      header_.strings.emplace_back(attribute.name, text);
      if (attribute.name == "type" && header_.multi_part) {
        header_.deep = text.starts_with("deep");
        header_.tiled = text == "tiledimage" || text == "deeptile";
      }
    } else if (attribute.type == "stringvector") {
      while (value.left() > 0) value.Take(value.U32("a string length"), "a string");
    } else if (attribute.type == "floatvector") {
      if (attribute.size % 4 != 0) fail(" has the wrong size");
    } else if (attribute.type == "preview") {
      const std::uint64_t width = value.U32("a preview"), height = value.U32("a preview");
      const std::uint64_t pixels = value.left() / 4;
      if (value.left() % 4 != 0 || (width == 0 ? pixels != 0 : pixels != width * height)) {
        fail(" has the wrong size");
      }
    } else if (attribute.type == "idmanifest") {
      header_.has_manifest = true;
    }
  }

  void ParseChannels(ByteCursor& value) {
    constexpr std::uint32_t kUint = 0, kHalf = 1, kFloat = 2;
    std::set<std::string, std::less<>> names;
    while (true) {
      ExrChannel channel;
      channel.name = value.TakeUntil('\0', max_name_, "a channel name");
      if (channel.name.empty()) break;
      if (!names.insert(channel.name).second) value.Fail("a channel is there twice");
      if (names.size() > kMaxChannels) value.Fail("too many channels");
      const std::uint32_t type = value.U32("a channel");
      if (type != kUint && type != kHalf && type != kFloat) value.Fail("an unknown channel type");
      channel.bytes = type == kHalf ? 2 : 4;
      channel.is_whole = type == kUint;
      value.Take(4, "a channel");  // a hint on linearity, and three unused bytes
      const std::int32_t x_sampling = value.I32("a channel"), y_sampling = value.I32("a channel");
      if (x_sampling < 1 || y_sampling < 1) value.Fail("a channel with no sampling rate");
      channel.sub_sampled = x_sampling != 1 || y_sampling != 1;
      header_.channels.push_back(std::move(channel));
    }
    if (value.left() > 0) value.Fail("bytes after the channel list");
    if (names.empty()) value.Fail("an EXR without channels");
  }

  void ParseCompression(ByteCursor& value) {
    const std::uint8_t code = value.U8("the compression");
    if (code > std::uint8_t(ExrCompression::kDwab)) {
      value.Fail("the compression " + std::to_string(code) +
                 " (10 and 11 are HTJ2K), which is not supported; write the file with zip");
    }
    header_.compression = ExrCompression(code);
  }

  void ParsePrimaries(ByteCursor& value) {
    RgbPrimaries primaries;
    for (glm::dvec2* const c :
         {&primaries.red, &primaries.green, &primaries.blue, &primaries.white}) {
      c->x = std::bit_cast<float>(value.U32("the chromaticities"));
      c->y = std::bit_cast<float>(value.U32("the chromaticities"));
    }
    if (IsRgbSpace(primaries)) header_.primaries = primaries;
  }

  ExrBox ParseBox(ByteCursor& value) {
    ExrBox box;
    for (std::int32_t* const side : {&box.x_min, &box.y_min, &box.x_max, &box.y_max}) {
      *side = value.I32("a window");
      if (*side > kMaxCoordinate || *side < -kMaxCoordinate) {
        value.Fail("a window of the EXR header is out of bounds");
      }
    }
    return box;
  }

  void ParseTiles(ByteCursor& value) {
    const std::uint32_t width = value.U32("the tile size"), height = value.U32("the tile size");
    if (width < 1 || height < 1 || width > std::uint32_t(limits_.max_width) ||
        height > std::uint32_t(limits_.max_height)) {
      value.Fail("tiles of " + std::to_string(width) + " x " + std::to_string(height) +
                 " are not within the limits");
    }
    const std::uint8_t mode = value.U8("the tile mode");
    const int levels = mode & 15, rounding = mode >> 4;
    if (levels > int(ExrLevels::kRipmap) || rounding > 1) value.Fail("an unknown tile mode");
    header_.tiles = {
        .width = width, .height = height, .levels = ExrLevels(levels), .round_up = rounding == 1};
  }

  const std::string& path_;
  std::string_view bytes_;
  const ReadLimits& limits_;
  ByteCursor cursor_;
  std::size_t max_name_ = kMaxShortName;
  ExrHeader version_;  // what the file says of all of its parts
  std::set<std::string, std::less<>> names_;
  ExrHeader header_;
};

}  // namespace

std::int64_t ExrHeader::pixel_bytes() const {
  std::int64_t total = 0;
  for (const ExrChannel& channel : channels) total += channel.bytes;
  return total;
}

bool ExrHeader::risky() const {
  const bool few_samples = std::any_of(channels.begin(), channels.end(),
                                       [](const ExrChannel& c) { return c.sub_sampled; });
  return deep || multi_part || has_manifest || few_samples || compression > ExrCompression::kPiz;
}

std::vector<ExrHeader> ParseExrHeaders(const std::string& path, std::string_view bytes,
                                       const ReadLimits& limits) {
  return HeaderParser(path, bytes, limits).Parse();
}

}  // namespace skywave
