// At their vertices light paths need the part of the arriving flux that goes on in a given
// direction. BSDF kernels evaluate radiance; these turn their values into flux (Transport::kFlux in
// bsdf.h).
#pragma once

#include <cstdint>

#include "kernels/bsdf/bsdf.h"

namespace skywave {

// Turns rows [0, n) of `values`, which `bsdf.evaluate` has written for the same rows, into flux:
// multiplies value by |wo.ns| |wi.ng| / (|wo.ng| |wi.ns|) and, where light is refracted, divides it
// by the squared index ratio. So value is f(light -> eye) |cos| with the geometric cosine of wi
// [1/sr] and the factor of the shading normal at wo: a connection along wi multiplies the
// throughput by it, together with the other end's value and 1 / distance^2. Densities stay.
// Directions are the dir columns of `lights`.
void MakeFlux(const BsdfKernels& bsdf, const SurfaceColumns& surfaces,
              const MaterialView& materials, const LightColumns& lights, std::uint32_t n,
              const BsdfValueColumns& values);

struct NormalColumns {
  float *x, *y, *z;  // world space, unit

  template <class Self, class F>
  static constexpr void ForEachColumn(Self& self, F f) {
    f(self.x), f(self.y), f(self.z);
  }
};

// Writes the shading normals of rows [0, n) as a path sees them that comes from where dir of
// `lights` points: those of `surfaces`, or what BendNormals would have made of them. A light path
// does not know yet who will look at its surfaces. Smooth normals that face away are turned too,
// where a path from there would have the geometric ones.
void FaceNormals(const SurfaceColumns& surfaces, const LightColumns& lights, std::uint32_t n,
                 const NormalColumns& normals);

// Moves the origins of rows [0, n), surfaces that transmit, to the side of the surface that dir of
// `lights` points to (see SurfaceColumns::lift), as evaluate_lights does.
void MoveToSide(const LightColumns& lights, std::uint32_t n, const SurfaceColumns& surfaces);

}  // namespace skywave
