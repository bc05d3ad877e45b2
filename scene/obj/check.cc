#include "scene/obj/check.h"

#include <fmt/format.h>

#include <algorithm>
#include <charconv>
#include <cstdint>
#include <optional>
#include <string_view>
#include <unordered_set>
#include <utility>

namespace skywave {
namespace {

std::string_view WholeStatement(const std::vector<std::string_view>& words) {
  return {words.front().data(),
          std::size_t(words.back().data() + words.back().size() - words.front().data())};
}

// One of the three tables that corners index.
struct IndexedTable {
  const char* name;
  std::int64_t count = 0;         // elements read so far
  std::int64_t greatest = 0;      // the greatest index that a face has used
  std::size_t greatest_line = 0;  // the line of that face
};

struct Tables {
  IndexedTable positions{"vertex"}, uvs{"texture vertex"}, normals{"normal"};
  std::unordered_set<std::int64_t> lost;  // positions that are no place, counted from 1
  bool rewrite = false;                   // corners have indices that mean nothing
};

// Makes numbers 0 that are not finite: "nan", "inf", what a float cannot hold, and "1.#QNAN" as old
// programs of Windows write it. Returns whether there was any.
bool ReplaceNotFinite(ObjLines& lines, std::vector<std::string_view>& words) {
  bool any = false;
  for (std::size_t i = 1; i < words.size(); ++i) {
    if (!IsObjNumberNotFinite(words[i])) continue;
    any = true;
    std::string zero = "0";
    zero.resize(words[i].size(), ' ');
    lines.text.replace(std::size_t(words[i].data() - lines.text.data()), zero.size(), zero);
    words[i] = words[i].substr(0, 1);
  }
  return any;
}

// Returns what is wrong with one index of a corner. Positive indices may refer to later elements,
// so they are compared at the end.
std::optional<std::string> CheckIndex(const ObjLines& lines, std::string_view text,
                                      IndexedTable& table) {
  std::int32_t index = 0;
  const auto [stop, error] = std::from_chars(text.data(), text.data() + text.size(), index);
  if (error != std::errc() || stop != text.data() + text.size()) {
    throw InputError(PositionOf(lines), fmt::format("'{}' is no index", text.substr(0, 40)));
  }
  if (index == 0) return fmt::format("{} index 0, and OBJ counts from 1", table.name);
  if (index < -table.count) {
    return fmt::format("{} index {} with {} before it", table.name, index, table.count);
  }
  if (index > table.greatest) table.greatest = index, table.greatest_line = lines.line;
  return std::nullopt;
}

// The parts of a corner: v, v/vt, v//vn or v/vt/vn; some programs write a slash with nothing after
// it.
struct Corner {
  explicit Corner(std::string_view word) : position(word.substr(0, word.find('/'))) {
    if (position.size() == word.size()) return;
    const std::string_view rest = word.substr(position.size() + 1);
    uv = rest.substr(0, rest.find('/'));
    if (uv.size() < rest.size()) normal = rest.substr(uv.size() + 1);
  }
  std::string_view position, uv, normal;
};

// Blanks out a statement, with a warning.
void LeaveOut(ObjLines& lines, const std::vector<std::string_view>& words, const std::string& why,
              Warnings& warnings) {
  AddWarning(warnings, PositionOf(lines), why + ": left out");
  BlankOut(lines, WholeStatement(words));
}

// Returns whether the vertices of a face, of points or of a line can be there; others are left out.
// A wrong index of a texture vertex or a normal is ignored, with a warning.
bool CheckCorners(ObjLines& lines, const std::vector<std::string_view>& words, Tables& tables,
                  Warnings& warnings) {
  for (std::size_t i = 1; i < words.size(); ++i) {
    const Corner corner(words[i]);
    if (const auto wrong = CheckIndex(lines, corner.position, tables.positions)) {
      LeaveOut(lines, words, fmt::format("'{}' with {}", words[0], *wrong), warnings);
      return false;
    }
    const std::pair<std::string_view, IndexedTable*> others[] = {{corner.uv, &tables.uvs},
                                                                 {corner.normal, &tables.normals}};
    for (const auto& [index, table] : others) {
      if (index.empty()) continue;
      const auto wrong = CheckIndex(lines, index, *table);
      if (!wrong) continue;
      tables.rewrite = true;
      AddWarning(warnings, PositionOf(lines),
                 fmt::format("'{}' with {}: ignored", words[0], *wrong));
    }
  }
  return true;
}

// Returns whether the statement is a face that can be read; others are left out.
bool CheckFace(ObjLines& lines, const std::vector<std::string_view>& words, Tables& tables,
               Warnings& warnings) {
  const std::size_t corners = words.size() - 1;
  if (corners > kMaxObjCorners) {
    throw InputError(PositionOf(lines), fmt::format("a face of {} corners; up to {} can be read",
                                                    corners, kMaxObjCorners));
  }
  if (!CheckCorners(lines, words, tables, warnings)) return false;
  if (corners >= 3) return true;
  LeaveOut(lines, words, "a face of fewer than three corners", warnings);
  return false;
}

// Reads a statement of points or of a line through several vertices.
void ReadPointsOrLine(ObjLines& lines, const std::vector<std::string_view>& words, Tables& tables,
                      ObjStatements& statements, Warnings& warnings) {
  if (!CheckCorners(lines, words, tables, warnings)) return;
  if (statements.parts_line == 0) statements.parts_line = lines.line;
  std::vector<std::uint32_t> vertices;
  for (std::size_t i = 1; i < words.size(); ++i) {
    const std::string_view word = Corner(words[i]).position;
    std::int64_t index = 0;
    std::from_chars(word.data(), word.data() + word.size(), index);
    vertices.push_back(std::uint32_t(index > 0 ? index - 1 : tables.positions.count + index));
  }
  PointsAndLines& parts = statements.parts;
  if (words[0] == "p") {
    parts.points.insert(parts.points.end(), vertices.begin(), vertices.end());
    return;
  }
  for (std::size_t i = 1; i < vertices.size(); ++i) {
    parts.lines.emplace_back(vertices[i - 1], vertices[i]);
  }
}

// Returns whether an index means one of `count` elements, of which `before` are before it.
bool IsThere(std::string_view text, std::int64_t before, std::int64_t count) {
  std::int64_t index = 0;
  std::from_chars(text.data(), text.data() + text.size(), index);
  return index != 0 && -index <= before && index <= count;
}

// Writes the corners of all faces as tinyobjloader reads them: without texture vertices and normals
// that the file does not have, and without slashes that nothing follows.
void RewriteCorners(ObjLines lines, const Tables& tables, std::string& text) {
  lines.next = lines.joins_read = 0, lines.next_line = 1;
  std::vector<std::string_view> words;
  std::int64_t uvs = 0, normals = 0;
  while (NextStatement(lines, words)) {
    uvs += words[0] == "vt", normals += words[0] == "vn";
    if (words[0] != "f") continue;
    for (std::size_t i = 1; i < words.size(); ++i) {
      const Corner corner(words[i]);
      std::string written(corner.position);
      if (IsThere(corner.uv, uvs, tables.uvs.count)) written += "/" + std::string(corner.uv);
      if (IsThere(corner.normal, normals, tables.normals.count)) {
        written +=
            (written.size() > corner.position.size() ? "/" : "//") + std::string(corner.normal);
      }
      written.resize(words[i].size(), ' ');
      text.replace(std::size_t(words[i].data() - lines.text.data()), written.size(), written);
    }
  }
}

bool IsUsedBeyondItsEnd(const IndexedTable& table) { return table.greatest > table.count; }

// Names what faces ask of a table beyond its end.
void WarnOfMissing(const IndexedTable& table, const ObjLines& lines, Warnings& warnings) {
  const std::string has = table.count == 0
                              ? "none of these: ignored"
                              : fmt::format("{} of these: those beyond are ignored", table.count);
  AddWarning(warnings, InputPosition::Line(lines.path, table.greatest_line),
             fmt::format("faces have {} indices, and the file has {}", table.name, has));
}

// Returns the number of the vertex that an index means, with `count` vertices before it.
std::int64_t VertexOf(std::string_view text, std::int64_t count) {
  std::int64_t index = 0;
  std::from_chars(text.data(), text.data() + text.size(), index);
  return index > 0 ? index : count + 1 + index;
}

// Leaves out all faces, points and lines of vertices that are no place; those are warned of
// already.
void LeaveOutLost(ObjLines& lines, const Tables& tables, ObjStatements& statements) {
  std::vector<std::string_view> words;
  std::int64_t count = 0;
  lines.next = lines.joins_read = 0, lines.next_line = 1;
  while (NextStatement(lines, words)) {
    if (words[0] == "v") ++count;
    if (words[0] != "f") continue;
    const bool lost = std::any_of(words.begin() + 1, words.end(), [&](std::string_view word) {
      return tables.lost.contains(VertexOf(Corner(word).position, count));
    });
    if (!lost) continue;
    BlankOut(lines, WholeStatement(words));
    --statements.faces;
  }
  const auto lost = [&](std::uint32_t vertex) {
    return tables.lost.contains(std::int64_t{vertex} + 1);
  };
  std::erase_if(statements.parts.points, lost);
  std::erase_if(statements.parts.lines,
                [&](const auto& line) { return lost(line.x) || lost(line.y); });
}

// Leaves out all faces, points and lines of vertices that the file does not have.
void LeaveOutBeyond(ObjLines& lines, const Tables& tables, ObjStatements& statements,
                    Warnings& warnings) {
  std::vector<std::string_view> words;
  lines.next = lines.joins_read = 0, lines.next_line = 1;
  while (NextStatement(lines, words)) {
    if (words[0] != "f") continue;
    const bool beyond = std::any_of(words.begin() + 1, words.end(), [&](std::string_view word) {
      return VertexOf(Corner(word).position, 0) > tables.positions.count;
    });
    if (!beyond) continue;
    LeaveOut(lines, words, "a face with indices beyond the vertices of the file", warnings);
    --statements.faces;
  }
  const auto beyond = [&](std::uint32_t vertex) { return vertex >= tables.positions.count; };
  PointsAndLines& parts = statements.parts;
  const std::size_t erased =
      std::erase_if(parts.points, beyond) + std::erase_if(parts.lines, [&](const auto& line) {
        return beyond(line.x) || beyond(line.y);
      });
  if (erased == 0) return;
  AddWarning(warnings, InputPosition::Line(lines.path, statements.parts_line),
             "points or lines of vertices that the file does not have: left out");
}

}  // namespace

ObjStatements CheckObj(ObjLines& lines, Warnings& warnings) {
  ObjStatements statements;
  Tables tables;
  std::unordered_set<std::string> seen;
  std::vector<std::string_view> words;
  while (NextStatement(lines, words)) {
    const std::string_view word = words[0];
    const bool has_numbers = word == "v" || word == "vn" || word == "vt";
    const bool not_finite = has_numbers && ReplaceNotFinite(lines, words);
    if (not_finite) {
      const char* const what = word == "v"    ? "its faces are left out"
                               : word == "vn" ? "the normal is that of its triangles"
                                              : "0 is taken";
      AddWarning(warnings, PositionOf(lines),
                 fmt::format("'{}' with a number that is not finite: {}", word, what));
    }
    if (word == "v") {
      CheckObjNumbers(lines, words, 3, 7);  // optionally followed by a weight, a colour or both
      ++tables.positions.count;
      if (not_finite) tables.lost.insert(tables.positions.count);
    } else if (word == "f") {
      if (CheckFace(lines, words, tables, warnings)) ++statements.faces;
      for (const std::string_view corner : words) tables.rewrite |= corner.ends_with('/');
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
        AddWarning(warnings, PositionOf(lines), fmt::format("'{}' without a name: ignored", word));
        BlankOut(lines, WholeStatement(words));
      } else if (word == "mtllib") {
        statements.libraries.push_back(name);
      } else if (seen.insert(name.name).second) {
        statements.materials.push_back(name);
      }
    } else if (word == "p" || word == "l") {
      ReadPointsOrLine(lines, words, tables, statements, warnings);
      BlankOut(lines, WholeStatement(words));
    } else if (word == "t" || word == "vw") {
      // These are extensions of tinyobjloader, which trusts the counts in them.
      AddWarning(warnings, PositionOf(lines),
                 fmt::format("'{}' is not a statement of OBJ: left out", word));
      BlankOut(lines, WholeStatement(words));
    } else if (word != "o" && word != "g") {
      AddWarning(warnings, PositionOf(lines),
                 fmt::format("'{}' is not supported: left out", word.substr(0, 40)));
    }
  }
  for (const IndexedTable* const table : {&tables.uvs, &tables.normals}) {
    if (!IsUsedBeyondItsEnd(*table)) continue;
    tables.rewrite = true;
    WarnOfMissing(*table, lines, warnings);
  }
  if (tables.rewrite) RewriteCorners(lines, tables, lines.text);
  if (!tables.lost.empty()) LeaveOutLost(lines, tables, statements);
  if (IsUsedBeyondItsEnd(tables.positions)) LeaveOutBeyond(lines, tables, statements, warnings);
  return statements;
}

}  // namespace skywave
