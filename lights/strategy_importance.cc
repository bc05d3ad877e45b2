#include "lights/strategy_importance.h"

#include <algorithm>
#include <cmath>
#include <numbers>

namespace skywave {

std::vector<double> TexelImportance(const Texels& texels, double& compensate) {
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
  if (compensate > 0 && fill(compensate * mean) <= 1e-6 * energy) compensate = 0;
  if (compensate == 0) fill(0);
  if (energy <= 0) {
    for (std::uint32_t row = 0; row < height; ++row) {
      std::fill_n(&importance[std::size_t(row) * width], width, solid_angle[row]);
    }
  }
  return importance;
}

ImportanceStrategy::ImportanceStrategy(const EnvironmentMap& map, double compensate)
    : texels_(map),
      compensated_(compensate),
      table_(texels_.width(), texels_.height(), TexelImportance(texels_, compensated_)) {}

void ImportanceStrategy::Sample(const ShadePoints&, const UniformColumns& uniforms, std::uint32_t n,
                                LightCall call, const LightColumns& out) const {
  SampleTexels(texels_.view(), table_.view(), uniforms, n, float(call.requested), out);
}

void ImportanceStrategy::EvaluateEscaped(const ShadePoints&, std::uint32_t n,
                                         std::uint32_t requested, const EscapeColumns& rows) const {
  const InversionView inversion = table_.view();
  skywave::EvaluateEscaped(texels_.view(), {.inversion = &inversion}, n, float(requested), rows);
}

}  // namespace skywave
