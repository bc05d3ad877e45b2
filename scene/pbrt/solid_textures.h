// Textures that are functions of the place or of the normal. They are evaluated for each shape that
// has them, into an image over the shape's (u, v).
#pragma once

#include <memory>
#include <string>
#include <string_view>
#include <vector>

#include "scene/materials/texture_baking.h"
#include "scene/pbrt/state.h"

namespace skywave {

// These read the classes checkerboard (dimension 3), directionmix, marble, and noise: fbm, windy
// and wrinkled. The texture has no value if an operand varies, with a warning.
PbrtTexture ReadSolidCheckerboard(PbrtReader& reader, PbrtParameters& parameters,
                                  const PbrtTextures& same);
PbrtTexture ReadDirectionMix(PbrtReader& reader, PbrtParameters& parameters,
                             const PbrtTextures& same);
PbrtTexture ReadMarble(PbrtReader& reader, PbrtParameters& parameters);
PbrtTexture ReadNoise(PbrtReader& reader, PbrtParameters& parameters, const std::string& kind);

// Returns what `combine` makes of textures of which one at least varies in space. It has no value,
// with a warning, if others are images or if it would take more than kMaxPbrtEvaluations.
PbrtTexture CombineInSpace(PbrtReader& reader, const PbrtParameters& parameters,
                           const std::vector<PbrtTexture>& textures, const CombineTexels& combine);

// Returns whether a mapping has (u, v) by the place, and not by those of the shape: "planar",
// "spherical" and "cylindrical".
bool IsPbrtMappingInSpace(std::string_view mapping);

// Returns a texture over (u, v) laid in the space in which it is defined by such a mapping: over
// the plane of the vectors "v1" and "v2", or around the z axis. One without an image stays as it
// is.
PbrtTexture LayInSpace(PbrtReader& reader, PbrtParameters& parameters, std::string_view mapping,
                       const PbrtTexture& texture);

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
