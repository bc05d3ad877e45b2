// Evaluates textures that vary in space for each shape that has them, into images over the shape's
// (u, v) or over its triangles.
#pragma once

#include <cstdint>
#include <memory>
#include <string>

#include "scene/pbrt/state.h"

namespace skywave {

// The shape for which textures are evaluated.
struct PbrtSolidShape {
  const std::string& type;
  const InputPosition& position;
  bool fixed_uvs;                          // something else on it depends on its (u, v)
  std::shared_ptr<const PbrtSolid> alpha;  // null: its alpha does not vary in space
};
// Returns the material of one shape, whose mesh is in the world: `material`, which is `named` or a
// copy of it with alpha, with the images of what varies in space: its alpha, and what does on the
// material and on those that it is mixed of. Spheres, disks and cylinders keep their (u, v); other
// shapes, which have triangles, get a square of the image for each (scene/shapes/triangle_atlas.h).
// Where that cannot be, because there are too many triangles, other textures, or no texels left for
// the scene, the material gets its defaults, with a warning at the shape.
std::uint32_t MaterialWithSolids(PbrtReader& reader, std::uint32_t named, std::uint32_t material,
                                 const PbrtSolidShape& shape, Mesh& mesh);

}  // namespace skywave
