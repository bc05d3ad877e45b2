#include "lights/tables/cells.h"

#include <tbb/parallel_for.h>

#include <algorithm>

#include "lights/maps/projections.h"

namespace skywave {
namespace {

// Adds the texels of one row from x0 to x1, which have one cell.
void AddRun(const SphereMap& map, int y, int x0, int x1, CellSums& sums) {
  double rgb[3] = {}, luminance = 0, right = 0, forward = 0, area_right = 0, area_forward = 0;
  const float* pixel = map.image->Pixel(x0, y);
  const float* row = &map.luminance[std::size_t(y) * map.width];
  for (int x = x0; x < x1; ++x, pixel += 3) {
    for (int c = 0; c < 3; ++c) rgb[c] += pixel[c];
    luminance += row[x];
    right += row[x] * map.column_right[x];
    forward += row[x] * map.column_forward[x];
    area_right += map.column_right[x];
    area_forward += map.column_forward[x];
  }
  const double area = map.solid_angle[y], horizontal = map.horizontal_integral[y];
  const double up = map.up_integral[y];
  for (int c = 0; c < 3; ++c) sums.irradiance[c] += rgb[c] * area;
  sums.energy += luminance * area;
  sums.energy_moment += {right * horizontal, forward * horizontal, luminance * up};
  sums.solid_angle += (x1 - x0) * area;
  sums.area_moment += {area_right * horizontal, area_forward * horizontal, (x1 - x0) * up};
}

void Add(const CellSums& part, CellSums& sums) {
  for (int c = 0; c < 3; ++c) sums.irradiance[c] += part.irradiance[c];
  sums.energy += part.energy;
  sums.energy_moment += part.energy_moment;
  sums.solid_angle += part.solid_angle;
  sums.area_moment += part.area_moment;
}

Vector3 PositionOf(const CellSums& cell, const Vector3& sample, LightPosition position) {
  if (position == LightPosition::kSample) return sample;
  const Vector3 centre = NormalizeOr(cell.area_moment, cell.solid_angle, sample);
  if (position == LightPosition::kCentre) return centre;
  return NormalizeOr(cell.energy_moment, cell.energy, centre);
}

// Returns the position of a direction on a Hilbert curve (1891) over the equal-area square of the
// sphere.
std::uint32_t HilbertIndex(const Vector3& direction) {
  constexpr std::uint32_t kSide = 1u << 15;
  const ImagePoint point = PointOfDirection(Projection::kOctahedral, direction);
  auto x = std::min(std::uint32_t(point.u * kSide), kSide - 1);
  auto y = std::min(std::uint32_t(point.v * kSide), kSide - 1);
  std::uint32_t index = 0;
  for (std::uint32_t half = kSide / 2; half > 0; half /= 2) {
    const bool right = (x & half) != 0, below = (y & half) != 0;
    // The quadrants follow a U; the outer two are its mirror images about a diagonal.
    index = 4 * index + (below ? (right ? 2 : 1) : (right ? 3 : 0));
    x &= half - 1, y &= half - 1;
    if (below) continue;
    if (right) x = half - 1 - x, y = half - 1 - y;
    std::swap(x, y);
  }
  return index;
}

}  // namespace

std::vector<CellSums> SumCells(const SphereMap& map, const CellMap& cell_of_texel,
                               std::size_t cells) {
  const int bands = std::clamp(map.height / 32, 1, 16);
  std::vector<std::vector<CellSums>> parts(bands);
  tbb::parallel_for(0, bands, [&](int band) {
    std::vector<CellSums>& sums = parts[band];
    sums.resize(cells);
    const int begin = int(std::int64_t(map.height) * band / bands);
    const int end = int(std::int64_t(map.height) * (band + 1) / bands);
    for (int y = begin; y < end; ++y) {
      const std::uint32_t* row = &cell_of_texel[std::size_t(y) * map.width];
      for (int x = 0; x < map.width;) {
        const int first = x;
        while (x < map.width && row[x] == row[first]) ++x;
        if (row[first] != kNoCell) AddRun(map, y, first, x, sums[row[first]]);
      }
    }
  });
  for (int band = 1; band < bands; ++band) {
    for (std::size_t i = 0; i < cells; ++i) Add(parts[band][i], parts[0][i]);
  }
  return std::move(parts[0]);
}

LightSet LightsOfCells(const SphereMap& map, CellMap cell_of_texel,
                       std::span<const Vector3> samples, LightPosition position) {
  const std::vector<CellSums> cells = SumCells(map, cell_of_texel, samples.size());
  struct Placed {
    std::uint32_t curve, cell;
    Vector3 direction;
  };
  std::vector<Placed> order;
  for (std::uint32_t i = 0; i < cells.size(); ++i) {
    if (!(cells[i].energy > 0)) continue;
    const Vector3 direction = PositionOf(cells[i], samples[i], position);
    order.push_back({HilbertIndex(direction), i, direction});
  }
  std::stable_sort(order.begin(), order.end(),
                   [](const Placed& a, const Placed& b) { return a.curve < b.curve; });
  LightSet set;
  std::vector<std::uint32_t> light_of_cell(cells.size(), kNoCell);
  for (const auto& [curve, i, direction] : order) {
    light_of_cell[i] = std::uint32_t(set.lights.size());
    set.lights.push_back({.direction = direction,
                          .irradiance = cells[i].irradiance,
                          .energy = cells[i].energy,
                          .solid_angle = cells[i].solid_angle});
  }
  for (std::uint32_t& cell : cell_of_texel) {
    if (cell != kNoCell) cell = light_of_cell[cell];
  }
  set.cell_of_texel = std::move(cell_of_texel);
  return set;
}

CellMap CellsOfRegions(int width, int height, std::span<const Region> regions) {
  CellMap cells(std::size_t(width) * height, kNoCell);
  for (std::size_t i = 0; i < regions.size(); ++i) {
    for (int y = regions[i].y0; y < regions[i].y1; ++y) {
      std::fill_n(&cells[std::size_t(y) * width + regions[i].x0], regions[i].x1 - regions[i].x0,
                  std::uint32_t(i));
    }
  }
  return cells;
}

std::vector<Vector3> RegionCentres(int width, int height, std::span<const Region> regions) {
  std::vector<Vector3> centres;
  for (const Region& r : regions) {
    centres.push_back(DirectionOfUv((r.x0 + r.x1) / (2.0 * width), (r.y0 + r.y1) / (2.0 * height)));
  }
  return centres;
}

LightSet LightsOfRegions(const SphereMap& map, std::span<const Region> regions,
                         LightPosition position) {
  return LightsOfCells(map, CellsOfRegions(map.width, map.height, regions),
                       RegionCentres(map.width, map.height, regions), position);
}

}  // namespace skywave
