#include "lights/strategy_importance.h"

#include <tbb/parallel_for.h>

#include <algorithm>
#include <cmath>
#include <numbers>

namespace skywave {
namespace {

// The function whose shape the density takes, one value a texel: luminance, less its mean over the
// sphere where compensated, times solid angle.
std::vector<double> Importance(const Texels& texels, bool& compensate) {
  const std::uint32_t width = texels.width(), height = texels.height();
  std::vector<double> solid_angle(height);
  double energy = 0;
  for (std::uint32_t row = 0; row < height; ++row) {
    solid_angle[row] = RowSolidAngle(int(width), int(height), int(row));
    for (std::uint32_t column = 0; column < width; ++column) {
      energy += texels.Luminance(column, row) * solid_angle[row];
    }
  }
  std::vector<double> importance(std::size_t(width) * height);
  const auto fill = [&](double subtracted) {
    double total = 0;
    for (std::uint32_t row = 0; row < height; ++row) {
      for (std::uint32_t column = 0; column < width; ++column) {
        const double above = std::max(0.0, texels.Luminance(column, row) - subtracted);
        total += importance[std::size_t(row) * width + column] = above * solid_angle[row];
      }
    }
    return total;
  };
  const double mean = energy / (4 * std::numbers::pi);
  // A map that nowhere rises above its mean (by more than rounding) has nothing to compensate.
  if (compensate && fill(mean) <= 1e-6 * energy) compensate = false;
  if (!compensate) fill(0);
  if (energy <= 0) {
    for (std::uint32_t row = 0; row < height; ++row) {
      std::fill_n(&importance[std::size_t(row) * width], width, solid_angle[row]);
    }
  }
  return importance;
}

RowArea AreaOfRow(std::uint32_t row, std::uint32_t height) {
  const auto square = [](double x) { return x * x; };
  const double top = std::numbers::pi / 2 * row / height;
  const double bottom = std::numbers::pi / 2 * (row + 1) / height;
  const bool north = row < (height + 1) / 2;
  const double start = square(north ? std::sin(top) : std::cos(top));
  const double end = square(north ? std::sin(bottom) : std::cos(bottom));
  return {float(start), float(end - start)};
}

}  // namespace

ImportanceStrategy::ImportanceStrategy(const EnvironmentMap& map, bool compensate)
    : texels_(map),
      compensated_(compensate),
      rows_(texels_.height(), 1),
      columns_(texels_.width(), texels_.height()) {
  const std::uint32_t width = texels_.width(), height = texels_.height();
  const std::uint32_t blocks = columns_.blocks();
  const std::vector<double> importance = Importance(texels_, compensated_);

  std::vector<double> row_weight(height), row_block(rows_.blocks());
  std::vector<std::uint16_t> row_mass(height);
  row_area_.resize(height);
  for (std::uint32_t row = 0; row < height; ++row) {
    const double* begin = &importance[std::size_t(row) * width];
    for (std::uint32_t column = 0; column < width; ++column) row_weight[row] += begin[column];
    row_area_[row] = AreaOfRow(row, height);
  }
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

std::size_t ImportanceStrategy::table_bytes() const {
  return texels_.bytes() + rows_.bytes() + columns_.bytes() + row_area_.size() * sizeof(RowArea) +
         block_density_.size() * sizeof(float);
}

InversionView ImportanceStrategy::Inversion() const {
  return {.rows = rows_.view(),
          .columns = columns_.view(),
          .row_area = row_area_.data(),
          .block_density = block_density_.data(),
          .blocks = columns_.blocks()};
}

void ImportanceStrategy::Sample(const SurfaceColumns&, const UniformColumns& uniforms,
                                std::uint32_t n, const LightColumns& out) const {
  SampleTexels(texels_.view(), Inversion(), uniforms, n, out);
}

void ImportanceStrategy::EvaluateEscaped(const SurfaceColumns&, std::uint32_t n,
                                         const EscapeColumns& rows) const {
  const InversionView inversion = Inversion();
  skywave::EvaluateEscaped(texels_.view(), &inversion, n, rows);
}

}  // namespace skywave
