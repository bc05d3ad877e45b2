// Reads Wavefront OBJ files and their material libraries (mtl.h) with tinyobjloader.
//
// Polygons are cut into triangles. Corners take the file's normals; if a face has none, its `s`
// statement decides: a number makes it smooth with the faces of that group, off or 0 makes it flat,
// as in Blender. A file without any `s` is smooth up to creases (smooth_normals.h), as Mitsuba
// treats scans, but without rounding a cube. The world is right-handed with y up.
//
// There is one mesh per material, or two if parts of it are flat. Faces without a material, or with
// one that no library defines, are grey Lambert.
#pragma once

#include <string>

#include "scene/read_options.h"
#include "scene/scene.h"

namespace skywave {

// Throws InputError with file and line for the errors described in check.h and mtl.h. A library
// that is missing is a warning, and its materials are grey Lambert. If all vertices have colours,
// which are sRGB, they are factors of the reflectance, and are it without a material.
Scene ReadObj(const std::string& path, const ReadOptions& options = {});

// Parses the same from memory; libraries are looked up relative to `path`.
Scene ParseObj(std::string text, const std::string& path, const ReadOptions& options = {});

}  // namespace skywave
