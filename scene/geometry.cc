#include "scene/geometry.h"

#include <algorithm>
#include <iterator>
#include <span>

namespace skywave {

namespace {

bool HaveOneBvh(const GeometryTables& a, const GeometryTables& b) {
  const auto same = [](const EmbreeInstance& x, const EmbreeInstance& y) {
    return x.object == y.object && std::equal(std::begin(x.world_from_object),
                                              std::end(x.world_from_object), y.world_from_object);
  };
  const auto corners = [](const GeometryTables& tables) {
    return std::span(tables.corners).first(3 * tables.triangle_count());
  };
  return !a.has_alpha() && !b.has_alpha() && a.vertices == b.vertices &&
         std::ranges::equal(corners(a), corners(b)) && a.spans == b.spans &&
         a.calls_filter() == b.calls_filter() &&
         std::equal(a.instances.begin(), a.instances.end(), b.instances.begin(), b.instances.end(),
                    same);
}

}  // namespace

Geometry::Geometry(const Scene& scene, const std::string& path, int threads,
                   const std::string& embree_config, bool keep_uvs,
                   const std::shared_ptr<const Geometry>& twin)
    : origin_(scene.origin),
      tables_(MakeGeometryTables(scene, path, keep_uvs)),
      opacity_(tables_.opacity_view()),
      shares_bvh_(twin && HaveOneBvh(tables_, twin->tables_)),
      embree_(shares_bvh_ ? std::shared_ptr<const EmbreeScene>(twin, twin->embree_.get())
                          : std::make_shared<const EmbreeScene>(
                                EmbreeTriangles{.vertices = tables_.vertices.data(),
                                                .vertex_count = tables_.vertex_count(),
                                                .indices = tables_.corners.data(),
                                                .spans = tables_.spans,
                                                .instances = tables_.instances,
                                                .opacity = opacity_,
                                                .calls_filter = tables_.calls_filter()},
                                path, threads, embree_config)) {}

MaterialView Geometry::materials() const {
  return {.records = tables_.materials.data(),
          .conductor = tables_.ggx,
          .sheen = tables_.sheen,
          .measured = tables_.measured.data(),
          .coats = tables_.coats.data(),
          .varied = tables_.varied,
          .two_widths = tables_.two_widths,
          .dielectrics = tables_.dielectrics.data(),
          .anisotropic = tables_.anisotropic,
          .base_normals = !tables_.base_normal_maps.records.empty(),
          .glass_layers = tables_.glass_layers};
}

TextureView Geometry::textures() const {
  TextureView view = tables_.textures.view();
  view.instances = instances();
  return view;
}

glm::vec3 Geometry::Corner(std::size_t triangle, int corner) const {
  const std::uint32_t vertex = tables_.corners[3 * triangle + std::size_t(corner)];
  const float* const p = &tables_.vertices[3 * std::size_t{vertex}];
  return {p[0], p[1], p[2]};
}

}  // namespace skywave
