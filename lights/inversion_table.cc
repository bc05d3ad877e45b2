#include "lights/inversion_table.h"

#include <tbb/parallel_for.h>

#include <algorithm>
#include <cmath>
#include <numbers>
#include <numeric>

#include "lights/environment_map.h"

namespace skywave {
namespace {

// Luminance above `base` over the sphere; rows in parallel, their sums in order, whatever the
// threads.
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

}  // namespace

float BaseLuminance(const Texels& texels, double& compensate) {
  const double energy = EnergyAbove(texels, 0);
  if (energy <= 0) {
    compensate = 0;
    return -1;
  }
  if (compensate <= 0) return 0;
  const double base = compensate * energy / (4 * std::numbers::pi);
  if (EnergyAbove(texels, base) > 1e-6 * energy) return float(base);
  compensate = 0;  // all that rises above the mean is rounding
  return 0;
}

InversionTable::InversionTable(const Texels& texels, float base)
    : texels_(&texels),
      base_(base / texels.unit()),
      rows_(texels.height(), 1),
      blocks_(texels.stride() / kBlockTexels, texels.height()) {
  const std::uint32_t width = texels.width(), height = texels.height();
  const std::uint32_t blocks = blocks_.items();
  const auto solid_angle = [&](std::uint32_t row) {
    return RowSolidAngle(int(width), int(height), int(row));
  };
  std::vector<double> weight(std::size_t(height) * blocks), row_weight(height);
  tbb::parallel_for(0u, height, [&](std::uint32_t row) {
    double* const of_block = &weight[std::size_t(row) * blocks];
    for (std::uint32_t column = 0; column < width; ++column) {
      // The kernel's own rounding: a texel weighs nothing here if it weighs nothing there.
      of_block[column / kBlockTexels] +=
          std::max(0.0f, texels.Luminance(column, row) / texels.unit() - base_);
    }
    row_weight[row] = std::accumulate(of_block, of_block + blocks, 0.0) * solid_angle(row);
  });
  std::vector<double> row_node(rows_.leaves());
  std::vector<std::uint16_t> row_mass(height);
  rows_.Set(0, row_weight.data(), row_mass.data(), row_node.data());

  const double whole = std::pow(kNodeMass, rows_.view().levels + blocks_.view().levels);
  row_density_.resize(height);
  block_density_.resize(weight.size());
  tbb::parallel_for(0u, height, [&](std::uint32_t row) {
    std::vector<std::uint16_t> mass(blocks);
    std::vector<double> node(blocks_.leaves());
    const std::size_t first = std::size_t(row) * blocks;
    row_density_[row] = float(1 / (solid_angle(row) * whole));
    blocks_.Set(row, &weight[first], mass.data(), node.data());
    const double row_density = row_node[row / kNodeFan] * row_mass[row] / solid_angle(row);
    for (std::uint32_t b = 0; b < blocks; ++b) {
      const double probability = node[b / kNodeFan] * mass[b];
      if (weight[first + b] > 0) {
        block_density_[first + b] = float(row_density * probability / weight[first + b]);
      }
    }
  });
}

InversionView InversionTable::view() const {
  return {.rows = rows_.view(),
          .blocks = blocks_.view(),
          .packed = texels_->view().packed,
          .base = base_,
          .block_density = block_density_.data(),
          .row_density = row_density_.data()};
}

}  // namespace skywave
