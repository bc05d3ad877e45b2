// Directional lights as light samples.
#pragma once

#include <cstdint>

#include "kernels/lights/environment.h"

namespace skywave {

// Eight floats, read by gathers.
struct LightRecord {
  float direction[3];   // towards the light, world space, unit
  float irradiance[3];  // on a surface that faces it [radiance * sr]
  float probability;    // of being picked
  float unused;
};
static_assert(sizeof(LightRecord) == 8 * sizeof(float));

// The same light for rows [0, n): a whole wave of shadow rays of one direction.
void FillDirectional(const LightRecord& light, std::uint32_t n, const LightColumns& out);

// A light for each of rows [0, n), picked by one tree over all of them at uniforms u; its
// irradiance is divided by its probability and by `samples`, the picks of a surface.
void PickDirectional(const LightRecord* lights, const SearchTreeView& tree, const float* u,
                     std::uint32_t n, float samples, const LightColumns& out);

// Lights of A or samples of B: rows whose uniform u lies below `share` take a light, picked at
// u / share and worth 1 / share of it; the others keep what `out` holds, a sample of B drawn as one
// of samples * (1 - share). `rest` receives (u - share) / (1 - share), which is the uniform to draw
// B's samples with beforehand.
void SplitUniforms(const float* u, std::uint32_t n, float share, float* rest);
void PickOverSplit(const LightRecord* lights, const SearchTreeView& tree, const float* u,
                   std::uint32_t n, float share, float samples, const LightColumns& out);

}  // namespace skywave
