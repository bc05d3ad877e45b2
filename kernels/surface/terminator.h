// Coarse meshes with smooth normals are dark where light passes behind their triangles but not
// behind the smooth surface that they stand for, which shows the triangles where light ends.
#pragma once

#include <cstdint>

#include "kernels/columns.h"
#include "kernels/surface/surface.h"

namespace skywave {

// Moves the points of rows [0, n) of `surfaces`, which are prepared, to a surface that bulges as
// the normals of the corners say, and makes the interpolated normal, before any map, their
// geometric one (Hanika 2021). Rows that are shaded with the geometric normal stay as they are. The
// rows are of BSDFs that do not transmit.
void RoundSurfaces(const TriangleTables& triangles, std::uint32_t n,
                   const SurfaceColumns& surfaces);

}  // namespace skywave
