// Samples of a map that Lloyd's relaxation (1982) places: every sample moves to the energy centroid
// of its Voronoi cell until none moves. The methods differ in where samples start.
#pragma once

#include <cstdint>
#include <vector>

#include "lights/maps/sphere_map.h"

namespace skywave {

// k-means over the texels, weighted by their energy, as LightGen has it (Cohen and Debevec 2001):
// starts from `count` texels drawn by energy, none twice. Other seeds start elsewhere, and end in
// other local minima. There are fewer samples only if fewer texels have energy. Throws InputError
// for count < 1.
std::vector<Vector3> KMeansSamples(const SphereMap& map, int count, std::uint64_t seed = 1);

// After Kollig and Keller 2003: starts from one sample and adds others in the cells of most energy,
// relaxing between. Theirs adds one at a time; here a round divides up to half as many cells as
// there are samples. A new sample stands where energy times square of the distance is largest, so a
// cell whose energy is one texel's is not divided. There are fewer samples only if no cell can be
// divided. Throws InputError for count < 1.
std::vector<Vector3> KolligKellerSamples(const SphereMap& map, int count);

}  // namespace skywave
