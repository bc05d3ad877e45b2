#include "lights/light_sets/variance_cut.h"

#include <algorithm>
#include <array>
#include <limits>
#include <optional>
#include <queue>
#include <utility>

#include "base/error.h"

namespace skywave {
namespace {

using Moments = std::array<double, 4>;

struct BestCut {
  double variance = std::numeric_limits<double>::infinity();
  Region first, second;
};

// Tries every cut of `region` across one side.
void TryCuts(const SummedAreaTable<4>& table, const Region& region, bool across_width, double noise,
             BestCut& best) {
  const Moments whole = table.Sum(region);
  const int begin = across_width ? region.x0 : region.y0;
  const int end = across_width ? region.x1 : region.y1;
  for (int at = begin + 1; at < end; ++at) {
    Region first = region, second = region;
    (across_width ? first.x1 : first.y1) = at;
    (across_width ? second.x0 : second.y0) = at;
    const Moments a = table.Sum(first);
    const Moments b = {whole[0] - a[0], whole[1] - a[1], whole[2] - a[2], whole[3] - a[3]};
    if (!(a[0] > noise && b[0] > noise)) continue;
    const double variance = SphericalVariance(a) + SphericalVariance(b);
    if (variance < best.variance) best = {variance, first, second};
  }
}

}  // namespace

double SphericalVariance(const std::array<double, 4>& m) {
  if (!(m[0] > 0)) return 0;
  return std::max(0.0, m[0] - (m[1] * m[1] + m[2] * m[2] + m[3] * m[3]) / m[0]);
}

std::vector<Region> VarianceCut(const SphereMap& map, int count) {
  if (count < 1) throw InputError({}, "variance cut needs at least one light");
  if (!(map.energy > 0)) return {};
  const SummedAreaTable<4> table = MomentTable(map);
  std::vector<Region> regions = {{0, 0, map.width, map.height}};
  const Moments whole = table.Sum(regions[0]);
  const double noise = kSumNoise * whole[0];

  std::priority_queue<std::pair<double, std::size_t>> by_variance;  // variance, index of region
  by_variance.push({SphericalVariance(whole), 0});
  while (regions.size() < std::size_t(count) && !by_variance.empty()) {
    const std::size_t i = by_variance.top().second;
    by_variance.pop();
    BestCut best;
    TryCuts(table, regions[i], true, noise, best);
    TryCuts(table, regions[i], false, noise, best);
    if (best.first == best.second) continue;  // no cut leaves energy on both sides
    regions[i] = best.first;
    regions.push_back(best.second);
    by_variance.push({SphericalVariance(table.Sum(best.first)), i});
    by_variance.push({SphericalVariance(table.Sum(best.second)), regions.size() - 1});
  }
  return regions;
}

}  // namespace skywave
