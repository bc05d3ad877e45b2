// Builds pbrt's shapes as meshes in their own space: trianglemesh, plymesh, loopsubdiv,
// bilinearmesh, sphere, cylinder, disk, curve.
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

// Returns whether pbrt intersects a shape itself, which is a mesh of patches here.
bool IsRoundPbrtShape(std::string_view type);

// Returns the numbers that make the form of a round shape, without the radius of a whole sphere,
// which is taken out of the parameters: the sphere of radius 1 has a scale then.
struct PbrtRoundNumbers {
  std::vector<std::optional<float>> numbers;
  float scale = 1;
};
PbrtRoundNumbers FindRoundNumbers(const std::string& type, PbrtParameters& parameters);

// Returns the mesh of `Shape "type"`, with pbrt's outside before ReverseOrientation; for shapes
// that are not supported, adds a warning and returns nothing. `resolve` turns a file name in the
// scene into a path. Throws InputError on wrong counts, indices out of range, missing files, and on
// a loopsubdiv, bilinearmesh or curve of more than kMaxSubdividedTriangles.
std::optional<PbrtShape> MakePbrtShape(
    const std::string& type, PbrtParameters& parameters,
    const std::function<std::string(const std::string&)>& resolve, const PbrtShapeOptions& options,
    Warnings& warnings);

}  // namespace skywave
