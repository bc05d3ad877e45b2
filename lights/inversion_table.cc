#include "lights/inversion_table.h"

#include <tbb/parallel_for.h>

#include <numeric>

#include "lights/environment_map.h"

namespace skywave {

InversionTable::InversionTable(std::uint32_t width, std::uint32_t height,
                               const std::vector<double>& importance)
    : rows_(height, 1), columns_(width, height) {
  const std::uint32_t blocks = columns_.blocks();
  std::vector<double> row_weight(height), row_block(rows_.blocks());
  std::vector<std::uint16_t> row_mass(height);
  tbb::parallel_for(0u, height, [&](std::uint32_t row) {
    const auto begin = importance.begin() + std::ptrdiff_t(std::size_t(row) * width);
    row_weight[row] = std::accumulate(begin, begin + width, 0.0);
  });
  rows_.Set(0, row_weight.data(), row_mass.data(), row_block.data());

  block_density_.resize(std::size_t(height) * blocks);
  tbb::parallel_for(0u, height, [&](std::uint32_t row) {
    std::vector<std::uint16_t> mass(width);
    std::vector<double> block(blocks);
    columns_.Set(row, &importance[std::size_t(row) * width], mass.data(), block.data());
    const double row_density = row_block[row / kNodeFan] * row_mass[row] /
                               RowSolidAngle(int(width), int(height), int(row));
    for (std::uint32_t b = 0; b < blocks; ++b) {
      block_density_[std::size_t(row) * blocks + b] = float(row_density * block[b]);
    }
  });
}

InversionView InversionTable::view() const {
  return {.rows = rows_.view(),
          .columns = columns_.view(),
          .block_density = block_density_.data(),
          .blocks = columns_.blocks()};
}

}  // namespace skywave
