// Optical flow: how far what a pixel sees is from there at another frame, on the film.
#pragma once

#include <memory>
#include <optional>

#include "kernels/camera.h"
#include "kernels/columns.h"
#include "scene/geometry.h"

namespace skywave {

// The scene at another frame of its animation: the same vertices, instances and camera elsewhere.
struct Moment {
  std::shared_ptr<const Geometry> geometry;
  CameraView camera;
};

// The frames beside that of a picture; unset: no layer asks for it.
struct FrameMotion {
  std::optional<Moment> next, previous;
};

// Returns the place of a point of the world on the whole film [pixels, from its top left corner,
// y down], which may lie outside of it; nothing behind the camera. The film has to be a plane
// (HasPlaneFilm), and what a lens blurs is where its middle sees it.
std::optional<glm::dvec2> PlaceOnFilm(const CameraView& camera, const glm::dvec3& point);

// Writes rows [0, n) of `x`, `y` and `known`: where the point of a surface of `geometry` is on the
// film at `then`, less where `camera` sees it now [pixels], and 1; 0 of all where a camera cannot
// see so far behind itself.
void FindFlow(const Geometry& geometry, const CameraView& camera, const Moment& then,
              const SurfaceColumns& surfaces, std::uint32_t n, float* x, float* y, float* known);

}  // namespace skywave
