// The objects behind the first one that a pixel sees, for whole silhouettes: what the camera's ray
// would meet if it went on through all surfaces.
#pragma once

#include <cstdint>

#include "kernels/columns.h"
#include "scene/geometry.h"
#include "wavefront/rays/trace.h"

namespace skywave {

inline constexpr std::uint32_t kHiddenObjects = 7;
inline constexpr std::uint32_t kHiddenObjectRows = 256;  // the most at a time

// Writes rows [0, n), n <= kHiddenObjectRows, of `out`, kHiddenObjects columns: the numbers, from 1
// on (Geometry::MeshOf), of the next meshes behind a surface along the ray from the camera, each
// once, the nearest first; 0: there are no more. Rows that are not `wanted` are left alone.
void FindHiddenObjects(const Tracer& tracer, const Geometry& geometry,
                       const SurfaceColumns& surfaces, std::uint32_t n, const bool* wanted,
                       float* const* out);

}  // namespace skywave
