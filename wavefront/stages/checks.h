// Invariants of the tables, verified wave by wave in builds with SKYWAVE_CHECKS and free otherwise.
// A broken one is a bug of the program: it is printed with its row, and the program aborts.
#pragma once

#include <cstdint>

#include "kernels/columns.h"

namespace skywave {

#ifdef SKYWAVE_CHECKS
// Origins finite, directions of unit length, throughput finite and >= 0, pdf >= 0.
void CheckRays(const RayColumns& rays, std::uint32_t n);
// Normals of unit length and on wo's side.
void CheckSurfaces(const SurfaceColumns& surfaces, std::uint32_t n);
// Directions of unit length, radiance finite and >= 0, pdf not NaN.
void CheckLightSamples(const LightColumns& lights, std::uint32_t n);
// Reaches are numbers; directions of open rays of unit length.
void CheckShadowRays(const LightColumns& lights, std::uint32_t n);
#else
inline void CheckRays(const RayColumns&, std::uint32_t) {}
inline void CheckSurfaces(const SurfaceColumns&, std::uint32_t) {}
inline void CheckLightSamples(const LightColumns&, std::uint32_t) {}
inline void CheckShadowRays(const LightColumns&, std::uint32_t) {}
#endif

}  // namespace skywave
