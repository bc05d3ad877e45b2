// Samples of a map that Lloyd's relaxation (1982) places: every sample moves to the energy centroid
// of its Voronoi cell until none moves. The methods differ in where samples start.
#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include "lights/maps/sphere_map.h"

namespace skywave {

// k-means over the texels, weighted by their energy, as LightGen has it (Cohen and Debevec 2001):
// starts from `count` texels drawn by energy, none twice. Other seeds start elsewhere, and end in
// other local minima. There are fewer samples only if fewer texels have energy. Throws InputError
// for count < 1.
std::vector<Vector3> KMeansSamples(const SphereMap& map, int count, std::uint64_t seed = 1);

// The same, but starts from the samples of another map, such as that of the frame before: where the
// light moves a little they move with it, and lights of an animation do not jump (after Ghosh,
// Doucet and Heidrich 2006). There are as many as before where as many texels have energy: a sample
// that is left in the dark starts anew, where the others are farthest from the light.
std::vector<Vector3> FollowingSamples(const SphereMap& map, std::span<const Vector3> before);

// After Kollig and Keller 2003: starts from one sample and adds others in the cells of most energy,
// relaxing between. Theirs adds one at a time; here a round divides up to half as many cells as
// there are samples. A new sample stands where energy times square of the distance is largest, so a
// cell whose energy is one texel's is not divided. There are fewer samples only if no cell can be
// divided. Throws InputError for count < 1.
std::vector<Vector3> KolligKellerSamples(const SphereMap& map, int count);

}  // namespace skywave
