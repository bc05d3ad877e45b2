// Checks an OBJ file against the format, statement by statement, before tinyobjloader reads it.
//
// tinyobjloader is lenient: a word that is not a number becomes 0, a face with an index out of
// range is dropped, and none of its messages names a line. So Skywave makes a pass of its own
// first; anything that passes it has the same meaning for both.
#pragma once

#include <cstddef>
#include <string>
#include <vector>

#include "scene/obj/lines.h"
#include "scene/shapes/points.h"
#include "scene/warnings.h"

namespace skywave {

// Polygons with more corners are refused because ear clipping takes cubic time in the worst case.
inline constexpr std::size_t kMaxObjCorners = 1024;

struct ObjName {
  std::string name;
  std::size_t line = 0;
};

struct ObjStatements {
  std::vector<ObjName> libraries;  // names after mtllib, as written
  std::vector<ObjName> materials;  // names after usemtl, each once
  bool has_smoothing = false;      // there is an `s`, so the file defines where it is smooth
  std::size_t faces = 0;
  PointsAndLines parts;        // of the positions in the file
  std::size_t parts_line = 0;  // the first one's
};

// Throws InputError with the line for words that are not finite numbers. Adds warnings for what is
// left out, and blanks out in `lines` what tinyobjloader would take for something else: its own
// statements, faces of fewer than three corners or with indices of elements that the file does not
// have, indices into tables that are empty; also points and lines, which are read here.
ObjStatements CheckObj(ObjLines& lines, Warnings& warnings);

}  // namespace skywave
