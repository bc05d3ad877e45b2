// Light paths at their vertices: what of the flux that arrives there goes on in a given direction.
// BSDF kernels evaluate radiance; these make flux of their values (Transport::kFlux in bsdf.h).
#pragma once

#include <cstdint>

#include "kernels/bsdf.h"

namespace skywave {

// Rows [0, n) of `values`, which `bsdf.evaluate` has written for the same rows: multiplies value by
// |wo.ns| |wi.ng| / (|wo.ng| |wi.ns|) and, where light is refracted, divides it by the squared
// index ratio. So value is f(light -> eye) |cos| with the geometric cosine of wi [1/sr] and the
// factor of the shading normal at wo: what a connection along wi multiplies the throughput with,
// together with the other end's value and 1 / distance^2. Densities stay. Directions: dir columns
// of `lights`.
void MakeFlux(const BsdfKernels& bsdf, const SurfaceColumns& surfaces,
              const MaterialView& materials, const LightColumns& lights, std::uint32_t n,
              const BsdfValueColumns& values);

// Moves the origins of rows [0, n) of surfaces that transmit to the side of the surface that dir of
// `lights` points to (see SurfaceColumns::lift), as evaluate_lights does.
void MoveToSide(const LightColumns& lights, std::uint32_t n, const SurfaceColumns& surfaces);

}  // namespace skywave
