// Builds pbrt's shapes as meshes in their own space: trianglemesh, plymesh, loopsubdiv,
// bilinearmesh, curve, heightfield, and round shapes (scene/pbrt/round_shapes.h).
#pragma once

#include <functional>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "scene/pbrt/parameters.h"
#include "scene/scene.h"
#include "scene/shapes/loop_subdivision.h"
#include "scene/shapes/mesh.h"
#include "scene/warnings.h"

namespace skywave {

struct PbrtShapeOptions {
  bool needs_uvs = false;   // gives round shapes and curves texture coordinates
  bool corner_uvs = false;  // gives coordinates to the corners of meshes that have none
  std::size_t max_triangles = kMaxSubdividedTriangles;  // limit for one shape
};

struct PbrtShape {
  Mesh mesh;
  std::size_t faces = 1;  // triangles, patches or polygons of the file; 1: a round shape, or curves
};

// Returns the mesh of `Shape "type"`, with pbrt's outside before ReverseOrientation; for shapes
// that are not supported and for files that cannot be read, adds a warning and returns nothing.
// `resolve` turns a file name in the scene into a path. Throws InputError on wrong counts, indices
// out of range, missing files, and on a loopsubdiv, bilinearmesh or curve of more than
// kMaxSubdividedTriangles.
std::optional<PbrtShape> MakePbrtShape(
    const std::string& type, PbrtParameters& parameters,
    const std::function<std::string(const std::string&)>& resolve, const PbrtShapeOptions& options,
    Warnings& warnings);

}  // namespace skywave
