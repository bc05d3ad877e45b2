// Scenes of arrays for the library, and pictures of them.
#pragma once

#include <cstddef>
#include <cstdint>
#include <cstring>
#include <vector>

#include "skywave/skywave.h"

namespace skywave {

using api::Options;
using api::Vector;

inline const Options kSmall = {{"size", "24x16"}, {"spp", "4"}, {"max-depth", "3"}};

inline Options With(Options options, const Options& more) {
  options.insert(options.end(), more.begin(), more.end());
  return options;
}

inline std::vector<float> Pixels(const api::Renderer& renderer) {
  std::vector<float> rgb(std::size_t(renderer.width()) * std::size_t(renderer.height()) * 3);
  renderer.CopyPicture(rgb);
  return rgb;
}

inline std::vector<float> Render(const api::Scene& scene, const Options& options) {
  api::Renderer renderer(scene, options);
  renderer.Render();
  return Pixels(renderer);
}

inline bool SameBits(const std::vector<float>& a, const std::vector<float>& b) {
  return a.size() == b.size() && std::memcmp(a.data(), b.data(), a.size() * sizeof(float)) == 0;
}

// A square of side 2 in the plane y = 0 whose normal is +y, with uvs.
struct Square {
  std::vector<float> positions = {-1, 0, 1, 1, 0, 1, 1, 0, -1, -1, 0, -1};
  std::vector<float> normals = {0, 1, 0, 0, 1, 0, 0, 1, 0, 0, 1, 0};
  std::vector<float> uvs = {0, 1, 1, 1, 1, 0, 0, 0};
  std::vector<std::uint32_t> triangles = {0, 1, 2, 0, 2, 3};

  api::MeshArrays mesh(int material = 0) const {
    return {.positions = positions,
            .triangles = triangles,
            .normals = normals,
            .uvs = uvs,
            .material = material};
  }
};

// A map whose texels all differ.
struct Map {
  std::vector<float> rgb = std::vector<float>(std::size_t(16) * 8 * 3);
  Map() {
    for (std::size_t i = 0; i < rgb.size(); ++i) rgb[i] = 0.25f + float(i * 37 % 101) / 50;
  }
  api::ImageArray image() const { return {rgb, 16, 8}; }
};

// The camera looks down at the middle of the square, so closely that all of its film sees about one
// point; no filter weighs pixels.
inline const Options kLookDown = {{"size", "4x4"},    {"spp", "16"},        {"filter", "box"},
                                  {"max-depth", "1"}, {"eye", "0,2,0.001"}, {"target", "0,0,0"},
                                  {"fov", "0.01"}};

}  // namespace skywave
