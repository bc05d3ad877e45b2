#include "lights/light_sets/polyomino.h"

#include <algorithm>
#include <cmath>
#include <numbers>

#include "base/error.h"
#include "lights/light_sets/tromino_tiling.h"
#include "lights/maps/healpix.h"
#include "lights/tables/max_pyramid.h"

namespace skywave {
namespace {

struct PolyominoCandidate {
  TrominoTile parent;
  int rank;
  std::uint64_t value;
  double mag, luminance;  // the least mag with which it is taken
};

Vector3 DirectionAt(const TrominoTile& tile, Complex place) {
  return DirectionOfHealpix(tile.square, place.re, place.im);
}

// The luminance of a map by direction, and its maxima.
class LuminanceBounds {
 public:
  explicit LuminanceBounds(const SphereMap& map)
      : pyramid_(MakeMaxPyramid(map.width, map.height, map.luminance)) {}

  double maximum() const { return pyramid_.maximum(); }

  double At(const Vector3& direction) const {
    double u, v;
    UvOfDirection(direction, u, v);
    return pyramid_.At(std::clamp(int(u * pyramid_.width()), 0, pyramid_.width() - 1),
                       std::clamp(int(v * pyramid_.height()), 0, pyramid_.height() - 1));
  }

  // Returns a bound for directions within `radius` [rad] of `centre`.
  double Within(const Vector3& centre, double radius) const {
    const int width = pyramid_.width(), height = pyramid_.height();
    double u, v;
    UvOfDirection(centre, u, v);
    const double top = v - radius / std::numbers::pi, bottom = v + radius / std::numbers::pi;
    // A texel more than the cap touches is taken, because of rounding.
    Region rows = {0, int(std::floor(top * height)) - 1, width,
                   int(std::floor(bottom * height)) + 2};
    if (top <= 0 || bottom >= 1) return pyramid_.Bound(rows);
    // The meridians that touch the cap are so far from its centre.
    const double half =
        std::asin(std::min(1.0, std::sin(radius) / std::sin(std::numbers::pi * v))) /
        (2 * std::numbers::pi);
    rows.x0 = int(std::floor((u - half) * width)) - 1;
    rows.x1 = int(std::floor((u + half) * width)) + 2;
    double bound = pyramid_.Bound(rows);
    for (const int turn : {-width, width}) {  // what lies beyond the seam
      Region turned = rows;
      turned.x0 += turn, turned.x1 += turn;
      bound = std::max(bound, double(pyramid_.Bound(turned)));
    }
    return bound;
  }

 private:
  MaxPyramid pyramid_;
};

class TrominoCollector {
 public:
  TrominoCollector(const LuminanceBounds& luminance, double mag)
      : luminance_(luminance), mag_(mag) {}

  // Considers all samples that are born below a tile.
  void Visit(const TrominoTile& tile) {
    if (tile.level >= kMaxTrominoLevel) return;
    // Every sample below has a value that is larger by one turn of the tiles at least.
    const double least = double(tile.value) + double(TrominoTiles(tile.level)) + 0.5;
    const double radius = kHealpixStretch * RadiusOf(tile) + 1e-9;
    const double bound = luminance_.Within(DirectionAt(tile, CentreOf(tile)), radius);
    if (!(mag_ * bound >= least)) return;
    const int children = int(DivisionOf(tile).children.size());
    for (int rank = 0; rank < children; ++rank) {
      const TrominoTile child = ChildOf(tile, rank);
      if (rank > 0) Consider(tile, rank, child);
      Visit(child);
    }
  }

  // Considers the sample of `tile`, child `rank` of `parent`, as it lies in the middle of the tile.
  // The sample of a square is its own child 0.
  void Consider(const TrominoTile& parent, int rank, const TrominoTile& tile) {
    const double luminance = luminance_.At(DirectionAt(tile, CentreOf(tile)));
    const double needed = double(tile.value) + 0.5;
    if (!(mag_ * luminance >= needed)) return;
    candidates.push_back({parent, rank, tile.value, needed / luminance, luminance});
  }

  std::vector<PolyominoCandidate> candidates;

 private:
  const LuminanceBounds& luminance_;
  double mag_;
};

std::vector<PolyominoCandidate> CollectPolyominoes(const LuminanceBounds& luminance, double mag,
                                                   std::uint64_t seed) {
  TrominoCollector collector(luminance, mag);
  for (int rank = 0; rank < kHealpixSquares; ++rank) {
    const TrominoTile square = TrominoSquare(seed, rank);
    collector.Consider(square, 0, square);
    collector.Visit(square);
  }
  std::sort(collector.candidates.begin(), collector.candidates.end(),
            [](const PolyominoCandidate& a, const PolyominoCandidate& b) {
              return a.mag != b.mag ? a.mag < b.mag : a.value < b.value;
            });
  return std::move(collector.candidates);
}

}  // namespace

std::vector<PolyominoSample> PolyominoSamples(const SphereMap& map, int count, std::uint64_t seed) {
  if (count < 1) throw InputError({}, "polyomino sampling needs at least one sample");
  if (!(map.energy > 0)) return {};
  const LuminanceBounds luminance(map);
  const double deepest = double(TrominoTiles(kMaxTrominoLevel));
  // A few more than requested are collected: counts differ from the closed form by less than their
  // square root.
  double mag = (count + std::sqrt(double(count)) + 2) * 4 * std::numbers::pi / map.energy;
  std::vector<PolyominoCandidate> candidates = CollectPolyominoes(luminance, mag, seed);
  while (candidates.size() < std::size_t(count) && mag * luminance.maximum() < deepest) {
    mag *= 1.25;
    candidates = CollectPolyominoes(luminance, mag, seed);
  }
  candidates.resize(std::min(candidates.size(), std::size_t(count)));
  std::vector<PolyominoSample> samples;
  for (const PolyominoCandidate& candidate : candidates) {
    const double density = candidates.back().mag * candidate.luminance;
    const Complex place = SampleOf(candidate.parent, candidate.rank, density);
    samples.push_back({DirectionAt(candidate.parent, place), candidate.value, density});
  }
  return samples;
}

std::vector<Vector3> Directions(const std::vector<PolyominoSample>& samples) {
  std::vector<Vector3> directions;
  for (const PolyominoSample& sample : samples) directions.push_back(sample.direction);
  return directions;
}

}  // namespace skywave
