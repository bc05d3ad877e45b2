// Surface preparation turns barycentric hits into points that can be shaded.
#pragma once

#include <cstdint>

#include "kernels/columns.h"
#include "kernels/surface/instances.h"

namespace skywave {

// The tables that say what a triangle is; those of corners have a word of padding at their end.
struct TriangleTables {
  const TriangleRecord* records;
  const std::uint32_t* corners;     // by record, three rows of `positions`
  const float* positions;           // xyz in the space of the mesh
  const InstanceRecord* instances;  // null: there are no instances
};

// Fills the second block of rows [0, n) of `surfaces` from the first one (see SurfaceColumns):
// points are interpolated and lifted off the surface, normals interpolated and turned to wo's side,
// colours read.
void PrepareSurfaces(const TriangleTables& triangles, const MaterialRecord* materials,
                     std::uint32_t n, const SurfaceColumns& surfaces);

// Set in the tangent of a triangle whose second axis of images lies clockwise of the first as its
// normals see it; that is the lowest bit of the direction, which does not show.
inline constexpr std::uint32_t kMirroredTangent = 1;

// Writes Varying::kTangent of rows [0, n). `tangents` has one per triangle (EncodeNormal and
// kMirroredTangent), in the space of its mesh; its projection onto the surface is the tangent, or
// the frame's own first axis if that is null. `instances` is null in scenes without instances.
void PrepareTangents(const std::uint32_t* tangents, const InstanceRecord* instances,
                     std::uint32_t n, const SurfaceColumns& surfaces);

// Multiplies throughput of those rows [0, n) that are seen from inside by the transmittance of
// their ray, exp(-k t) (Beer and Lambert). The rows are of BSDFs with an inside, which have
// MaterialField::kAbsorption.
void AbsorbInside(const MaterialRecord* materials, std::uint32_t n, const SurfaceColumns& surfaces);

// Encodes a unit vector as two 16-bit octahedral coordinates (Cigolle et al. 2014), x in the low
// half. The result is off by at most 6.5e-5 radians, near the diagonals.
std::uint32_t EncodeNormal(float x, float y, float z);

}  // namespace skywave
