#include "scene/shapes/ply_header.h"

#include <fmt/format.h>

#include <charconv>

#include "base/error.h"

namespace skywave {
namespace {

struct TypeName {
  std::string_view name;
  PlyType type;
};
constexpr TypeName kTypeNames[] = {
    {"char", PlyType::kInt8},     {"int8", PlyType::kInt8},     {"uchar", PlyType::kUint8},
    {"uint8", PlyType::kUint8},   {"short", PlyType::kInt16},   {"int16", PlyType::kInt16},
    {"ushort", PlyType::kUint16}, {"uint16", PlyType::kUint16}, {"int", PlyType::kInt32},
    {"int32", PlyType::kInt32},   {"uint", PlyType::kUint32},   {"uint32", PlyType::kUint32},
    {"float", PlyType::kFloat},   {"float32", PlyType::kFloat}, {"double", PlyType::kDouble},
    {"float64", PlyType::kDouble}};

struct HeaderLines {
  std::string_view bytes;
  const std::string& path;
  std::size_t next = 0;
  std::size_t line = 0;

  [[noreturn]] void Fail(const std::string& reason) const {
    throw InputError(InputPosition::Line(path, line), reason);
  }

  // Returns the words of the next line.
  std::vector<std::string_view> Next() {
    constexpr std::size_t kMaxLine = 4096;  // a binary file must not be read as one long line
    ++line;
    const std::size_t end = bytes.substr(next, kMaxLine).find('\n');
    if (end == std::string_view::npos) Fail("PLY header without end_header");
    std::string_view text = bytes.substr(next, end);
    next += end + 1;
    std::vector<std::string_view> words;
    constexpr std::string_view kSpace = " \t\r";
    while (true) {
      const std::size_t begin = text.find_first_not_of(kSpace);
      if (begin == std::string_view::npos) return words;
      text.remove_prefix(begin);
      const std::size_t length = std::min(text.find_first_of(kSpace), text.size());
      words.push_back(text.substr(0, length));
      text.remove_prefix(length);
    }
  }
};

PlyType ParseType(const HeaderLines& lines, std::string_view word) {
  for (const TypeName& known : kTypeNames) {
    if (known.name == word) return known.type;
  }
  lines.Fail(fmt::format("'{}' is not a PLY type", word));
}

PlyProperty ParseProperty(const HeaderLines& lines, const std::vector<std::string_view>& words) {
  PlyProperty property;
  property.is_list = words.size() > 1 && words[1] == "list";
  if (words.size() != (property.is_list ? 5 : 3)) {
    lines.Fail("'property TYPE NAME' or 'property list TYPE TYPE NAME' is expected");
  }
  property.type = ParseType(lines, words[words.size() - 2]);
  property.name = words.back();
  if (property.is_list) {
    property.count_type = ParseType(lines, words[2]);
    if (!IsPlyInteger(property.count_type)) lines.Fail("the count of a list has to be an integer");
  }
  return property;
}

PlyElement ParseElement(const HeaderLines& lines, const std::vector<std::string_view>& words) {
  if (words.size() != 3) lines.Fail("'element NAME COUNT' is expected");
  PlyElement element;
  element.name = words[1];
  const char* end = words[2].data() + words[2].size();
  const auto [stop, error] = std::from_chars(words[2].data(), end, element.count);
  if (error != std::errc() || stop != end) {
    lines.Fail(fmt::format("'{}' is no count of elements", words[2]));
  }
  return element;
}

PlyFormat ParseFormat(const HeaderLines& lines, const std::vector<std::string_view>& words) {
  if (words.size() == 3 && words[0] == "format" && words[2] == "1.0") {
    if (words[1] == "ascii") return PlyFormat::kAscii;
    if (words[1] == "binary_little_endian") return PlyFormat::kLittleEndian;
    if (words[1] == "binary_big_endian") return PlyFormat::kBigEndian;
  }
  lines.Fail("'format ascii|binary_little_endian|binary_big_endian 1.0' is expected");
}

// Returns the smallest size of an element: an empty list is its count, an ascii value is a digit
// and a space.
std::size_t SmallestSize(const PlyElement& element, PlyFormat format) {
  std::size_t size = 0;
  for (const PlyProperty& property : element.properties) {
    size += format == PlyFormat::kAscii
                ? 2
                : PlyTypeSize(property.is_list ? property.count_type : property.type);
  }
  return size;
}

void CheckCounts(const HeaderLines& lines, const PlyHeader& header) {
  // The last ascii value needs no space after it.
  std::uint64_t room = lines.bytes.size() - header.data_begin + 1;
  for (const PlyElement& element : header.elements) {
    const std::size_t size = SmallestSize(element, header.format);
    if (size == 0) continue;
    if (element.count > room / size) {
      lines.Fail(fmt::format("{} elements '{}' do not fit in the remaining {} bytes of the file",
                             element.count, element.name, room - 1));
    }
    room -= element.count * size;
  }
}

}  // namespace

std::size_t PlyTypeSize(PlyType type) {
  constexpr std::size_t kSizes[] = {1, 1, 2, 2, 4, 4, 4, 8};
  return kSizes[static_cast<std::size_t>(type)];
}

bool IsPlyInteger(PlyType type) { return type != PlyType::kFloat && type != PlyType::kDouble; }

PlyHeader ParsePlyHeader(std::string_view bytes, const std::string& path) {
  HeaderLines lines{bytes, path};
  if (bytes.starts_with("\x1f\x8b")) {
    throw InputError(InputPosition::File(path), "is compressed: unpack it with gunzip first");
  }
  if (!bytes.starts_with("ply\n") && !bytes.starts_with("ply\r\n")) {
    throw InputError(InputPosition::Line(path, 1),
                     "is not a PLY file: its first line is not 'ply'");
  }
  lines.Next();
  PlyHeader header;
  header.format = ParseFormat(lines, lines.Next());
  while (true) {
    const std::vector<std::string_view> words = lines.Next();
    if (words.size() > 2 && words[0] == "comment" && words[1] == "TextureFile" &&
        header.texture.empty()) {
      header.texture = {words[2].data(),
                        std::size_t(words.back().data() + words.back().size() - words[2].data())};
    }
    if (words.empty() || words[0] == "comment" || words[0] == "obj_info") continue;
    if (words[0] == "end_header") break;
    if (words[0] == "element") {
      header.elements.push_back(ParseElement(lines, words));
    } else if (words[0] == "property" && !header.elements.empty()) {
      header.elements.back().properties.push_back(ParseProperty(lines, words));
    } else {
      // Some programs write their names without `comment`.
      if (words[0] == "property") lines.Fail("'property' before the first element");
      if (header.unknown.empty()) header.unknown = words[0].substr(0, 40);
    }
  }
  header.data_begin = lines.next;
  header.lines = lines.line;
  CheckCounts(lines, header);
  return header;
}

}  // namespace skywave
