// These kernels make light samples of directional lights.
#pragma once

#include <cstdint>

#include "kernels/lights/environment.h"

namespace skywave {

// A record is eight floats, read by gathers.
struct LightRecord {
  float direction[3];   // towards the light, world space, unit
  float irradiance[3];  // on a surface that faces it [radiance * sr]
  float probability;    // chance of being picked
  float unused;
};
static_assert(sizeof(LightRecord) == 8 * sizeof(float));

// Writes the same light to rows [0, n), so that a whole wave of shadow rays has one direction.
void FillDirectional(const LightRecord& light, std::uint32_t n, const LightColumns& out);

// Picks a light for each of rows [0, n) by one tree over all of them at uniforms u; its irradiance
// is divided by its probability and by `samples`, the number of picks per surface.
void PickDirectional(const LightRecord* lights, const SearchTreeView& tree, const float* u,
                     std::uint32_t n, float samples, const LightColumns& out);

// Mixes lights with samples of another technique. SplitUniforms writes the uniforms of those
// samples to `rest`: (u - share) / (1 - share). They are drawn as some of samples * (1 - share).
// PickOverSplit then puts a light into the rows whose uniform u lies below `share`, picked at u /
// share and weighted by 1 / share; the other rows keep what `out` holds.
void SplitUniforms(const float* u, std::uint32_t n, float share, float* rest);
void PickOverSplit(const LightRecord* lights, const SearchTreeView& tree, const float* u,
                   std::uint32_t n, float share, float samples, const LightColumns& out);

}  // namespace skywave
