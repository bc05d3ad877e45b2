// What an OBJ file says, statement by statement, held to the format before tinyobjloader reads it.
//
// tinyobjloader is lenient: a word that is no number becomes 0, a face with an index out of range
// is left out, and no message of it names a line. So a pass of our own goes first; what it lets
// through means the same to both.
#pragma once

#include <cstddef>
#include <string>
#include <vector>

#include "scene/obj/lines.h"
#include "scene/warnings.h"

namespace skywave {

// Polygons with more corners are refused: cutting ears takes cubic time at worst.
inline constexpr std::size_t kMaxObjCorners = 1024;

struct ObjName {
  std::string name;
  std::size_t line = 0;
};

struct ObjStatements {
  std::vector<ObjName> libraries;  // of mtllib, as written
  std::vector<ObjName> materials;  // of usemtl, each once
  bool has_smoothing = false;      // there is an `s`, so the file says where it is smooth
  std::size_t faces = 0;
};

// Throws InputError with the line on numbers that are none or not finite, indices out of range,
// faces of fewer than three corners. Warns of statements that are not rendered.
ObjStatements CheckObj(ObjLines& lines, Warnings& warnings);

}  // namespace skywave
