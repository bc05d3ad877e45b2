// Wavefront OBJ files with their material libraries (mtl.h), read by tinyobjloader.
//
// Polygons are cut into triangles. Corners take the file's normals; where a face has none, its `s`
// statement decides: a number makes it smooth with the faces of that group, off or 0 flat, as in
// Blender. A file without any `s` is smooth up to creases (smooth_normals.h), as Mitsuba does for
// scans, but without rounding a cube. The world is right-handed and y is up.
//
// There is one mesh a material, or two where parts of it are flat. Faces without material, or with
// one that no library has, are grey Lambert.
#pragma once

#include <string>

#include "scene/read_options.h"
#include "scene/scene.h"

namespace skywave {

// Throws InputError with file and line: see obj_check.h, mtl.h; a library that is not there is one
// too (kExitIo).
Scene ReadObj(const std::string& path, const ReadOptions& options = {});

// The same from memory; libraries are looked up beside `path`.
Scene ParseObj(std::string text, const std::string& path, const ReadOptions& options = {});

}  // namespace skywave
