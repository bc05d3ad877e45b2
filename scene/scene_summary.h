// Counts the contents of a scene for `skywave info`.
#pragma once

#include <cstddef>
#include <optional>
#include <string_view>
#include <vector>

#include "scene/scene.h"

namespace skywave {

struct SceneSummary {
  std::size_t meshes = 0, triangles = 0, vertices = 0;  // those of an object count once
  std::size_t objects = 0, instances = 0;
  std::size_t triangles_seen = 0;  // those of an object count once for each of its instances
  std::size_t meshes_with_normals = 0, meshes_with_uvs = 0;
  std::size_t mesh_bytes = 0;                      // total of the arrays of all meshes
  std::optional<Bounds> bounds;                    // nothing if there is no triangle
  std::vector<std::size_t> triangles_of_material;  // by index into Scene::materials
};

SceneSummary Summarize(const Scene& scene);

std::string_view ToString(BsdfKind kind);

}  // namespace skywave
