#include "lights/light_sets/voronoi.h"

#include <tbb/blocked_range2d.h>
#include <tbb/parallel_for.h>

#include <algorithm>
#include <cassert>
#include <cmath>
#include <numbers>

namespace skywave {
namespace {

constexpr int kRootTiles = 16;           // tiles along each side that start from all samples
constexpr std::size_t kLeafTexels = 16;  // or smaller: every candidate is tried at every texel
// Leads of one sample over another below this are left to the comparison at the texel, so that its
// rounding decides, as it does when all samples are tried.
constexpr double kDotSlack = 1e-14;

struct Site {
  Vector3 direction;
  std::uint32_t index;
};

// A cap is a circular part of the sphere.
struct Cap {
  Vector3 centre;
  double sine, cosine;  // sine and cosine of the radius
};

struct Diagram {
  int width, height;
  std::vector<double> row_sine, row_cosine, column_right, column_forward;
  CellMap cells;

  Vector3 TexelCentre(int x, int y) const {
    return {row_sine[y] * column_right[x], row_sine[y] * column_forward[x], row_cosine[y]};
  }
};

// Returns the cap about a tile's middle that holds its texel centres. In a lat-long rectangle less
// than half a turn wide, as all tiles are, the farthest point from the middle is a corner.
Cap CapOf(const Diagram& diagram, const Region& tile) {
  const double u = (tile.x0 + tile.x1) / (2.0 * diagram.width);
  const double v = (tile.y0 + tile.y1) / (2.0 * diagram.height);
  const Vector3 centre = DirectionOfUv(u, v);
  double chord = 0;
  for (int y : {tile.y0, tile.y1 - 1}) {
    for (int x : {tile.x0, tile.x1 - 1}) {
      chord = std::max(chord, Length(centre - diagram.TexelCentre(x, y)));
    }
  }
  const double radius = 2 * std::asin(std::min(chord / 2, 1.0));
  return {centre, std::sin(radius), std::cos(radius)};
}

// Appends to `kept` those of `candidates` that may own a point of the cap: all except those s for
// which the whole cap lies on the side of the centre's owner t, dot(p, t - s) > 0 for all p. That
// is least where p leans from the centre by the radius, straight away from t - s.
void Filter(std::span<const Site> candidates, const Cap& cap, std::vector<Site>& kept) {
  assert(cap.cosine > 0);
  const Site* owner = &candidates[0];
  double best = -2;
  for (const Site& candidate : candidates) {
    const double dot = Dot(candidate.direction, cap.centre);
    if (dot > best) best = dot, owner = &candidate;
  }
  for (const Site& candidate : candidates) {
    const Vector3 apart = owner->direction - candidate.direction;
    const double lead = Dot(apart, cap.centre);
    const double across = std::sqrt(std::max(0.0, Dot(apart, apart) - lead * lead));
    if (lead * cap.cosine - across * cap.sine <= kDotSlack) kept.push_back(candidate);
  }
}

void FillLeaf(Diagram& diagram, const Region& tile, std::span<const Site> candidates) {
  for (int y = tile.y0; y < tile.y1; ++y) {
    for (int x = tile.x0; x < tile.x1; ++x) {
      const Vector3 texel = diagram.TexelCentre(x, y);
      double best = -2;
      std::uint32_t owner = kNoCell;
      for (const Site& candidate : candidates) {
        const double dot = Dot(candidate.direction, texel);
        if (dot > best) best = dot, owner = candidate.index;
      }
      diagram.cells[std::size_t(y) * diagram.width + x] = owner;
    }
  }
}

// `stack` holds the candidates of the tile from `first` on and is left as found.
void FillTile(Diagram& diagram, const Region& tile, std::vector<Site>& stack, std::size_t first) {
  const std::size_t count = stack.size() - first;
  const int columns = tile.x1 - tile.x0, rows = tile.y1 - tile.y0;
  if (count == 1) {
    for (int y = tile.y0; y < tile.y1; ++y) {
      std::fill_n(&diagram.cells[std::size_t(y) * diagram.width + tile.x0], columns,
                  stack[first].index);
    }
    return;
  }
  if (std::size_t(columns) * rows <= kLeafTexels) {
    FillLeaf(diagram, tile, {&stack[first], count});
    return;
  }
  const int middle_x = (tile.x0 + tile.x1) / 2, middle_y = (tile.y0 + tile.y1) / 2;
  for (int part = 0; part < 4; ++part) {
    const Region child = {part & 1 ? middle_x : tile.x0, part & 2 ? middle_y : tile.y0,
                          part & 1 ? tile.x1 : middle_x, part & 2 ? tile.y1 : middle_y};
    if (child.x0 == child.x1 || child.y0 == child.y1) continue;
    const std::size_t begin = stack.size();
    stack.reserve(begin + count);  // Filter reads the stack while it appends
    Filter({&stack[first], count}, CapOf(diagram, child), stack);
    FillTile(diagram, child, stack, begin);
    stack.resize(begin);
  }
}

// Returns samples in the order of their indices, without exact repetitions, which never win.
std::vector<Site> DistinctSamples(std::span<const Vector3> samples) {
  std::vector<Site> distinct(samples.size());
  for (std::size_t i = 0; i < samples.size(); ++i) distinct[i] = {samples[i], std::uint32_t(i)};
  std::sort(distinct.begin(), distinct.end(), [](const Site& a, const Site& b) {
    if (a.direction.x != b.direction.x) return a.direction.x < b.direction.x;
    if (a.direction.y != b.direction.y) return a.direction.y < b.direction.y;
    if (a.direction.z != b.direction.z) return a.direction.z < b.direction.z;
    return a.index < b.index;
  });
  const auto same = [](const Site& a, const Site& b) { return a.direction == b.direction; };
  distinct.erase(std::unique(distinct.begin(), distinct.end(), same), distinct.end());
  std::sort(distinct.begin(), distinct.end(),
            [](const Site& a, const Site& b) { return a.index < b.index; });
  return distinct;
}

}  // namespace

CellMap VoronoiCells(int width, int height, std::span<const Vector3> samples) {
  Diagram diagram = {.width = width, .height = height};
  diagram.cells.assign(std::size_t(width) * height, kNoCell);
  if (samples.empty()) return std::move(diagram.cells);
  for (int y = 0; y < height; ++y) {
    diagram.row_sine.push_back(std::sin(std::numbers::pi / height * (y + 0.5)));
    diagram.row_cosine.push_back(std::cos(std::numbers::pi / height * (y + 0.5)));
  }
  for (int x = 0; x < width; ++x) {
    const double phi = 2 * std::numbers::pi / width * (x + 0.5 - width / 2.0);
    diagram.column_right.push_back(std::sin(phi));
    diagram.column_forward.push_back(std::cos(phi));
  }
  const std::vector<Site> all = DistinctSamples(samples);
  tbb::parallel_for(0, kRootTiles * kRootTiles, [&](int tile_index) {
    const std::int64_t column = tile_index % kRootTiles, row = tile_index / kRootTiles;
    const Region tile = {int(width * column / kRootTiles), int(height * row / kRootTiles),
                         int(width * (column + 1) / kRootTiles),
                         int(height * (row + 1) / kRootTiles)};
    if (tile.x0 == tile.x1 || tile.y0 == tile.y1) return;
    std::vector<Site> stack;
    Filter(all, CapOf(diagram, tile), stack);
    FillTile(diagram, tile, stack, 0);
  });
  return std::move(diagram.cells);
}

std::vector<Vector3> LloydStep(const SphereMap& map, std::span<const Vector3> samples) {
  const std::vector<CellSums> cells =
      SumCells(map, VoronoiCells(map.width, map.height, samples), samples.size());
  std::vector<Vector3> moved(samples.begin(), samples.end());
  for (std::size_t i = 0; i < moved.size(); ++i) {
    moved[i] = NormalizeOr(cells[i].energy_moment, cells[i].energy, moved[i]);
  }
  return moved;
}

LightSet VoronoiLights(const SphereMap& map, std::vector<Vector3> samples, LightPosition position,
                       int lloyd_steps) {
  for (int step = 0; step < lloyd_steps; ++step) samples = LloydStep(map, samples);
  return LightsOfCells(map, VoronoiCells(map.width, map.height, samples), samples, position);
}

}  // namespace skywave
