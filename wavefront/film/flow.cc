#include "wavefront/film/flow.h"

#include <cassert>
#include <cmath>
#include <glm/glm.hpp>

namespace skywave {
namespace {

glm::dvec3 Axis(const float (&axis)[3]) { return {axis[0], axis[1], axis[2]}; }

// Returns a point of the triangle of a record of `named`, where `geometry` has its vertices and its
// instance.
glm::dvec3 PointOf(const Geometry& named, const Geometry& geometry, std::uint32_t record,
                   std::uint32_t instance, float u, float v) {
  const std::uint32_t* const corners = named.triangle_tables().corners + 3 * std::size_t{record};
  const float* const vertices = geometry.triangle_tables().positions;
  const double weights[] = {1.0 - double(u) - double(v), double(u), double(v)};
  glm::dvec3 point(0);
  for (int i = 0; i < 3; ++i) {
    const float* const p = vertices + 3 * std::size_t{corners[i]};
    point += weights[i] * glm::dvec3(p[0], p[1], p[2]);
  }
  if (instance == 0) return point;
  const InstanceRecord& at = geometry.instances()[instance];
  glm::dvec3 placed;
  for (int row = 0; row < 3; ++row) {
    const float* const m = at.linear + 3 * row;
    placed[row] = m[0] * point.x + m[1] * point.y + m[2] * point.z + double(at.translation[row]);
  }
  return placed;
}

}  // namespace

std::optional<glm::dvec2> PlaceOnFilm(const CameraView& camera, const glm::dvec3& point) {
  assert(HasPlaneFilm(camera.kind));
  const glm::dvec3 right = Axis(camera.right), down = Axis(camera.down);
  const glm::dvec3 corner = Axis(camera.corner), origin = Axis(camera.origin);
  if (camera.kind == CameraKind::kOrthographic) {
    // point = corner + x right + y down + t forward
    const glm::dmat3 axes(right, down, Axis(camera.forward));
    const glm::dvec3 at = glm::inverse(axes) * (point - corner);
    return glm::dvec2(at.x, at.y);
  }
  // point = origin + t (corner + x right + y down)
  const glm::dvec3 at = glm::inverse(glm::dmat3(right, down, corner)) * (point - origin);
  if (!(at.z > 0)) return {};
  return glm::dvec2(at.x / at.z, at.y / at.z);
}

void FindFlow(const Geometry& geometry, const CameraView& camera, const Moment& then,
              const SurfaceColumns& surfaces, std::uint32_t n, float* x, float* y, float* known) {
  const bool instances = geometry.instances() != nullptr;
  for (std::uint32_t i = 0; i < n; ++i) {
    const auto place = [&](const Geometry& placed, const CameraView& seen_by) {
      return PlaceOnFilm(
          seen_by, PointOf(geometry, placed, surfaces.triangle[i],
                           instances ? surfaces.instance[i] : 0, surfaces.u[i], surfaces.v[i]));
    };
    const std::optional<glm::dvec2> from = place(geometry, camera);
    const std::optional<glm::dvec2> to = place(*then.geometry, then.camera);
    const bool both = from && to;
    const glm::dvec2 flow = both ? *to - *from : glm::dvec2(0);
    x[i] = float(flow.x), y[i] = float(flow.y), known[i] = both ? 1 : 0;
  }
}

}  // namespace skywave
