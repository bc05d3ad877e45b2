// What is baked for a shape of a pbrt file, read off at places of its surface.
#pragma once
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <optional>
#include <random>
#include <string>
#include <vector>

#include "image/image.h"
#include "scene/pbrt/reader.h"

namespace skywave {

struct Place {
  glm::vec3 position, normal, color;
};

// Returns points of the only mesh, uniform in each triangle, with what a lookup of one of the
// material's textures shows there: the nearest texel.
inline std::vector<Place> Places(
    const Scene& scene, int per_triangle,
    std::optional<std::uint32_t> Material::*which = &Material::color_texture) {
  const Mesh& mesh = scene.meshes.at(0);
  const Material& material = scene.materials[mesh.material];
  const Texture& texture = scene.textures[(material.*which).value()];
  const glm::vec3 factor = which == &Material::color_texture ? material.reflectance : glm::vec3(1);
  const CompactImage& image = scene.images[texture.image];
  std::mt19937 random(7);
  std::uniform_real_distribution<float> uniform(0, 1);
  std::vector<Place> places;
  for (const glm::uvec3& t : mesh.triangles) {
    for (int i = 0; i < per_triangle; ++i) {
      float u = uniform(random), v = uniform(random);
      if (u + v > 1) u = 1 - u, v = 1 - v;
      const auto blend = [&](const auto& of) {
        return (1 - u - v) * of[t.x] + u * of[t.y] + v * of[t.z];
      };
      const glm::vec2 at = texture.transform * glm::vec3(blend(mesh.uvs), 1);
      const auto texel =
          image.Pixel(glm::clamp(int(at.x * float(image.width)), 0, image.width - 1),
                      glm::clamp(int(at.y * float(image.height)), 0, image.height - 1));
      places.push_back({blend(mesh.positions),
                        mesh.normals.empty() ? glm::vec3(0) : glm::normalize(blend(mesh.normals)),
                        factor * glm::vec3(texel[0], texel[1], texel[2])});
    }
  }
  return places;
}

inline Scene Parse(const std::string& text) { return ParsePbrt("WorldBegin " + text, "t.pbrt"); }

// Returns the scene of a text of which nothing is left out.
inline Scene ParseAll(const std::string& text) {
  Scene scene = Parse(text);
  EXPECT_TRUE(scene.warnings.empty()) << scene.warnings[0];
  return scene;
}

// Returns whether a cell of checks, the one around `at`, has the first colour; nothing within
// `margin` of an edge, where texels may be either.
template <class Vector>
std::optional<bool> IsFirst(const Vector& at, double margin) {
  bool first = true;
  for (int i = 0; i < Vector::length(); ++i) {
    if (std::abs(double(at[i]) - std::round(double(at[i]))) < margin) return std::nullopt;
    if (int(std::floor(at[i])) % 2 != 0) first = !first;
  }
  return first;
}

// Expects checks of two colours in space or in a plane, both of them often; `at` returns where in
// them a place is.
template <class At>
void ExpectChecks(const std::vector<Place>& places, double margin, const glm::vec3& first,
                  const glm::vec3& second, const At& at) {
  int counts[2] = {0, 0};
  for (const Place& place : places) {
    const std::optional<bool> is_first = IsFirst(at(place), margin);
    if (!is_first) continue;
    ++counts[*is_first];
    const glm::vec3 expected = *is_first ? first : second;
    ASSERT_LT(glm::length(place.color - expected), 1e-3f)
        << place.position.x << " " << place.position.y << " " << place.position.z << " shows "
        << place.color.x;
  }
  EXPECT_GT(counts[0] + counts[1], int(places.size()) / 2);
  EXPECT_GT(std::min(counts[0], counts[1]), (counts[0] + counts[1]) / 4);
}

inline double Clamped(double x) { return std::clamp(x, 0.0, 1.0); }

}  // namespace skywave
