#include "lights/strategy_importance.h"

#include <tbb/parallel_for.h>

#include <algorithm>
#include <numbers>
#include <numeric>

namespace skywave {

std::vector<double> TexelImportance(const Texels& texels, double& compensate) {
  const std::uint32_t width = texels.width(), height = texels.height();
  std::vector<double> importance(std::size_t(width) * height);
  // Luminance above `subtracted` times solid angle, and its sum; rows in parallel, their sums in
  // order, whatever the threads.
  const auto fill = [&](double subtracted) {
    std::vector<double> sums(height);
    tbb::parallel_for(0u, height, [&](std::uint32_t row) {
      const double solid_angle = RowSolidAngle(int(width), int(height), int(row));
      double* texel = &importance[std::size_t(row) * width];
      double sum = 0;
      for (std::uint32_t column = 0; column < width; ++column, ++texel) {
        sum += * texel = std::max(0.0, texels.Luminance(column, row) - subtracted) * solid_angle;
      }
      sums[row] = sum;
    });
    return std::accumulate(sums.begin(), sums.end(), 0.0);
  };
  const double energy = fill(0);
  const double mean = energy / (4 * std::numbers::pi);
  const double wanted = compensate;
  // A map that nowhere rises above its mean (by more than rounding) has nothing to compensate.
  if (compensate > 0 && fill(compensate * mean) <= 1e-6 * energy) compensate = 0;
  if (compensate == 0 && wanted > 0) fill(0);
  if (energy <= 0) {
    for (std::uint32_t row = 0; row < height; ++row) {
      std::fill_n(&importance[std::size_t(row) * width], width,
                  RowSolidAngle(int(width), int(height), int(row)));
    }
  }
  return importance;
}

ImportanceStrategy::ImportanceStrategy(const EnvironmentMap& map, double compensate)
    : texels_(map),
      compensated_(compensate),
      table_(texels_.width(), texels_.height(), TexelImportance(texels_, compensated_)) {}

ImportanceStrategy::ImportanceStrategy(const EnvironmentMap& map,
                                       const std::vector<double>& importance)
    : texels_(map), compensated_(0), table_(texels_.width(), texels_.height(), importance) {}

void ImportanceStrategy::Sample(const ShadePoints&, const UniformColumns& uniforms, std::uint32_t n,
                                LightCall call, const LightColumns& out) const {
  SampleTexels(texels_.view(), table_.view(), uniforms, n, call.samples(), out);
}

void ImportanceStrategy::EvaluateEscaped(const ShadePoints&, std::uint32_t n, float samples,
                                         const EscapeColumns& rows) const {
  const InversionView inversion = table_.view();
  skywave::EvaluateEscaped(texels_.view(), {.inversion = &inversion}, n, samples, rows);
}

}  // namespace skywave
