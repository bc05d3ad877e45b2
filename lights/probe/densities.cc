#include "lights/probe/densities.h"

#include <algorithm>

namespace skywave {
namespace {

TexelDensity1D DensityOf(const std::vector<double>& energy) {
  double total = 0;
  for (const double e : energy) total += e;
  TexelDensity1D result = {std::vector<double>(energy.size()), std::vector<double>(energy.size())};
  if (!(total > 0)) return result;
  double sum = 0;
  for (std::size_t i = 0; i < energy.size(); ++i) {
    sum += energy[i];
    result.density[i] = energy[i] / total * double(energy.size());
    result.cumulative[i] = sum / total;
  }
  return result;
}

}  // namespace

TexelDensity1D ColumnDensity(const SphereMap& map) {
  std::vector<double> energy(std::size_t(map.width));
  for (int y = 0; y < map.height; ++y) {
    for (int x = 0; x < map.width; ++x) energy[std::size_t(x)] += map.Energy(x, y);
  }
  return DensityOf(energy);
}

TexelDensity1D RowDensity(const SphereMap& map, int column) {
  std::vector<double> energy(std::size_t(map.height));
  for (int y = 0; y < map.height; ++y) energy[std::size_t(y)] = map.Energy(column, y);
  return DensityOf(energy);
}

Image JointDensity(const SphereMap& map) {
  const double largest = *std::max_element(map.solid_angle.begin(), map.solid_angle.end());
  Image density = *map.image;
  const std::size_t row = 3 * std::size_t(map.width);
  for (std::size_t i = 0; i < density.rgb.size(); ++i) {
    density.rgb[i] *= float(map.solid_angle[i / row] / largest);
  }
  return density;
}

int BrightestColumn(const SphereMap& map) {
  int best = 0;
  double most = -1;
  for (int y = 0; y < map.height; ++y) {
    for (int x = 0; x < map.width; ++x) {
      if (map.Energy(x, y) > most) most = map.Energy(x, y), best = x;
    }
  }
  return best;
}

}  // namespace skywave
