// The irradiance of an illumination map on surfaces from which nothing hides it, which is known
// exactly and serves as a control variate for diffuse light.
//
// For a tabulated normal t, the vector irradiance is the integral of L(w) w over the directions w
// with t . w > kHorizonSine. Its product with a normal n near t is the irradiance from there,
// exactly for every n, because the cosine is linear in n. The horizon is so high that all of these
// directions are above the surface that n belongs to. What lies below it, and what is hidden, is
// left to samples. Normals along an axis of the map, such as that of a level ground, have an entry
// of their own whose horizon is the surface itself, so nothing is left where nothing hides the map.
// (Szecsi et al. 2004; Rousselle, Jarosz and Novak 2016)
#pragma once

#include <algorithm>
#include <cstdint>

#include "kernels/lights/places.h"

namespace skywave {

// Normals are tabulated at the nodes of a grid over the octahedral square, which lie on its border
// too: the axes are nodes.
inline constexpr std::uint32_t kIrradianceNodes = 65;
// A normal is nearer to its node than the angle with this sine: half a cell is h = 1 / 64, at most
// sqrt(6) h long on the octahedron, which is 1 / sqrt(3) away from the centre.
inline constexpr float kHorizonSine = 0.0663f;

// The axes right, -right, forward, -forward, up, -up follow the nodes. Normals belong to one if the
// other two coordinates add up to less.
inline constexpr std::uint32_t kIrradianceAxes = 6;
inline constexpr float kOnAxis = 1e-6f;

// The vector irradiance of a node: nine floats, [channel][right, forward, up].
inline constexpr std::uint32_t kIrradianceWords = 9;

struct IrradianceView {
  const float* nodes;       // kIrradianceWords per node, row by row [scene radiance * sr]
  float map_from_world[9];  // as in EnvironmentView
};

// One row is what is subtracted from the radiance of the path of a surface or ray, whatever the
// shadow ray or the ray meets: the control at a sample, less its integral.
struct ControlColumns {
  float *r, *g, *b;  // [scene radiance]

  template <class Self, class F>
  static constexpr void ForEachColumn(Self& self, F f) {
    f(self.r), f(self.g), f(self.b);
  }
};
inline void ClearControls(const ControlColumns& control, std::uint32_t n) {
  for (float* column : {control.r, control.g, control.b}) std::fill_n(column, n, 0.0f);
}

// Where much of the map is hidden, a part of the control leaves less to samples than all of it.
struct ControlWeightView {
  PlaceTreeView places;
  const float* weight;  // of each place, 0 to 1
};

// One row = one surface.
struct ControlWeightColumns {
  float* weight;

  template <class Self, class F>
  static constexpr void ForEachColumn(Self& self, F f) {
    f(self.weight);
  }
};

// Writes the weight of the control at surfaces [0, n).
void FindControlWeights(const ControlWeightView& weights, std::uint32_t n,
                        const SurfaceColumns& surfaces, const ControlWeightColumns& out);

}  // namespace skywave
