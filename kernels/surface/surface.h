// Surface preparation: from barycentric hits to points that can be shaded.
#pragma once

#include <cstdint>

#include "kernels/columns.h"

namespace skywave {

// Fills the second block of rows [0, n) of `surfaces` from the first one (see SurfaceColumns):
// normals interpolated and turned to wo's side, the point lifted off the surface, the colour.
// `materials`: table of MaterialRecord.
void PrepareSurfaces(const TriangleRecord* triangles, const MaterialRecord* materials,
                     std::uint32_t n, const SurfaceColumns& surfaces);

// Writes Varying::kTangent of rows [0, n). `tangents`: one a triangle (EncodeNormal), world space;
// what of it lies in the surface is the tangent, the frame's own first axis where nothing does.
void PrepareTangents(const std::uint32_t* tangents, std::uint32_t n,
                     const SurfaceColumns& surfaces);

// Multiplies throughput of rows [0, n) that are seen from inside by what their ray has lost there,
// exp(-k t) (Beer and Lambert): rows of BSDFs with an inside, which have
// MaterialField::kAbsorption.
void AbsorbInside(const MaterialRecord* materials, std::uint32_t n, const SurfaceColumns& surfaces);

// A unit vector as two 16-bit octahedral coordinates (Cigolle et al. 2014): x in the low half.
// Off by at most 6.5e-5 radians, near the diagonals.
std::uint32_t EncodeNormal(float x, float y, float z);

}  // namespace skywave
