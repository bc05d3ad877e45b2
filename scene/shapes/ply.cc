#include "scene/shapes/ply.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <charconv>
#include <cmath>
#include <cstring>
#include <limits>
#include <optional>
#include <utility>

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
  std::string_view word = data.bytes.substr(begin, data.next - begin);
  if (word.empty()) data.Fail("the file ends in the middle of its data");
  if (word.starts_with('+')) word.remove_prefix(1);
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

// A vertex property is stored in a slot: 0-2 position, 3-5 normal, 6-7 uv, 8-10 colour.
constexpr int kSlots = 11, kNoSlot = -1;

bool IsOfNormal(int slot) { return slot >= 3 && slot <= 5; }

int SlotOf(const PlyProperty& property) {
  struct Name {
    std::string_view name;
    int slot;
  };
  constexpr Name kNames[] = {{"x", 0},
                             {"y", 1},
                             {"z", 2},
                             {"nx", 3},
                             {"ny", 4},
                             {"nz", 5},
                             {"u", 6},
                             {"v", 7},
                             {"s", 6},
                             {"t", 7},
                             {"texture_u", 6},
                             {"texture_v", 7},
                             {"texture_s", 6},
                             {"texture_t", 7},
                             {"red", 8},
                             {"green", 9},
                             {"blue", 10},
                             {"diffuse_red", 8},
                             {"diffuse_green", 9},
                             {"diffuse_blue", 10}};
  for (const Name& known : kNames) {
    if (known.name == property.name && !property.is_list) return known.slot;
  }
  return kNoSlot;
}

// Returns the largest value of a colour: that of an integer, or 1.
double MostOfColor(PlyType type) {
  if (!IsPlyInteger(type)) return 1;
  return PlyTypeSize(type) == 1 ? 255 : PlyTypeSize(type) == 2 ? 65535 : 4294967295.0;
}

void ReadVertices(Data& data, const PlyElement& element, const glm::dvec3& origin, Mesh& mesh,
                  PlyReport& report) {
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
  const bool has_colors = uses[8] && uses[9] && uses[10];
  mesh.positions.reserve(element.count);
  if (has_normals) mesh.normals.reserve(element.count);
  if (has_uvs) mesh.uvs.reserve(element.count);
  if (has_colors) mesh.colors.reserve(element.count);

  std::array<float, kSlots> values{};
  for (std::uint64_t i = 0; i < element.count; ++i) {
    bool has_normal = true;
    for (std::size_t p = 0; p < slots.size(); ++p) {
      if (slots[p] == kNoSlot) {
        SkipProperty(data, element.properties[p]);
        continue;
      }
      const PlyType type = element.properties[p].type;
      const bool of_position = slots[p] < 3, of_color = slots[p] >= 8;
      const double start = of_position ? origin[slots[p]] : 0.0;
      const auto value = static_cast<float>((ReadValue(data, type) - start) /
                                            (of_color ? MostOfColor(type) : 1.0));
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
    if (has_colors) mesh.colors.push_back(ColorOfSrgb({values[8], values[9], values[10]}));
  }
}

// Returns the next index of a vertex, or nothing for one that is `end`.
std::optional<std::uint32_t> ReadIndex(Data& data, PlyType type, std::string_view what,
                                       std::uint64_t number, std::uint64_t vertices,
                                       std::optional<double> end = std::nullopt) {
  const double index = ReadValue(data, type);
  if (end && index == *end) return std::nullopt;
  if (!(index >= 0 && index < static_cast<double>(vertices))) {
    data.Fail(fmt::format("{} {}: index {} is not in 0..{}, the vertices of the file", what, number,
                          index, static_cast<std::int64_t>(vertices) - 1));
  }
  return static_cast<std::uint32_t>(index);
}

// Reads a polygon and returns how many corners it has; its triangles are a fan.
std::size_t ReadPolygon(Data& data, const PlyProperty& list, std::uint64_t face,
                        std::uint64_t vertices, std::vector<glm::uvec3>& triangles) {
  const std::size_t corners = ReadCount(data, list);
  glm::uvec3 triangle(0);
  for (std::size_t corner = 0; corner < corners; ++corner) {
    triangle[static_cast<int>(std::min<std::size_t>(corner, 2))] =
        *ReadIndex(data, list.type, "face", face, vertices);
    if (corner >= 2) {
      triangles.push_back(triangle);
      triangle.y = triangle.z;
    }
  }
  return corners;
}

// Returns the list of indices of an element of faces or strips.
const PlyProperty& IndexList(const Data& data, const PlyElement& element) {
  const PlyProperty* indices = nullptr;
  for (const PlyProperty& property : element.properties) {
    if (property.name != "vertex_indices" && property.name != "vertex_index") continue;
    if (indices || !property.is_list || !IsPlyInteger(property.type)) {
      data.Fail("the vertex indices of faces have to be one list of integers");
    }
    indices = &property;
  }
  if (!indices) data.Fail("faces without a list vertex_indices");
  return *indices;
}

// Reads faces, and appends to `corner_uvs` three coordinates for each of their triangles if the
// faces have coordinates of their own.
void ReadFaces(Data& data, const PlyElement& element, std::uint64_t vertices, Mesh& mesh,
               PlyReport& report, std::vector<glm::vec2>& corner_uvs) {
  const PlyProperty& indices = IndexList(data, element);
  const auto has_uvs = [](const PlyProperty& property) {
    return property.name == "texcoord" && property.is_list && !IsPlyInteger(property.type);
  };
  const bool own_uvs = std::any_of(element.properties.begin(), element.properties.end(), has_uvs);
  mesh.triangles.reserve(element.count);
  std::vector<glm::vec2> uvs;
  for (std::uint64_t face = 0; face < element.count; ++face) {
    const std::size_t before = mesh.triangles.size();
    uvs.clear();
    for (const PlyProperty& property : element.properties) {
      if (&property == &indices) {
        report.small_faces += ReadPolygon(data, property, face, vertices, mesh.triangles) < 3;
      } else if (has_uvs(property)) {
        const std::size_t count = ReadCount(data, property);
        for (std::size_t i = 0; i < count; ++i) {
          const auto value = static_cast<float>(ReadValue(data, property.type));
          if (!std::isfinite(value)) data.Fail("'texcoord' is not finite");
          if (i % 2 == 0) uvs.emplace_back(value, 0);
          if (i % 2 == 1) uvs.back().y = value;
        }
      } else {
        SkipProperty(data, property);
      }
    }
    for (std::size_t t = before; own_uvs && t < mesh.triangles.size(); ++t) {
      const std::size_t second = t - before + 1;
      for (const std::size_t corner : {std::size_t{0}, second, second + 1}) {
        corner_uvs.push_back(corner < uvs.size() ? uvs[corner] : glm::vec2(0));
      }
    }
  }
}

// Reads strips, every second triangle of which is wound the other way round.
void ReadStrips(Data& data, const PlyElement& element, std::uint64_t vertices, Mesh& mesh) {
  const PlyProperty& indices = IndexList(data, element);
  for (std::uint64_t strip = 0; strip < element.count; ++strip) {
    for (const PlyProperty& property : element.properties) {
      if (&property != &indices) {
        SkipProperty(data, property);
        continue;
      }
      const std::size_t count = ReadCount(data, property);
      glm::uvec3 last(0);
      std::size_t length = 0;
      for (std::size_t i = 0; i < count; ++i) {
        const auto index = ReadIndex(data, property.type, "strip", strip, vertices, -1.0);
        if (!index) {
          length = 0;
          continue;
        }
        last = {last.y, last.z, *index};
        if (++length < 3) continue;
        mesh.triangles.push_back(length % 2 == 1 ? last : glm::uvec3(last.y, last.x, last.z));
      }
    }
  }
}

// Gives every triangle vertices of its own, with these coordinates.
void SplitCorners(const std::vector<glm::vec2>& corner_uvs, Mesh& mesh) {
  Mesh split;
  split.uvs = corner_uvs;
  for (glm::uvec3& triangle : mesh.triangles) {
    for (int c = 0; c < 3; ++c) {
      const std::uint32_t from = triangle[c];
      split.positions.push_back(mesh.positions[from]);
      if (!mesh.normals.empty()) split.normals.push_back(mesh.normals[from]);
      if (!mesh.colors.empty()) split.colors.push_back(mesh.colors[from]);
      triangle[c] = std::uint32_t(split.positions.size() - 1);
    }
  }
  split.triangles = std::move(mesh.triangles);
  mesh = std::move(split);
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
  return found;
}

Mesh Parse(std::string_view bytes, const std::string& path, bool needs_faces,
           const glm::dvec3& origin, PlyReport* report) {
  PlyReport found;
  const PlyHeader header = ParsePlyHeader(bytes, path);
  const PlyElement* vertices = FindElement(header, "vertex", path);
  const PlyElement* faces = FindElement(header, "face", path);
  const PlyElement* strips = FindElement(header, "tristrips", path);
  if (vertices == nullptr) throw InputError(InputPosition::File(path), "has no element 'vertex'");
  if (needs_faces && faces == nullptr && strips == nullptr) {
    throw InputError(InputPosition::File(path), "has no element 'face'");
  }
  Data data{bytes, path, header.format, header.data_begin, header.lines + 1};
  Mesh mesh;
  std::vector<glm::vec2> corner_uvs;
  for (const PlyElement& element : header.elements) {
    if (&element == vertices) {
      ReadVertices(data, element, origin, mesh, found);
    } else if (&element == faces) {
      ReadFaces(data, element, vertices->count, mesh, found, corner_uvs);
    } else if (&element == strips) {
      ReadStrips(data, element, vertices->count, mesh);
    } else {
      SkipElements(data, element);
    }
  }
  if (data.format == PlyFormat::kAscii) SkipSpace(data);
  found.trailing_bytes = data.Left();
  found.texture = header.texture;
  found.unknown = header.unknown;
  if (corner_uvs.size() == 3 * mesh.triangles.size() && !corner_uvs.empty()) {
    SplitCorners(corner_uvs, mesh);
  }
  NormalizeNormals(mesh);
  AlignWindingWithNormals(mesh);
  found.polygons = faces != nullptr ? std::size_t(faces->count) : mesh.triangles.size();
  if (report != nullptr) *report = found;
  return mesh;
}

}  // namespace

Mesh ParsePly(std::string_view bytes, const std::string& path, PlyReport* report) {
  return Parse(bytes, path, /*needs_faces=*/true, glm::dvec3(0), report);
}

Mesh ParsePlyPoints(std::string_view bytes, const std::string& path, PlyReport* report,
                    const glm::dvec3& origin) {
  return Parse(bytes, path, /*needs_faces=*/false, origin, report);
}

Mesh ReadPlyPoints(const std::string& path, PlyReport* report, const glm::dvec3& origin) {
  return ParsePlyPoints(Gunzip(ReadFile(path), path), path, report, origin);
}

Mesh ReadPly(const std::string& path, PlyReport* report) {
  return ParsePly(Gunzip(ReadFile(path), path), path, report);
}

void WarnOfPly(const PlyReport& report, const InputPosition& position, Warnings& warnings) {
  if (report.bad_normals > 0) {
    AddWarning(warnings, position,
               fmt::format("normals that are not finite, {} in number: those of the faces around "
                           "the vertex are used",
                           report.bad_normals));
  }
  if (!report.unknown.empty()) {
    AddWarning(warnings, position,
               fmt::format("'{}' is not a statement of a PLY header: its line is ignored",
                           report.unknown));
  }
  if (report.small_faces > 0) {
    AddWarning(warnings, position,
               fmt::format("faces of fewer than three corners, {} in number: left out",
                           report.small_faces));
  }
  if (report.trailing_bytes > 0) {
    AddWarning(warnings, position,
               fmt::format("{} bytes follow the last element: ignored", report.trailing_bytes));
  }
}

}  // namespace skywave
