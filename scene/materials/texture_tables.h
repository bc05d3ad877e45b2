// The images of a scene as kernels read them: mip pyramids, packed, and texture coordinates by
// triangle.
#pragma once

#include <cstdint>
#include <string>
#include <vector>

#include "image/image.h"
#include "kernels/surface/normal_map.h"
#include "kernels/surface/texture.h"
#include "scene/scene.h"

namespace skywave {

struct TextureTables {
  std::vector<TextureRecord> records;
  std::vector<TextureLevel> levels;
  std::vector<std::uint32_t> texels;
  std::vector<TriangleUvs> uvs;  // by triangle; empty if nobody asks for them
  // By texture: what the slopes in its texels are multiplied with; 1 but for heights.
  std::vector<float> slopes;

  TextureView view() const;  // of tables that stay where they are
  std::size_t bytes() const;
};

// Everything but the uvs. Throws InputError(path) for textures that name no image, transforms that
// are not finite, and more texels than a table can hold.
TextureTables MakeTextureTables(const Scene& scene, const std::string& path);

// The uvs and their density of one triangle; `corners` in the order of its record.
TriangleUvs MakeTriangleUvs(const Mesh& mesh, const glm::uvec3& corners);

// The axes of `texture` on one triangle: the mesh's tangents, or else by its uvs.
TriangleTangents MakeTriangleTangents(const Mesh& mesh, const glm::uvec3& corners,
                                      const Texture& texture);

// Half of `image` in both directions, at least one texel: each texel is the mean over its area.
Image HalfSize(const Image& image);

}  // namespace skywave
