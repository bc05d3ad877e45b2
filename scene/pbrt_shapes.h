// pbrt's shapes as meshes in their own space: trianglemesh, plymesh, loopsubdiv, sphere.
#pragma once

#include <functional>
#include <optional>
#include <string>

#include "scene/mesh.h"
#include "scene/pbrt_parameters.h"
#include "scene/scene.h"
#include "scene/warnings.h"

namespace skywave {

// The mesh of `Shape "type"`, outside as pbrt has it before ReverseOrientation; nothing, with a
// warning, for shapes that are not supported. `resolve` turns a file name in the scene into a path.
// Throws InputError on wrong counts, indices out of range, missing files and more than
// kMaxSubdividedTriangles of loopsubdiv.
std::optional<Mesh> MakePbrtShape(const std::string& type, PbrtParameters& parameters,
                                  const std::function<std::string(const std::string&)>& resolve,
                                  Warnings& warnings);

}  // namespace skywave
