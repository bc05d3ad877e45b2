// Sample directions are clustered by pairwise nearest neighbours (T 7.4.3; Velho, Gomes and
// Sobreiro 1997, "Color Image Quantization by Pairwise Clustering"), which takes redundant lights
// out of a set: Penrose samples pile up in the few texels of a sun.
#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include "lights/tables/cells.h"

namespace skywave {

// The frequency F of a sample has one of three definitions (T 7.4.3.1-7.4.3.3).
enum class ClusterFrequency {
  kOne,            // F1: where samples lie, whatever their light
  kEnergy,         // F2: energy of the sample's cell
  kMeanLuminance,  // F3: energy over solid angle of its cell
};
std::vector<double> Frequencies(std::span<const CellSums> cells, ClusterFrequency frequency);

// Merging stops when both conditions are satisfied; with none given, nothing is merged.
struct ClusterStop {
  int clusters = 0;       // this many are left; 0: any number
  double separation = 0;  // all pairs are at least this far apart [rad] (T 7.22); 0: any distance
};

struct Clustering {
  std::vector<Vector3> directions;  // unit
  std::vector<double> frequencies;  // sum over the members
  std::vector<std::uint32_t> cluster_of_sample;
};

// Repeatedly merges the pair with the least E = Fi Fj / (Fi + Fj) angle(ci, cj)^2 into (Fi ci + Fj
// cj) / (Fi + Fj), put back on the sphere. Note that the pair of least E need not be the nearest
// one. Time is O(n^2) for most sets: a second for 10 000 samples. The caller has to compute cells
// anew. Throws InputError for a negative stop or a frequency that is negative or not finite.
// Clusters are ordered by their lowest sample.
Clustering ClusterPairwise(std::span<const Vector3> samples, std::span<const double> frequencies,
                           const ClusterStop& stop);

}  // namespace skywave
