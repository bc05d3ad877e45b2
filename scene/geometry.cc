#include "scene/geometry.h"

namespace skywave {

namespace {

bool HaveOneBvh(const GeometryTables& a, const GeometryTables& b) {
  return !a.has_alpha() && !b.has_alpha() && a.vertices == b.vertices && a.indices == b.indices;
}

}  // namespace

Geometry::Geometry(const Scene& scene, const std::string& path, int threads,
                   const std::string& embree_config, bool keep_uvs,
                   const std::shared_ptr<const Geometry>& twin)
    : tables_(MakeGeometryTables(scene, path, keep_uvs)),
      opacity_(tables_.opacity_view()),
      shares_bvh_(twin && HaveOneBvh(tables_, twin->tables_)),
      embree_(shares_bvh_
                  ? std::shared_ptr<const EmbreeScene>(twin, twin->embree_.get())
                  : std::make_shared<const EmbreeScene>(
                        EmbreeTriangles{.vertices = tables_.vertices.data(),
                                        .vertex_count = tables_.vertex_count(),
                                        .indices = tables_.indices.data(),
                                        .triangle_count = std::uint32_t(tables_.triangle_count()),
                                        .first_with_alpha = tables_.first_with_alpha,
                                        .opacity = opacity_},
                        path, threads, embree_config)) {}

MaterialView Geometry::materials() const {
  return {.records = tables_.materials.data(),
          .conductor = tables_.ggx,
          .sheen = tables_.sheen,
          .measured = tables_.measured.data(),
          .coats = tables_.coats.data()};
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
