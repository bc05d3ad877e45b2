// Kernels read the images of a scene from these tables: packed mip pyramids, and texture
// coordinates by triangle.
#pragma once

#include <cstdint>
#include <span>
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
  // By triangle; empty if nobody asks for them. Those of second sets, where a texture uses one,
  // follow those of all first ones.
  std::vector<TriangleUvs> uvs;
  // The factor of the slopes in its texels, by texture; it is 1 except for heights.
  std::vector<float> slopes;

  TextureView view() const;  // valid as long as the tables stay where they are
  std::size_t bytes() const;
};

// Makes all tables but the uvs. Throws InputError(path) for textures that name no image, transforms
// that are not finite, and more texels than a table can hold.
TextureTables MakeTextureTables(const Scene& scene, const std::string& path);

// Returns the uvs of a set and their density of one triangle; `corners` are in the order of its
// record.
TriangleUvs MakeTriangleUvs(const Mesh& mesh, UvSet set, const glm::uvec3& corners);
// Appends those of the second set of all triangles, which stand for what `textures` says.
void AppendSecondUvs(std::span<const TriangleUvs> uvs, std::span<const Texture> textures,
                     TextureTables& tables);

// Returns the axes of `texture` on one triangle, by the mesh's tangents or else by its uvs.
TriangleTangents MakeTriangleTangents(const Mesh& mesh, const glm::uvec3& corners,
                                      const Texture& texture);

// Returns how the slopes of heights, which `texture` has in an image of width x height, lie on one
// triangle. Those of a mesh with tangents of its own are not stretched.
TriangleSlopes MakeTriangleSlopes(const Mesh& mesh, const glm::uvec3& corners,
                                  const Texture& texture, int width, int height);

// Returns `image` halved in both directions, to one texel at least: each texel is the mean over its
// area.
Image HalfSize(const CompactImage& image);

}  // namespace skywave
