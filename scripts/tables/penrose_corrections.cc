// Recomputes the correction table of lights/light_sets/penrose_corrections.cc and prints it: one
// row per line, 21 vectors "u v". Takes a minute or two.
//
// The method is Lloyd relaxation of the tiling's own patterns (Ostromoukhov et al. 2004; T 6.3.2).
// Each row uses five importances within it. Every round displaces their samples by the row's
// current vectors, moves each sample to the centroid of its Voronoi cell once, and takes as the new
// vector of a class the mean offset from the undisplaced position, in the basis of the tile. There
// is one step of Lloyd per round because with many the table does not settle.

#include <tbb/parallel_for.h>

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <cstdlib>
#include <vector>

#include "lights/light_sets/penrose_corrections.h"

namespace skywave {
namespace {

constexpr int kLevel = 9;
constexpr int kImportancesPerRow = 5;
constexpr double kFixedRim = 2, kIgnoredRim = 5;  // [mean spacings] from the border of the rhombus

struct Sample {
  Complex home, basis;  // undisplaced position; basis at kLevel
  int structural_class;
  double border;  // distance of home from the border of the rhombus
};

struct Pattern {
  double spacing;
  std::vector<Sample> samples;
};

double BorderDistance(Complex p) {
  const Complex corners[4] = {{}, Polar(kPhi, -36), {kPhi * kPhi, 0}, Polar(kPhi, 36)};
  double least = 1e9;
  for (int i = 0; i < 4; ++i) {
    const Complex edge = corners[(i + 1) % 4] - corners[i], to = p - corners[i];
    least = std::min(least, (edge.re * to.im - edge.im * to.re) / kPhi);
  }
  return least;
}

void Collect(const PlacedTile& tile, double importance, std::vector<Sample>& samples) {
  if (tile.type == PenroseTile::kA) {
    if (double(tile.value) > importance) return;
    samples.push_back({tile.origin, BasisAtLevel(tile.axis, tile.level, kLevel),
                       StructuralClass(tile.value, kLevel), BorderDistance(tile.origin)});
    return;
  }
  if (tile.level == kLevel) return;
  std::array<PlacedTile, 4> children;
  const int count = Subdivide(tile, children);
  for (int i = 0; i < count; ++i) Collect(children[i], importance, samples);
}

Pattern MakePattern(double importance) {
  Pattern pattern = {std::sqrt(RhombusArea(1) / importance), {}};
  for (const PlacedTile& tile : SeedRhombus({}, {1, 0})) {
    Collect(tile, importance, pattern.samples);
  }
  return pattern;
}

// Sorts points into the cells of a square grid.
class Grid {
 public:
  Grid(const std::vector<Complex>& points, double side) : points_(points), side_(side) {
    for (Complex p : points) {
      low_ = {std::min(low_.re, p.re), std::min(low_.im, p.im)};
      high_ = {std::max(high_.re, p.re), std::max(high_.im, p.im)};
    }
    columns_ = Cell(high_.re - low_.re) + 1;
    rows_ = Cell(high_.im - low_.im) + 1;
    cells_.resize(std::size_t(columns_) * rows_);
    for (std::size_t i = 0; i < points.size(); ++i) {
      cells_[std::size_t(Cell(points[i].im - low_.im)) * columns_ + Cell(points[i].re - low_.re)]
          .push_back(int(i));
    }
  }

  // Calls visit(point index) for all points within `radius` of p and for some others.
  template <class Visit>
  void Near(Complex p, double radius, const Visit& visit) const {
    const int x0 = std::max(Cell(p.re - radius - low_.re), 0);
    const int x1 = std::min(Cell(p.re + radius - low_.re), columns_ - 1);
    const int y0 = std::max(Cell(p.im - radius - low_.im), 0);
    const int y1 = std::min(Cell(p.im + radius - low_.im), rows_ - 1);
    for (int y = y0; y <= y1; ++y) {
      for (int x = x0; x <= x1; ++x) {
        for (int i : cells_[std::size_t(y) * columns_ + x]) visit(i);
      }
    }
  }

 private:
  int Cell(double length) const { return int(std::floor(length / side_)); }

  const std::vector<Complex>& points_;
  double side_;
  Complex low_ = {1e9, 1e9}, high_ = {-1e9, -1e9};
  int columns_ = 0, rows_ = 0;
  std::vector<std::vector<int>> cells_;
};

using Polygon = std::vector<Complex>;

// Keeps the part of a convex polygon about the origin that is nearer to the origin than to q.
void ClipByBisector(Polygon& polygon, Complex q, Polygon& scratch) {
  const double half = (q.re * q.re + q.im * q.im) / 2;
  const auto beyond = [&](Complex p) { return p.re * q.re + p.im * q.im - half; };
  scratch.clear();
  for (std::size_t i = 0; i < polygon.size(); ++i) {
    const Complex a = polygon[i], b = polygon[(i + 1) % polygon.size()];
    const double at_a = beyond(a), at_b = beyond(b);
    if (at_a <= 0) scratch.push_back(a);
    if ((at_a < 0 && at_b > 0) || (at_a > 0 && at_b < 0)) {
      scratch.push_back(a + (at_a / (at_a - at_b)) * (b - a));
    }
  }
  polygon.swap(scratch);
}

Complex Centroid(const Polygon& polygon) {
  double area = 0;
  Complex sum;
  for (std::size_t i = 0; i < polygon.size(); ++i) {
    const Complex a = polygon[i], b = polygon[(i + 1) % polygon.size()];
    const double cross = a.re * b.im - a.im * b.re;
    area += cross;
    sum = sum + cross * (a + b);
  }
  return (1 / (3 * area)) * sum;
}

// Returns the Voronoi centroid of one point among its neighbours, which have to surround it: cells
// of samples inside the pattern extend at most 2 spacings.
Complex LloydStep(const std::vector<Complex>& points, int index, const Grid& grid, double spacing) {
  const double reach = 2 * spacing;
  const Complex p = points[index];
  Polygon polygon = {{-reach, -reach}, {reach, -reach}, {reach, reach}, {-reach, reach}}, scratch;
  grid.Near(p, 2 * reach, [&](int other) {
    const Complex q = points[other] - p;
    if (other != index && q.re * q.re + q.im * q.im > 1e-24) ClipByBisector(polygon, q, scratch);
  });
  return p + Centroid(polygon);
}

using Row = std::array<Complex, kPenroseClasses>;

struct Mean {
  Complex sum;
  int count = 0;
};

void Relax(const Pattern& pattern, const Row& vectors, std::array<Mean, kPenroseClasses>& means) {
  std::vector<Complex> points;
  for (const Sample& sample : pattern.samples) {
    const bool fixed = sample.border < kFixedRim * pattern.spacing;
    const Complex off = sample.basis * vectors[sample.structural_class];
    points.push_back(fixed ? sample.home : sample.home + off);
  }
  const Grid grid(points, pattern.spacing);
  for (std::size_t i = 0; i < points.size(); ++i) {
    const Sample& sample = pattern.samples[i];
    if (sample.border < kIgnoredRim * pattern.spacing) continue;
    const Complex moved = LloydStep(points, int(i), grid, pattern.spacing) - sample.home;
    const double square = sample.basis.re * sample.basis.re + sample.basis.im * sample.basis.im;
    const Complex conjugate = {sample.basis.re, -sample.basis.im};
    Mean& mean = means[sample.structural_class];
    mean.sum = mean.sum + (1 / square) * (moved * conjugate);
    ++mean.count;
  }
}

Row RelaxedRow(int row, int rounds) {
  std::vector<Pattern> patterns;
  for (int k = 0; k < kImportancesPerRow; ++k) {
    const double t = kLevel + (row + (k + 0.5) / kImportancesPerRow) / kPenroseRows;
    patterns.push_back(MakePattern((std::pow(kPhi * kPhi, t) - 1) / std::sqrt(5.0)));
  }
  Row vectors = {};
  for (int round = 0; round < rounds; ++round) {
    std::array<Mean, kPenroseClasses> means;
    for (const Pattern& pattern : patterns) Relax(pattern, vectors, means);
    for (int c = 0; c < kPenroseClasses; ++c) {
      vectors[c] = means[c].count > 0 ? (1.0 / means[c].count) * means[c].sum : Complex{};
    }
  }
  return vectors;
}

}  // namespace
}  // namespace skywave

int main(int argc, char** argv) {
  using namespace skywave;
  const int rounds = argc > 1 ? std::max(std::atoi(argv[1]), 1) : 60;
  PenroseCorrections table;
  tbb::parallel_for(0, kPenroseRows, [&](int row) { table[row] = RelaxedRow(row, rounds); });
  for (const Row& row : table) {
    for (Complex v : row) std::printf("%.6f %.6f  ", v.re, v.im);
    std::printf("\n");
  }
  return 0;
}
