// Parses the declarations of a PLY header: elements, their properties and their sizes.
#pragma once

#include <cstddef>
#include <cstdint>
#include <string>
#include <string_view>
#include <vector>

namespace skywave {

enum class PlyFormat { kAscii, kLittleEndian, kBigEndian };
enum class PlyType : std::uint8_t {
  kInt8,
  kUint8,
  kInt16,
  kUint16,
  kInt32,
  kUint32,
  kFloat,
  kDouble
};

std::size_t PlyTypeSize(PlyType type);  // [bytes]
bool IsPlyInteger(PlyType type);

struct PlyProperty {
  std::string name;
  PlyType type = PlyType::kFloat;  // for a list: type of its items
  bool is_list = false;
  PlyType count_type = PlyType::kUint8;  // lists only
};

struct PlyElement {
  std::string name;
  std::uint64_t count = 0;
  std::vector<PlyProperty> properties;
};

struct PlyHeader {
  PlyFormat format = PlyFormat::kAscii;
  std::vector<PlyElement> elements;
  std::string texture;         // the first file that MeshLab's comments name: TextureFile NAME
  std::string unknown;         // the first word of the first line that is no statement of PLY
  std::size_t data_begin = 0;  // [bytes] offset of the first byte after the header
  std::size_t lines = 0;       // lines of the header, end_header included
};

// Throws InputError (with the line) on anything that is not a header, and on element counts that
// the rest of `bytes` cannot hold, so that callers may allocate by count.
PlyHeader ParsePlyHeader(std::string_view bytes, const std::string& path);

}  // namespace skywave
