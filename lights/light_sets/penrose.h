// The Penrose tiling (Ostromoukhov et al. 2004; T 6.3) samples a map with a density proportional to
// importance and a blue-noise pattern.
//
// A sample of the tiling with value v at point p is taken when mag * I(p) >= v - xi, with I the
// importance there. Tiles are divided only where the largest importance of their texels can still
// take their samples: a true bound, so that no sun is too small to be found.
#pragma once

#include <cstdint>
#include <vector>

#include "lights/tables/max_pyramid.h"

namespace skywave {

struct PenroseParameters {
  // The seed sets turn, shift and size of the tiling. Other seeds give other patterns of the same
  // quality.
  std::uint64_t seed = 1;
  // xi is in [0, 1). If it is 0, there are no samples where mag * I < 1. If it is uniform over
  // patterns, the mean density is exactly proportional to importance, in dark parts too.
  double xi = 0;
  bool relax = true;  // displace samples by the correction table
};

struct PenroseSample {
  double u, v;          // in [0, 1), displaced; wrapped in u, reflected in v
  std::uint32_t texel;  // of its place before that; its importance took the sample
  std::uint64_t value;  // value of its Fibonacci code
  double importance;    // mag * I of that texel: samples per seed rhombus
};

struct PenroseSet {
  // Ordered by the least mag with which they are taken, so that every prefix is a set.
  std::vector<PenroseSample> samples;
  double mag = 0;
};

// Returns exactly `count` samples: mag starts from its closed form, count * rhombus / integral of I
// (which T 8.4 leaves open), and ends at the count-th smallest of the mags that the samples of a
// slightly larger set need. There are fewer only where the tiling ends (importance beyond 2^60 per
// rhombus), and none for an all-zero importance. Throws InputError for count < 1 or xi outside [0,
// 1).
PenroseSet PenroseSamples(const MaxPyramid& importance, int count,
                          const PenroseParameters& parameters = {});

// Returns all samples at a given mag >= 0; about mag * sum of I / PenroseRhombusArea of them.
PenroseSet PenroseSamplesAtMag(const MaxPyramid& importance, double mag,
                               const PenroseParameters& parameters = {});
// Returns the area [texels] of the seed rhombus for an image.
double PenroseRhombusArea(int width, int height, const PenroseParameters& parameters);

// Returns unit vectors in map space.
std::vector<Vector3> Directions(const PenroseSet& set);

}  // namespace skywave
