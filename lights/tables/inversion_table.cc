#include "lights/tables/inversion_table.h"

#include <tbb/parallel_for.h>

#include <algorithm>
#include <numbers>
#include <numeric>

#include "lights/maps/environment_map.h"

namespace skywave {
namespace {

// Returns the luminance above `base` over the sphere; rows are summed in parallel and added in
// order, whatever the threads.
double EnergyAbove(const Texels& texels, double base) {
  const std::uint32_t width = texels.width(), height = texels.height();
  std::vector<double> sums(height);
  tbb::parallel_for(0u, height, [&](std::uint32_t row) {
    double sum = 0;
    for (std::uint32_t column = 0; column < width; ++column) {
      sum += std::max(0.0, texels.Luminance(column, row) - base);
    }
    sums[row] = sum * RowSolidAngle(int(width), int(height), int(row));
  });
  return std::accumulate(sums.begin(), sums.end(), 0.0);
}

// What rises above the mean by less than this share of the energy may be rounding: a texel holds
// nine bits, and one that takes up what its neighbours have lost is a unit too bright.
constexpr double kRounding = 0x1p-8;

}  // namespace

float BaseLuminance(const Texels& texels, double& compensate) {
  const double energy = EnergyAbove(texels, 0);
  if (energy <= 0) {
    compensate = 0;
    return -1;
  }
  if (compensate <= 0) return 0;
  const double base = compensate * energy / (4 * std::numbers::pi);
  if (EnergyAbove(texels, base) > kRounding * energy) return float(base);
  compensate = 0;
  return 0;
}

InversionTable::InversionTable(Texels& texels, float base)
    : texels_(&texels),
      base_(base / texels.unit()),
      rows_(texels.height(), 1),
      lines_(texels.lines_per_row(), texels.height()) {
  const std::uint32_t width = texels.width(), height = texels.height();
  const std::uint32_t lines = lines_.items();
  const auto solid_angle = [&](std::uint32_t row) {
    return RowSolidAngle(int(width), int(height), int(row));
  };
  std::vector<double> weight(std::size_t(height) * lines), row_weight(height);
  tbb::parallel_for(0u, height, [&](std::uint32_t row) {
    const std::size_t first = std::size_t(row) * lines;
    for (std::uint32_t line = 0; line < lines; ++line) {
      double half[2] = {};
      const std::uint32_t begin = line * kLineTexels, end = std::min(begin + kLineTexels, width);
      for (std::uint32_t column = begin; column < end; ++column) {
        // This rounds as the kernel does: a texel weighs nothing here if it weighs nothing there.
        half[(column - begin) / (kLineTexels / 2)] +=
            std::max(0.0f, texels.Luminance(column, row) / texels.unit() - base_);
      }
      weight[first + line] = half[0] + half[1];
      texels.lines()[first + line].left =
          half[1] > 0 ? float(half[0] / weight[first + line]) : 1.0f;
      row_weight[row] += weight[first + line];
    }
    row_weight[row] *= solid_angle(row);
  });
  std::vector<double> row_node(rows_.leaves());
  std::vector<std::uint16_t> row_mass(height);
  rows_.Set(0, row_weight.data(), row_mass.data(), row_node.data());

  tbb::parallel_for(0u, height, [&](std::uint32_t row) {
    std::vector<std::uint16_t> mass(lines);
    std::vector<double> node(lines_.leaves());
    const std::size_t first = std::size_t(row) * lines;
    lines_.Set(row, &weight[first], mass.data(), node.data());
    const double row_density = row_node[row / kNodeFan] * row_mass[row] / solid_angle(row);
    for (std::uint32_t line = 0; line < lines; ++line) {
      const double probability = node[line / kNodeFan] * mass[line];
      if (weight[first + line] > 0) {
        texels.lines()[first + line].density =
            float(row_density * probability / weight[first + line]);
      }
    }
  });
}

InversionView InversionTable::view() const {
  return {.rows = rows_.view(),
          .lines = lines_.view(),
          .texels = texels_->view().texels,
          .base = base_};
}

}  // namespace skywave
