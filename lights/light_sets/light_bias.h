// The bias of directional lights that stand for a map: the error of the light that arrives where
// something hides half of the map.
//
// Lights of cells have nearly the irradiance of the map where nothing hides it, because each has
// the centroid of its cell. What shows is the shadow: a cell across an edge of what hides the map
// is seen as a whole or not at all. So the model is a matt surface of any normal n beside a wall of
// any normal m through the same point: it receives the integral of L(w) max(w . n, 0) over the
// directions with w . m > 0. The bias is the root mean square of the difference between lights and
// map, over all n and m, relative to the mean of the map's, which is an eighth of its energy.
#pragma once

#include <array>
#include <span>
#include <vector>

#include "lights/maps/sphere_map.h"
#include "lights/tables/cells.h"

namespace skywave {

class LightBias {
 public:
  // Sums over blocks of texels, or parts of texels, of about a degree, each in the direction of its
  // energy's centroid, for pairs of normals of a Halton sequence. Runs in parallel; the result does
  // not depend on the threads. The map must have energy.
  explicit LightBias(const SphereMap& map);

  // Returns the bias of lights, 0 if they are like the map.
  double Of(std::span<const DirectionalLight> lights) const;

 private:
  struct Pair {
    Vector3 normal, wall;
    double irradiance = 0;
  };
  std::vector<Pair> pairs_;
  double mean_;
};

}  // namespace skywave
