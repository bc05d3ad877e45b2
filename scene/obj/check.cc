#include "scene/obj/check.h"

#include <fmt/format.h>

#include <charconv>
#include <cstdint>
#include <string_view>
#include <unordered_set>

namespace skywave {
namespace {

// One of the three tables that corners index.
struct IndexedTable {
  const char* name;
  std::int64_t count = 0;         // elements read so far
  std::int64_t greatest = 0;      // the greatest index that a face has used
  std::size_t greatest_line = 0;  // the line of that face
};

struct Tables {
  IndexedTable positions{"vertex"}, uvs{"texture vertex"}, normals{"normal"};
};

// Checks one index of a corner. Positive indices may refer to later elements, so they are compared
// at the end.
void CheckIndex(const ObjLines& lines, std::string_view text, IndexedTable& table) {
  std::int32_t index = 0;
  const auto [stop, error] = std::from_chars(text.data(), text.data() + text.size(), index);
  if (error != std::errc() || stop != text.data() + text.size()) {
    throw InputError(PositionOf(lines), fmt::format("'{}' is no index", text.substr(0, 40)));
  }
  if (index == 0) throw InputError(PositionOf(lines), "index 0: OBJ counts from 1");
  if (index < -table.count) {
    throw InputError(PositionOf(lines),
                     fmt::format("{} index {} with {} before it", table.name, index, table.count));
  }
  if (index > table.greatest) table.greatest = index, table.greatest_line = lines.line;
}

// Checks a corner: v, v/vt, v//vn or v/vt/vn.
void CheckCorner(const ObjLines& lines, std::string_view corner, Tables& tables) {
  const std::size_t first = corner.find('/');
  CheckIndex(lines, corner.substr(0, first), tables.positions);
  if (first == std::string_view::npos) return;
  const std::string_view rest = corner.substr(first + 1);
  const std::size_t second = rest.find('/');
  const std::string_view uv = rest.substr(0, second);
  if (!uv.empty() || second == std::string_view::npos) CheckIndex(lines, uv, tables.uvs);
  if (second != std::string_view::npos) {
    CheckIndex(lines, rest.substr(second + 1), tables.normals);
  }
}

void CheckFace(const ObjLines& lines, const std::vector<std::string_view>& words, Tables& tables) {
  const std::size_t corners = words.size() - 1;
  if (corners < 3 || corners > kMaxObjCorners) {
    throw InputError(PositionOf(lines), fmt::format("a face of {} corners; 3 to {} can be read",
                                                    corners, kMaxObjCorners));
  }
  for (std::size_t i = 1; i < words.size(); ++i) CheckCorner(lines, words[i], tables);
}

void CheckRange(const ObjLines& lines, const IndexedTable& table) {
  if (table.greatest <= table.count) return;
  throw InputError(
      InputPosition::Line(lines.path, table.greatest_line),
      fmt::format("{} index {}, but the file has {}", table.name, table.greatest, table.count));
}

}  // namespace

ObjStatements CheckObj(ObjLines& lines, Warnings& warnings) {
  ObjStatements statements;
  Tables tables;
  std::unordered_set<std::string> seen;
  std::vector<std::string_view> words;
  while (NextStatement(lines, words)) {
    const std::string_view word = words[0];
    if (word == "v") {
      CheckObjNumbers(lines, words, 3, 7);  // optionally followed by a weight, a colour or both
      ++tables.positions.count;
    } else if (word == "f") {
      CheckFace(lines, words, tables);
      ++statements.faces;
    } else if (word == "vn") {
      CheckObjNumbers(lines, words, 3, 3);
      ++tables.normals.count;
    } else if (word == "vt") {
      CheckObjNumbers(lines, words, 1, 3);
      ++tables.uvs.count;
    } else if (word == "s") {
      statements.has_smoothing = true;
    } else if (word == "usemtl" || word == "mtllib") {
      const ObjName name{RestOfStatement(words), lines.line};
      if (name.name.empty()) {
        throw InputError(PositionOf(lines), fmt::format("'{}' without a name", word));
      }
      if (word == "mtllib") {
        statements.libraries.push_back(name);
      } else if (seen.insert(name.name).second) {
        statements.materials.push_back(name);
      }
    } else if (word == "t" || word == "vw") {
      // These are extensions of tinyobjloader, which trusts the counts in them.
      throw InputError(PositionOf(lines), fmt::format("'{}' is not a statement of OBJ", word));
    } else if (word != "o" && word != "g") {
      AddWarning(warnings, PositionOf(lines),
                 fmt::format("'{}' is not supported: left out", word.substr(0, 40)));
    }
  }
  for (const IndexedTable& table : {tables.positions, tables.uvs, tables.normals}) {
    CheckRange(lines, table);
  }
  return statements;
}

}  // namespace skywave
