#include "scene/geometry.h"

namespace skywave {

Geometry::Geometry(const Scene& scene, const std::string& path, int threads,
                   const std::string& embree_config, bool keep_uvs)
    : tables_(MakeGeometryTables(scene, path, keep_uvs)),
      opacity_(tables_.opacity_view()),
      embree_({.vertices = tables_.vertices.data(),
               .vertex_count = tables_.vertex_count(),
               .indices = tables_.indices.data(),
               .triangle_count = std::uint32_t(tables_.triangle_count()),
               .first_with_alpha = tables_.first_with_alpha,
               .opacity = opacity_},
              path, threads, embree_config) {}

MaterialView Geometry::materials() const {
  return {.records = tables_.materials.data(),
          .conductor = tables_.ggx,
          .sheen = tables_.sheen,
          .measured = tables_.measured.data()};
}

NormalMapView Geometry::normal_maps() const {
  if (tables_.normal_maps.empty()) return {};
  return {.records = tables_.normal_maps.data(), .tangents = tables_.map_axes.data()};
}

glm::vec3 Geometry::Corner(std::size_t triangle, int corner) const {
  const std::uint32_t vertex = tables_.indices[3 * triangle + std::size_t(corner)];
  const float* const p = &tables_.vertices[3 * std::size_t{vertex}];
  return {p[0], p[1], p[2]};
}

}  // namespace skywave
