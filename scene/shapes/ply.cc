#include "scene/shapes/ply.h"

#include <fmt/format.h>

#include <array>
#include <charconv>
#include <cmath>
#include <cstring>
#include <limits>

#include "base/error.h"
#include "base/files.h"
#include "base/gzip.h"
#include "scene/shapes/mesh.h"
#include "scene/shapes/ply_header.h"

namespace skywave {
namespace {

// A cursor over the values after the header, in any of the three formats.
struct Data {
  std::string_view bytes;
  const std::string& path;
  PlyFormat format;
  std::size_t next;
  std::size_t line;  // ascii: line of the value read last

  InputPosition Position() const {
    return format == PlyFormat::kAscii ? InputPosition::Line(path, line)
                                       : InputPosition::Byte(path, next);
  }
  [[noreturn]] void Fail(const std::string& reason) const { throw InputError(Position(), reason); }
  std::size_t Left() const { return bytes.size() - next; }
};

bool IsSpace(char c) { return c == ' ' || c == '\t' || c == '\r' || c == '\n'; }

void SkipSpace(Data& data) {
  while (data.next < data.bytes.size() && IsSpace(data.bytes[data.next])) {
    data.line += data.bytes[data.next++] == '\n';
  }
}

double ReadAscii(Data& data, PlyType type) {
  SkipSpace(data);
  const std::size_t begin = data.next;
  while (data.next < data.bytes.size() && !IsSpace(data.bytes[data.next])) ++data.next;
  const std::string_view word = data.bytes.substr(begin, data.next - begin);
  if (word.empty()) data.Fail("the file ends in the middle of its data");
  double value = 0;
  const auto [stop, error] = std::from_chars(word.data(), word.data() + word.size(), value);
  if (error != std::errc() || stop != word.data() + word.size()) {
    data.Fail(fmt::format("'{}' is not a number", word.substr(0, 40)));
  }
  if (IsPlyInteger(type) && value != std::floor(value)) {
    data.Fail(fmt::format("'{}' is no integer", word.substr(0, 40)));
  }
  return value;
}

template <typename Value>
double ReadAs(const char* bytes, bool swap) {
  std::array<char, sizeof(Value)> ordered;
  for (std::size_t i = 0; i < sizeof(Value); ++i) {
    ordered[i] = bytes[swap ? sizeof(Value) - 1 - i : i];
  }
  Value value;
  std::memcpy(&value, ordered.data(), sizeof value);
  return static_cast<double>(value);
}

// The values of every type are exact in double.
double ReadValue(Data& data, PlyType type) {
  if (data.format == PlyFormat::kAscii) return ReadAscii(data, type);
  const std::size_t size = PlyTypeSize(type);
  if (size > data.Left()) data.Fail("the file ends in the middle of its data");
  const char* bytes = data.bytes.data() + data.next;
  data.next += size;
  const bool swap = data.format == PlyFormat::kBigEndian;  // this program runs on x86-64
  switch (type) {
    case PlyType::kInt8:
      return ReadAs<std::int8_t>(bytes, swap);
    case PlyType::kUint8:
      return ReadAs<std::uint8_t>(bytes, swap);
    case PlyType::kInt16:
      return ReadAs<std::int16_t>(bytes, swap);
    case PlyType::kUint16:
      return ReadAs<std::uint16_t>(bytes, swap);
    case PlyType::kInt32:
      return ReadAs<std::int32_t>(bytes, swap);
    case PlyType::kUint32:
      return ReadAs<std::uint32_t>(bytes, swap);
    case PlyType::kFloat:
      return ReadAs<float>(bytes, swap);
    case PlyType::kDouble:
      return ReadAs<double>(bytes, swap);
  }
  return 0;
}

std::size_t ReadCount(Data& data, const PlyProperty& list) {
  const double count = ReadValue(data, list.count_type);
  const std::size_t item = data.format == PlyFormat::kAscii ? 1 : PlyTypeSize(list.type);
  if (!(count >= 0) || count > static_cast<double>(data.Left() / item)) {
    data.Fail(fmt::format("a list '{}' of {} values does not fit in the rest of the file",
                          list.name, count));
  }
  return static_cast<std::size_t>(count);
}

void SkipProperty(Data& data, const PlyProperty& property) {
  const std::size_t count = property.is_list ? ReadCount(data, property) : 1;
  for (std::size_t i = 0; i < count; ++i) ReadValue(data, property.type);
}

void SkipElements(Data& data, const PlyElement& element) {
  if (element.properties.empty()) return;
  for (std::uint64_t i = 0; i < element.count; ++i) {
    for (const PlyProperty& property : element.properties) SkipProperty(data, property);
  }
}

// A vertex property is stored in a slot: 0-2 position, 3-5 normal, 6-7 uv.
constexpr int kSlots = 8, kNoSlot = -1;

bool IsOfNormal(int slot) { return slot >= 3 && slot <= 5; }

int SlotOf(const PlyProperty& property) {
  constexpr std::string_view kNames[][kSlots] = {
      {"x", "y", "z", "nx", "ny", "nz", "u", "v"},
      {"", "", "", "", "", "", "s", "t"},
      {"", "", "", "", "", "", "texture_u", "texture_v"},
      {"", "", "", "", "", "", "texture_s", "texture_t"},
  };
  for (const auto& names : kNames) {
    for (int slot = 0; slot < kSlots; ++slot) {
      if (names[slot] == property.name && !property.is_list) return slot;
    }
  }
  return kNoSlot;
}

void ReadVertices(Data& data, const PlyElement& element, Mesh& mesh, PlyReport& report) {
  std::vector<int> slots;
  std::array<int, kSlots> uses{};
  for (const PlyProperty& property : element.properties) {
    slots.push_back(SlotOf(property));
    if (slots.back() != kNoSlot && ++uses[slots.back()] > 1) {
      data.Fail(fmt::format("the vertex property '{}' is there twice", property.name));
    }
  }
  if (!(uses[0] && uses[1] && uses[2])) data.Fail("vertices without x, y and z");
  if (element.count > std::numeric_limits<std::uint32_t>::max()) data.Fail("too many vertices");
  const bool has_normals = uses[3] && uses[4] && uses[5], has_uvs = uses[6] && uses[7];
  mesh.positions.reserve(element.count);
  if (has_normals) mesh.normals.reserve(element.count);
  if (has_uvs) mesh.uvs.reserve(element.count);

  std::array<float, kSlots> values{};
  for (std::uint64_t i = 0; i < element.count; ++i) {
    bool has_normal = true;
    for (std::size_t p = 0; p < slots.size(); ++p) {
      if (slots[p] == kNoSlot) {
        SkipProperty(data, element.properties[p]);
        continue;
      }
      const float value = static_cast<float>(ReadValue(data, element.properties[p].type));
      if (!std::isfinite(value) && IsOfNormal(slots[p])) {
        has_normal = false;
      } else if (!std::isfinite(value)) {
        data.Fail(fmt::format("'{}' of vertex {} is not finite", element.properties[p].name, i));
      }
      values[slots[p]] = value;
    }
    mesh.positions.emplace_back(values[0], values[1], values[2]);
    if (has_normals) {
      mesh.normals.push_back(has_normal ? glm::vec3(values[3], values[4], values[5])
                                        : glm::vec3(0));
      report.bad_normals += has_normal ? 0 : 1;
    }
    if (has_uvs) mesh.uvs.emplace_back(values[6], values[7]);
  }
}

void ReadPolygon(Data& data, const PlyProperty& list, std::uint64_t face, std::uint64_t vertices,
                 std::vector<glm::uvec3>& triangles) {
  const std::size_t corners = ReadCount(data, list);
  if (corners < 3) data.Fail(fmt::format("face {} has {} corners", face, corners));
  glm::uvec3 triangle(0);
  for (std::size_t corner = 0; corner < corners; ++corner) {
    const double index = ReadValue(data, list.type);
    if (!(index >= 0 && index < static_cast<double>(vertices))) {
      data.Fail(fmt::format("face {}: index {} is not in 0..{}, the vertices of the file", face,
                            index, static_cast<std::int64_t>(vertices) - 1));
    }
    triangle[static_cast<int>(std::min<std::size_t>(corner, 2))] =
        static_cast<std::uint32_t>(index);
    if (corner >= 2) {
      triangles.push_back(triangle);
      triangle.y = triangle.z;
    }
  }
}

void ReadFaces(Data& data, const PlyElement& element, std::uint64_t vertices, Mesh& mesh) {
  const PlyProperty* indices = nullptr;
  for (const PlyProperty& property : element.properties) {
    if (property.name != "vertex_indices" && property.name != "vertex_index") continue;
    if (indices || !property.is_list || !IsPlyInteger(property.type)) {
      data.Fail("the vertex indices of faces have to be one list of integers");
    }
    indices = &property;
  }
  if (!indices) data.Fail("faces without a list vertex_indices");
  mesh.triangles.reserve(element.count);
  for (std::uint64_t face = 0; face < element.count; ++face) {
    for (const PlyProperty& property : element.properties) {
      if (&property == indices) {
        ReadPolygon(data, property, face, vertices, mesh.triangles);
      } else {
        SkipProperty(data, property);
      }
    }
  }
}

const PlyElement* FindElement(const PlyHeader& header, std::string_view name,
                              const std::string& path) {
  const PlyElement* found = nullptr;
  for (const PlyElement& element : header.elements) {
    if (element.name != name) continue;
    if (found) {
      throw InputError(InputPosition::File(path), fmt::format("declares '{}' twice", name));
    }
    found = &element;
  }
  if (!found) throw InputError(InputPosition::File(path), fmt::format("has no element '{}'", name));
  return found;
}

}  // namespace

Mesh ParsePly(std::string_view bytes, const std::string& path, PlyReport* report) {
  PlyReport found;
  const PlyHeader header = ParsePlyHeader(bytes, path);
  const PlyElement* vertices = FindElement(header, "vertex", path);
  const PlyElement* faces = FindElement(header, "face", path);
  Data data{bytes, path, header.format, header.data_begin, header.lines + 1};
  Mesh mesh;
  for (const PlyElement& element : header.elements) {
    if (&element == vertices) {
      ReadVertices(data, element, mesh, found);
    } else if (&element == faces) {
      ReadFaces(data, element, vertices->count, mesh);
    } else {
      SkipElements(data, element);
    }
  }
  if (data.format == PlyFormat::kAscii) SkipSpace(data);
  if (data.Left() > 0) {
    data.Fail(fmt::format("{} bytes follow the last element", data.Left()));
  }
  NormalizeNormals(mesh);
  AlignWindingWithNormals(mesh);
  found.polygons = std::size_t(faces->count);
  if (report != nullptr) *report = found;
  return mesh;
}

Mesh ReadPly(const std::string& path, PlyReport* report) {
  return ParsePly(Gunzip(ReadFile(path), path), path, report);
}

void WarnOfPly(const PlyReport& report, const InputPosition& position, Warnings& warnings) {
  if (report.bad_normals == 0) return;
  AddWarning(warnings, position,
             fmt::format("normals that are not finite, {} in number: those of the faces around the "
                         "vertex are used",
                         report.bad_normals));
}

}  // namespace skywave
