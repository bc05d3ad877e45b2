// Voronoi cells of directions over a lat-long map (T 7.1) give every texel its nearest sample.
#pragma once

#include <span>
#include <vector>

#include "lights/tables/cells.h"

namespace skywave {

// Returns for every texel the index of the sample with the largest dot product with the direction
// of the texel's centre, the lowest index where several are equal: exactly what trying all samples
// gives. `samples` are unit vectors in map space, any number, however placed (duplicates, coplanar,
// one alone); without any, every texel is kNoCell.
//
// Tiles of texels are divided down to those of one cell, carrying only the samples that can win
// somewhere in the tile; the work grows with the length of the cell borders, not with the number of
// cells times the texels. Runs in parallel; the result does not depend on the threads.
CellMap VoronoiCells(int width, int height, std::span<const Vector3> samples);

// Moves every sample to the energy centroid of its Voronoi cell; samples whose cell has no energy
// stay.
std::vector<Vector3> LloydStep(const SphereMap& map, std::span<const Vector3> samples);

// Makes the Voronoi cells of samples (unit vectors) and their lights; before that, `lloyd_steps`
// times, the samples make a step of Lloyd (Kollig and Keller 2003). Samples whose
// cell has no energy are dropped, so there can be fewer lights than samples.
LightSet VoronoiLights(const SphereMap& map, std::vector<Vector3> samples, LightPosition position,
                       int lloyd_steps = 0);

}  // namespace skywave
