// pbrt's shapes as meshes in their own space: trianglemesh, plymesh, loopsubdiv, bilinearmesh,
// sphere, cylinder, disk.
#pragma once

#include <functional>
#include <optional>
#include <string>

#include "scene/pbrt/parameters.h"
#include "scene/scene.h"
#include "scene/shapes/loop_subdivision.h"
#include "scene/shapes/mesh.h"
#include "scene/warnings.h"

namespace skywave {

struct PbrtShapeOptions {
  bool needs_uvs = false;  // round shapes have texture coordinates, at the price of a seam
  std::size_t max_triangles = kMaxSubdividedTriangles;  // that one shape may be cut into
};

// The mesh of `Shape "type"`, outside as pbrt has it before ReverseOrientation; nothing, with a
// warning, for shapes that are not supported. `resolve` turns a file name in the scene into a path.
// Throws InputError on wrong counts, indices out of range, missing files and more than
// kMaxSubdividedTriangles
// of loopsubdiv.
std::optional<Mesh> MakePbrtShape(const std::string& type, PbrtParameters& parameters,
                                  const std::function<std::string(const std::string&)>& resolve,
                                  const PbrtShapeOptions& options, Warnings& warnings);

}  // namespace skywave
