#include "lights/light_sets/median_cut.h"

#include <algorithm>
#include <cmath>
#include <numbers>
#include <optional>
#include <queue>
#include <utility>

#include "base/error.h"

namespace skywave {
namespace {

using Halves = std::pair<Region, Region>;

Halves CutAt(const Region& r, bool across_width, int at) {
  Halves halves = {r, r};
  (across_width ? halves.first.x1 : halves.first.y1) = at;
  (across_width ? halves.second.x0 : halves.second.y0) = at;
  return halves;
}

class Cutter {
 public:
  Cutter(const SphereMap& map, const MedianCutParameters& parameters)
      : map_(map),
        parameters_(parameters),
        table_(EnergyTable(map)),
        noise_(kSumNoise * Energy({0, 0, map.width, map.height})) {}

  double Energy(const Region& r) const { return table_.Sum(r)[0]; }

  std::optional<Halves> Cut(const Region& r) const {
    const bool across_width = WidthIsLonger(r);
    std::optional<Halves> halves = CutAcross(r, across_width);
    return halves ? halves : CutAcross(r, !across_width);
  }

 private:
  bool WidthIsLonger(const Region& r) const {
    double width = 2.0 * (r.x1 - r.x0) / map_.width;
    if (parameters_.scale_width) {
      width *= std::sin(std::numbers::pi * (r.y0 + r.y1) / (2.0 * map_.height));
    }
    return width > double(r.y1 - r.y0) / map_.height;
  }

  std::optional<Halves> CutAcross(const Region& r, bool across_width) const {
    const int first = across_width ? r.x0 : r.y0, last = across_width ? r.x1 : r.y1;
    if (last - first < 2) return std::nullopt;
    const double energy = Energy(r);
    const auto before = [&](int at) { return Energy(CutAt(r, across_width, at).first); };
    int low = first + 1, high = last - 1;  // the first cut with half the energy before it, or last
    while (low < high) {
      const int middle = (low + high) / 2;
      if (before(middle) >= energy / 2) {
        high = middle;
      } else {
        low = middle + 1;
      }
    }
    int at = low;
    if (at > first + 1 &&
        std::abs(before(at - 1) - energy / 2) < std::abs(before(at) - energy / 2)) {
      --at;
    }
    const double half = before(at);
    if (!(half > noise_ && energy - half > noise_)) return std::nullopt;
    return CutAt(r, across_width, at);
  }

  const SphereMap& map_;
  MedianCutParameters parameters_;
  SummedAreaTable<1> table_;
  double noise_;
};

}  // namespace

std::vector<Region> MedianCut(const SphereMap& map, int count,
                              const MedianCutParameters& parameters) {
  if (count < 1) throw InputError({}, "median cut needs at least one light");
  if (!(map.energy > 0)) return {};
  const Cutter cutter(map, parameters);
  std::vector<Region> regions = {{0, 0, map.width, map.height}};
  for (bool progress = true; progress && regions.size() * 2 <= std::size_t(count);) {
    std::vector<Region> next;
    for (const Region& region : regions) {
      if (const auto halves = cutter.Cut(region)) {
        next.push_back(halves->first);
        next.push_back(halves->second);
      } else {
        next.push_back(region);
      }
    }
    progress = next.size() > regions.size();
    regions = std::move(next);
  }

  std::priority_queue<std::pair<double, std::size_t>> by_energy;  // energy, index of region
  for (std::size_t i = 0; i < regions.size(); ++i) by_energy.push({cutter.Energy(regions[i]), i});
  while (regions.size() < std::size_t(count) && !by_energy.empty()) {
    const std::size_t i = by_energy.top().second;
    by_energy.pop();
    const auto halves = cutter.Cut(regions[i]);
    if (!halves) continue;
    regions[i] = halves->first;
    regions.push_back(halves->second);
    by_energy.push({cutter.Energy(halves->first), i});
    by_energy.push({cutter.Energy(halves->second), regions.size() - 1});
  }
  return regions;
}

}  // namespace skywave
