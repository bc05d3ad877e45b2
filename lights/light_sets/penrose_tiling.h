// The modified Penrose tiling of Ostromoukhov, Donohue and Jodoin 2004, "Fast Hierarchical
// Importance Sampling with Blue Noise Properties" (T 6.3): exact geometry and Fibonacci codes.
//
// Triangles c, d (sides 1, phi, phi) and e, f (sides phi^2, phi, phi) divide into triangles smaller
// by phi and, now and then, a sampling tile a: a point. A point is born with a value, from 1 up;
// the larger the value the deeper the level. At level n the values of the points in one seed
// rhombus are 1 .. F(2n + 2) - 1, each once. Points never move, so all with value <= x are an even
// pattern of density x per rhombus.
#pragma once

#include <array>
#include <cmath>
#include <cstdint>
#include <numbers>
#include <span>

namespace skywave {

inline constexpr double kPhi = std::numbers::phi;
// Values are exact in 64 bits up to this level.
inline constexpr int kMaxPenroseLevel = 44;

// A point or vector of the plane as a complex number.
struct Complex {
  double re = 0, im = 0;
};
inline Complex operator+(Complex a, Complex b) { return {a.re + b.re, a.im + b.im}; }
inline Complex operator-(Complex a, Complex b) { return {a.re - b.re, a.im - b.im}; }
inline Complex operator*(Complex a, Complex b) {
  return {a.re * b.re - a.im * b.im, a.re * b.im + a.im * b.re};
}
inline Complex operator*(double s, Complex a) { return {s * a.re, s * a.im}; }
Complex Polar(double radius, double degrees);

// F(1) = F(2) = 1; F(0) .. F(2 * kMaxPenroseLevel + 2).
std::uint64_t Fibonacci(int n);

// kA, kB: sampling tiles; a turns into b and b into a, half a turn about, with every level.
enum class PenroseTile : std::uint8_t { kA, kB, kC, kD, kE, kF };

struct PlacedTile {
  PenroseTile type;
  Complex origin;       // corner P1
  Complex axis;         // length of the unit side, direction of P1 P2
  std::uint64_t value;  // of the Fibonacci code so far
  int level;
};

// Corners P1, P2, P3 of a triangle, counter-clockwise.
std::array<Complex, 3> Corners(const PlacedTile& triangle);

// Children of a tile, one level on: 1 for a sampling tile, up to 4 for a triangle. Returns their
// number.
int Subdivide(const PlacedTile& tile, std::array<PlacedTile, 4>& children);

// The seed: triangles f and e that share their long side and make a rhombus of side phi * |axis|,
// long diagonal along `axis` from `origin`. Level 0, value 0.
std::array<PlacedTile, 2> SeedRhombus(Complex origin, Complex axis);
double RhombusArea(double unit_side);

// The level down to which importance x needs the tiling divided: the smallest n with
// F(2n + 2) - 1 >= floor(x), x >= 0.
int LevelOfImportance(double x);
// log of 1 + sqrt5 x to base phi^2: its ceiling less 1 is the level, the fraction above it, in
// (0, 1], the phase.
double LevelAndPhase(double x);

// Class 0 .. 20 of a sample at `level`: value of the leading six digits of its code of 2 level
// digits. level >= the sample's own.
int StructuralClass(std::uint64_t value, int level);

// Level at which the sample of this value is born, value >= 1.
int BirthLevel(std::uint64_t value);

// The basis in which a sample of birth level m, born with axis `axis` [length phi^-m units], stands
// at level n >= m.
Complex BasisAtLevel(Complex axis, int birth, int level);

}  // namespace skywave
