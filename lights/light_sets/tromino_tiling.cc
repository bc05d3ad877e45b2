#include "lights/light_sets/tromino_tiling.h"

#include <algorithm>
#include <array>
#include <cassert>
#include <cmath>
#include <limits>
#include <mutex>
#include <span>

#include "lights/maps/healpix.h"

namespace skywave {
namespace {

constexpr int kFiner = 3;          // children have squares of a third of the side
constexpr int kGrid = 2 * kFiner;  // squares of children along the box of a parent
constexpr int kSquareChildren = 12, kTrominoChildren = 9;

struct Square {
  int x, y;  // lower left corner
};
constexpr Square kTromino[] = {{0, 0}, {1, 0}, {0, 1}};
constexpr Square kBlock[] = {{0, 0}, {1, 0}, {0, 1}, {1, 1}};
constexpr Complex kCentre = {5.0 / 6, 5.0 / 6};

// A tromino among the squares of children: its outer corner, and how many quarters it is turned.
struct Placed {
  int x, y, turn;
};

constexpr std::array<Square, 4> kQuarters = {{{1, 0}, {0, 1}, {-1, 0}, {0, -1}}};

Complex AxisOf(const Placed& tile) {
  return {double(kQuarters[tile.turn].x), double(kQuarters[tile.turn].y)};
}

Square SquareOf(const Placed& tile, const Square& square) {
  const Complex middle = AxisOf(tile) * Complex{square.x + 0.5, square.y + 0.5};
  return {tile.x + int(std::floor(middle.re)), tile.y + int(std::floor(middle.im))};
}

using Cover = std::array<std::array<bool, kGrid>, kGrid>;  // [y][x]: is covered or outside

bool Fits(const Cover& cover, const Placed& tile) {
  return std::all_of(std::begin(kTromino), std::end(kTromino), [&](const Square& square) {
    const Square at = SquareOf(tile, square);
    return at.x >= 0 && at.x < kGrid && at.y >= 0 && at.y < kGrid && !cover[at.y][at.x];
  });
}

void Mark(Cover& cover, const Placed& tile, bool covered) {
  for (const Square& square : kTromino) {
    const Square at = SquareOf(tile, square);
    cover[at.y][at.x] = covered;
  }
}

// Finds all ways to cover what is left, always the first square in the order of rows.
void FindCovers(Cover& cover, std::vector<Placed>& placed, std::vector<std::vector<Placed>>& all) {
  int first = 0;
  while (first < kGrid * kGrid && cover[first / kGrid][first % kGrid]) ++first;
  if (first == kGrid * kGrid) return all.push_back(placed);
  for (int turn = 0; turn < 4; ++turn) {
    for (const Square& square : kTromino) {
      const Square at = SquareOf({0, 0, turn}, square);
      const Placed tile = {first % kGrid - at.x, first / kGrid - at.y, turn};
      if (!Fits(cover, tile)) continue;
      Mark(cover, tile, true);
      placed.push_back(tile);
      FindCovers(cover, placed, all);
      placed.pop_back();
      Mark(cover, tile, false);
    }
  }
}

double DistanceSquare(Complex a, Complex b) {
  const Complex apart = a - b;
  return apart.re * apart.re + apart.im * apart.im;
}

std::size_t Nearest(std::span<const Complex> sites, Complex point) {
  std::size_t nearest = 0;
  for (std::size_t i = 1; i < sites.size(); ++i) {
    if (DistanceSquare(sites[i], point) < DistanceSquare(sites[nearest], point)) nearest = i;
  }
  return nearest;
}

// Returns the sum of the squares of the distances from points to their nearest sites.
double Spread(std::span<const Complex> sites, std::span<const Complex> points) {
  double sum = 0;
  for (const Complex point : points) sum += DistanceSquare(sites[Nearest(sites, point)], point);
  return sum;
}

// Moves sites towards the centres of the points that are nearest to them (Lloyd 1982).
void Relax(std::span<const Complex> points, std::vector<Complex>& sites) {
  constexpr int kSteps = 20;
  std::vector<Complex> sum(sites.size());
  std::vector<int> count(sites.size());
  for (int step = 0; step < kSteps; ++step) {
    std::fill(sum.begin(), sum.end(), Complex{});
    std::fill(count.begin(), count.end(), 0);
    for (const Complex point : points) {
      const std::size_t nearest = Nearest(sites, point);
      sum[nearest] = sum[nearest] + point;
      ++count[nearest];
    }
    for (std::size_t i = 0; i < sites.size(); ++i) {
      if (count[i] > 0) sites[i] = (1.0 / count[i]) * sum[i];
    }
  }
}

// Gives the children their ranks: greedily the one next that leaves points the least spread.
TrominoDivision Rank(const std::vector<Placed>& placed, std::span<const Complex> points) {
  std::vector<TrominoDivision::Child> left;
  for (const Placed& tile : placed) {
    left.push_back(
        {(1.0 / kFiner) * Complex{double(tile.x), double(tile.y)}, (1.0 / kFiner) * AxisOf(tile)});
  }
  const auto centre = [](const TrominoDivision::Child& child) {
    return child.origin + child.axis * kCentre;
  };
  TrominoDivision division;
  std::vector<Complex> centres;
  while (!left.empty()) {
    std::size_t best = 0;
    double least = std::numeric_limits<double>::infinity();
    for (std::size_t i = 0; i < left.size(); ++i) {
      centres.push_back(centre(left[i]));
      const double spread = Spread(centres, points);
      centres.pop_back();
      if (spread < least) least = spread, best = i;
    }
    centres.push_back(centre(left[best]));
    division.children.push_back(left[best]);
    left.erase(left.begin() + std::ptrdiff_t(best));
    division.samples.push_back(centres);
    // A tile that is full has its samples in the middle of its children, as those have at first.
    if (!left.empty()) Relax(points, division.samples.back());
  }
  return division;
}

// All divisions of a shape.
class Divisions {
 public:
  explicit Divisions(std::span<const Square> parent) {
    Cover cover;
    for (auto& row : cover) row.fill(true);
    for (const Square& square : parent) AddSquare(square, cover);
    std::vector<Placed> placed;
    FindCovers(cover, placed, covers_);
    ranked_.resize(covers_.size());
    once_ = std::vector<std::once_flag>(covers_.size());
  }

  std::size_t size() const { return covers_.size(); }

  const TrominoDivision& operator[](std::size_t index) {
    std::call_once(once_[index], [&] { ranked_[index] = Rank(covers_[index], points_); });
    return ranked_[index];
  }

 private:
  void AddSquare(const Square& square, Cover& cover) {
    for (int y = 0; y < kFiner; ++y) {
      for (int x = 0; x < kFiner; ++x) {
        cover[square.y * kFiner + y][square.x * kFiner + x] = false;
      }
    }
    constexpr int kAcross = 3 * kFiner;
    for (int y = 0; y < kAcross; ++y) {
      for (int x = 0; x < kAcross; ++x) {
        points_.push_back({square.x + (x + 0.5) / kAcross, square.y + (y + 0.5) / kAcross});
      }
    }
  }

  std::vector<Complex> points_;  // all over the shape
  std::vector<std::vector<Placed>> covers_;
  std::vector<TrominoDivision> ranked_;
  std::vector<std::once_flag> once_;
};

Divisions& DivisionsOf(bool of_square) {
  static Divisions squares(kBlock), trominoes(kTromino);
  return of_square ? squares : trominoes;
}

// Mixes bits well (Steele, Lea and Flood 2014, SplitMix).
std::uint64_t Mix(std::uint64_t z) {
  z += 0x9E3779B97F4A7C15u;
  z = (z ^ z >> 30) * 0xBF58476D1CE4E5B9u;
  z = (z ^ z >> 27) * 0x94D049BB133111EBu;
  return z ^ z >> 31;
}

}  // namespace

std::size_t DivisionCount(bool of_square) { return DivisionsOf(of_square).size(); }

const TrominoDivision& Division(bool of_square, std::size_t index) {
  return DivisionsOf(of_square)[index];
}

TrominoTile TrominoSquare(std::uint64_t seed, int rank) {
  // The first four are a tetrahedron, the next four those along the equator.
  constexpr int kSquares[kHealpixSquares] = {0, 9, 2, 11, 4, 6, 5, 7, 1, 10, 3, 8};
  return {.square = kSquares[rank],
          .origin = {0, 0},
          .axis = {0.5, 0},
          .value = std::uint64_t(rank),
          .path = Mix(Mix(seed) + std::uint64_t(rank)),
          .level = 0};
}

std::uint64_t TrominoTiles(int level) {
  assert(level >= 0 && level <= kMaxTrominoLevel);
  std::uint64_t tiles = kHealpixSquares;
  for (int n = 0; n < level; ++n) tiles *= n == 0 ? kSquareChildren : kTrominoChildren;
  return tiles;
}

const TrominoDivision& DivisionOf(const TrominoTile& tile) {
  const bool square = tile.level == 0;
  return Division(square, tile.path % DivisionCount(square));
}

TrominoTile ChildOf(const TrominoTile& parent, int rank) {
  const TrominoDivision::Child& child = DivisionOf(parent).children[std::size_t(rank)];
  return {.square = parent.square,
          .origin = parent.origin + parent.axis * child.origin,
          .axis = parent.axis * child.axis,
          .value = parent.value + std::uint64_t(rank) * TrominoTiles(parent.level),
          .path = Mix(parent.path + std::uint64_t(rank)),
          .level = parent.level + 1};
}

Complex CentreOf(const TrominoTile& tile) {
  return tile.origin + tile.axis * (tile.level == 0 ? Complex{1, 1} : kCentre);
}

double RadiusOf(const TrominoTile& tile) {
  // The farthest points of a tromino are the ends of its arms, (2, 0) and (0, 2).
  const double radius =
      tile.level == 0 ? std::sqrt(2.0) : std::sqrt(DistanceSquare(kCentre, Complex{2, 0}));
  return radius * std::sqrt(DistanceSquare(tile.axis, {}));
}

Complex SampleOf(const TrominoTile& parent, int rank, double density) {
  TrominoTile tile = parent;
  while (tile.level < kMaxTrominoLevel && double(TrominoTiles(tile.level + 1)) - 0.5 <= density) {
    tile = ChildOf(tile, rank);
    rank = 0;
  }
  const TrominoDivision& division = DivisionOf(tile);
  const double tiles = double(TrominoTiles(tile.level));
  const double more = (density - 0.5 - double(tile.value)) / tiles;
  const auto most = int(division.samples.size());
  const int count = std::clamp(int(std::floor(more)) + 1, rank + 1, most);
  return tile.origin + tile.axis * division.samples[std::size_t(count - 1)][std::size_t(rank)];
}

}  // namespace skywave
