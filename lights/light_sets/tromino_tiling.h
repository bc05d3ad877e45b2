// L-trominoes, three unit squares about a corner, divide squares again and again (after
// Ostromoukhov 2007, "Sampling with Polyominoes").
//
// There are twelve squares, those of HEALPix. Twelve trominoes fill a square, each of them is
// filled by nine of a third of its size, and so on. A square has 162 such divisions and a tromino
// has four; a tile takes one of them by a hash of its path, so the tiling repeats itself nowhere.
// Every tile holds one sample. Its child of rank 0 inherits that sample, and the others bear new
// ones, in the order of their ranks: every prefix of the ranks covers the tile evenly.
//
// Values count the samples. A sample that is born at level n as the child of rank r has the value
// of its parent plus r times the number of tiles at level n - 1. So the samples with values below
// the number of tiles of a level are those of its tiles, each once, and in between the next rank
// goes round the tiles in the very order in which these were born. As samples of value v are taken
// where the density is v + 1/2 or more, one number places as many as are wanted everywhere.
//
// The paper has G-hexominoes with 81 children, and offsets of the samples from a table of local
// neighbourhoods that an optimisation over large patterns has made. Here nothing is tabulated
// beforehand: ranks, and the places of the first m samples of a tile, follow from its division
// alone, and are found when the program first asks for them.
#pragma once

#include <cstddef>
#include <cstdint>
#include <vector>

#include "lights/light_sets/complex.h"

namespace skywave {

// A square, or a tromino inside it. In a tromino's coordinates its outer corner is 0, and its three
// squares have side 1 and lie at (0, 0), (1, 0) and (0, 1). A square's own side is 2.
struct TrominoTile {
  // The point z of its coordinates lies at origin + axis * z, inside the unit square `square`.
  int square = 0;
  Complex origin, axis;
  std::uint64_t value = 0;  // of its sample
  std::uint64_t path = 0;   // hash of the way here from its square
  int level = 0;            // squares are at level 0
};

// A division of the square or of a tromino, in the coordinates of the parent.
struct TrominoDivision {
  struct Child {
    Complex origin, axis;
  };
  std::vector<Child> children;                // by rank
  std::vector<std::vector<Complex>> samples;  // [m - 1][rank]: places of the first m samples
};

inline constexpr int kMaxTrominoLevel = 18;  // values are below 2^62

// Returns the tile that is a whole square; other seeds give other tilings. `rank` from 0 to 11
// counts the squares such that the first few of them lie far apart.
TrominoTile TrominoSquare(std::uint64_t seed, int rank);
// Returns the number of tiles at a level.
std::uint64_t TrominoTiles(int level);
const TrominoDivision& DivisionOf(const TrominoTile& tile);
TrominoTile ChildOf(const TrominoTile& parent, int rank);

// Returns the centre of gravity of a tile and the distance from there to its farthest point.
Complex CentreOf(const TrominoTile& tile);
double RadiusOf(const TrominoTile& tile);

// Returns the place, in the square of the tile, of the sample of child `rank` of `parent` where the
// density is `density` samples a sphere: that among the first m samples of the smallest tile that
// holds as many of them. Rank 0 of a square is the square's own sample.
Complex SampleOf(const TrominoTile& parent, int rank, double density);

// Returns the number of divisions of a square or of a tromino, and one of them. A division is
// worked out when it is first asked for; any number of threads may ask.
std::size_t DivisionCount(bool of_square);
const TrominoDivision& Division(bool of_square, std::size_t index);

}  // namespace skywave
