// Virtual point lights are the vertices of light paths (Keller 1997): every sample of the picture
// has a set of its own, which lights all of its pixels.
#pragma once

#include <array>
#include <cstdint>
#include <vector>

#include "kernels/columns.h"
#include "wavefront/soa.h"

namespace skywave {

// Options of virtual point lights.
struct VirtualLightOptions {
  std::uint32_t count = 64;  // of each sample, on average
  // Lights that are nearer than this shine as from there [world space]; negative: chosen by the
  // lights.
  float distance = -1;
};

// More lights would need more numbers for the rays of a surface than there are (kLightPathPairs).
inline constexpr std::uint32_t kMostVirtualLights = 1u << 14;

// A surface with a density that a light path has hit.
struct VirtualLight {
  // Its row of SurfaceColumns, in the order of the columns; the throughput is flux.
  std::array<std::uint32_t, soa::CountColumns<SurfaceColumns>()> words;
  float position[3];
  std::uint32_t kind;   // of BSDF
  std::uint32_t depth;  // surfaces that the light path has hit, this one included
  std::uint32_t path;   // row of the light path in its wave, while they are traced
};

struct VirtualLights {
  std::vector<VirtualLight> lights;  // in the order (light path, surface)
  // Their flux is still to be divided by this.
  std::uint64_t light_paths = 0;
  float distance = 0;  // nearer lights shine as from here
};

// Writes the light to rows [0, n) of `rows`, and up to the end of the last vector.
void RepeatVirtualLight(const VirtualLight& light, std::uint32_t n, const SurfaceColumns& rows);

}  // namespace skywave
