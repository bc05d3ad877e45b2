// Samples of a map by a tiling of polyominoes (Ostromoukhov 2007), with a density proportional to
// radiance and a blue-noise pattern.
//
// The tiling (tromino_tiling.h) fills the squares of HEALPix (lights/maps/healpix.h), so tiles of a
// level have one solid angle everywhere: there is no pole at which they narrow. A sample of value v
// at the direction w is taken where mag * L(w) >= v + 1/2, with L the luminance of the texel there.
// Tiles are divided only where the largest luminance near them can still take their samples: a true
// bound, so that no sun is too small to be found.
#pragma once

#include <cstdint>
#include <vector>

#include "lights/maps/sphere_map.h"

namespace skywave {

struct PolyominoSample {
  Vector3 direction;    // unit, map space
  std::uint64_t value;  // from 0 up
  double density;       // samples a sphere where it was taken
};

// Returns exactly `count` samples, ordered by the least mag with which they are taken, so that
// every prefix is a smaller set: the mag starts from its closed form, count * 4 pi / energy, and
// ends at the count-th smallest of the mags that the samples of a slightly larger set need. There
// are fewer only where the tiling ends (radiance beyond 2^60 / count times the mean), and none for
// a black map. Other seeds give other patterns of the same quality. Throws InputError for count <
// 1.
std::vector<PolyominoSample> PolyominoSamples(const SphereMap& map, int count,
                                              std::uint64_t seed = 1);

std::vector<Vector3> Directions(const std::vector<PolyominoSample>& samples);

}  // namespace skywave
