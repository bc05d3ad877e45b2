// A map has two strata (T 7.4.1, 7.4.2): A, bright and small, and B, the rest.
//
// Texels are sorted by luminance, descending (equal ones from the top left). A is a prefix of that
// order; the three functions differ in where it ends.
#pragma once

#include <cstdint>
#include <vector>

#include "lights/maps/sphere_map.h"

namespace skywave {

struct Strata {
  std::vector<std::uint8_t> in_a;  // per texel: 1 in A, 0 in B
  double p = 0;                    // energy of A over energy of the map
  float threshold = 0;             // luminance of the dimmest texel of A; infinity if A is empty
  std::size_t texels_a = 0, texels_b = 0;
  double solid_angle_a = 0, solid_angle_b = 0;  // [sr]
  double energy_a = 0, energy_b = 0;            // [luminance * sr]
};

// Makes A the shortest prefix with the fraction p of the energy (T 7.2-7.4). A black map has an
// empty A. Throws InputError for p outside [0, 1].
Strata StrataByFraction(const SphereMap& map, double p);

// Makes A the shortest prefix with room for `lights` caps of angle `separation` [rad] from rim to
// rim (T 7.15, 7.16), at most the whole map. Throws InputError for lights < 0 or a separation
// outside [0, 2 pi].
Strata StrataByLights(const SphereMap& map, int lights, double separation);

// Ends A where the sorted luminance f(x), x the spherical area, is best described by two trapezia:
// the smallest x that minimises zeta(x) = (f(0) + f(x)) / 2 x + (f(x) + f(psi)) / 2 (psi - x) (T
// 7.17-7.21). A map of one luminance has an empty A. `zeta_minimum`, if given, gets the minimum,
// with x in pixels as in T table 7.1.
Strata StrataByVariation(const SphereMap& map, double* zeta_minimum = nullptr);

// A prefix of the sorted texels, by the functions of its area x that the last division is about (T
// figures 7.9 to 7.17).
struct StratumPrefix {
  double area = 0;       // x [sr]
  double luminance = 0;  // f(x), of its dimmest texel
  double energy = 0;     // g(x), the integral of f up to x [luminance * sr]
  double zeta = 0;       // zeta(x) [luminance * sr]
};
// Returns at most `most` prefixes from the first texel to all of them, evenly along the logarithm
// of their number of texels.
std::vector<StratumPrefix> PrefixesOf(const SphereMap& map, std::size_t most);

// A request names one of the three divisions and its parameters.
struct StrataRequest {
  enum class Kind { kVariation, kFraction, kLights } kind = Kind::kVariation;
  double fraction = 0.5;  // kFraction: p in [0, 1]
  int lights = 64;        // kLights
  double separation = 0;  // kLights [rad]
};
Strata DivideMap(const SphereMap& map, const StrataRequest& request);

// Returns the map with the other stratum black. A plus B is the map.
Image StratumImage(const SphereMap& map, const Strata& strata, bool a);

}  // namespace skywave
