// This is the modified Penrose tiling of Ostromoukhov, Donohue and Jodoin 2004, "Fast Hierarchical
// Importance Sampling with Blue Noise Properties" (T 6.3), with exact geometry and Fibonacci codes.
//
// Triangles c, d (sides 1, phi, phi) and e, f (sides phi^2, phi, phi) divide into triangles smaller
// by phi and, now and then, a sampling tile a: a point. A point is born with a value, from 1 up;
// the larger the value the deeper the level. At level n the values of the points in one seed
// rhombus are 1 .. F(2n + 2) - 1, each once. Points never move, so all with value <= x are a
// uniform pattern of density x per rhombus.
#pragma once

#include <array>
#include <cmath>
#include <cstdint>
#include <numbers>
#include <span>

#include "lights/light_sets/complex.h"

namespace skywave {

inline constexpr double kPhi = std::numbers::phi;
// Values are exact in 64 bits up to this level.
inline constexpr int kMaxPenroseLevel = 44;

Complex Polar(double radius, double degrees);

// Returns F(n), with F(1) = F(2) = 1, for n from 0 to 2 * kMaxPenroseLevel + 2.
std::uint64_t Fibonacci(int n);

// kA and kB are sampling tiles: with every level a turns into b and b into a, half a turn about.
enum class PenroseTile : std::uint8_t { kA, kB, kC, kD, kE, kF };

struct PlacedTile {
  PenroseTile type;
  Complex origin;       // corner P1
  Complex axis;         // length of the unit side, direction of P1 P2
  std::uint64_t value;  // value of the Fibonacci code so far
  int level;
};

// Returns corners P1, P2, P3 of a triangle, counter-clockwise.
std::array<Complex, 3> Corners(const PlacedTile& triangle);

// Writes the children of a tile, one level on: 1 for a sampling tile, up to 4 for a triangle.
// Returns their number.
int Subdivide(const PlacedTile& tile, std::array<PlacedTile, 4>& children);

// Returns the seed: triangles f and e that share their long side and make a rhombus of side phi *
// |axis|, long diagonal along `axis` from `origin`, at level 0 and with value 0.
std::array<PlacedTile, 2> SeedRhombus(Complex origin, Complex axis);
double RhombusArea(double unit_side);

// Returns the level down to which importance x >= 0 needs the tiling divided: the smallest n with
// F(2n + 2) - 1 >= floor(x).
int LevelOfImportance(double x);
// Returns the logarithm of 1 + sqrt5 x to base phi^2: its ceiling less 1 is the level, the fraction
// above it, in (0, 1], the phase.
double LevelAndPhase(double x);

// Returns the class 0 .. 20 of a sample at `level`: the value of the leading six digits of its code
// of 2 level digits. `level` is at least the sample's own.
int StructuralClass(std::uint64_t value, int level);

// Returns the level at which the sample of this value is born, value >= 1.
int BirthLevel(std::uint64_t value);

// Returns the basis in which a sample of birth level m, born with axis `axis` [length phi^-m
// units], stands at level n >= m.
Complex BasisAtLevel(Complex axis, int birth, int level);

}  // namespace skywave
