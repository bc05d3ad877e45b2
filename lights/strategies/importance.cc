#include "lights/strategies/importance.h"

#include <fmt/format.h>
#include <tbb/parallel_for.h>

#include <algorithm>
#include <utility>

namespace skywave {

std::vector<double> TexelImportance(const Texels& texels) {
  const std::uint32_t width = texels.width(), height = texels.height();
  double compensate = 0;
  const double base = BaseLuminance(texels, compensate);
  std::vector<double> importance(std::size_t(width) * height);
  tbb::parallel_for(0u, height, [&](std::uint32_t row) {
    const double solid_angle = RowSolidAngle(int(width), int(height), int(row));
    double* texel = &importance[std::size_t(row) * width];
    for (std::uint32_t column = 0; column < width; ++column, ++texel) {
      *texel = (texels.Luminance(column, row) - base) * solid_angle;
    }
  });
  return importance;
}

namespace {

// Returns grey texels of the luminance that makes them as important.
Image Weights(const EnvironmentMap& map, const std::vector<double>& importance) {
  Image weights(map.latlong.width, map.latlong.height);
  for (int y = 0; y < weights.height; ++y) {
    const double solid_angle = RowSolidAngle(weights.width, weights.height, y);
    for (int x = 0; x < weights.width; ++x) {
      const std::size_t i = std::size_t(y) * std::size_t(weights.width) + std::size_t(x);
      std::fill_n(weights.Pixel(x, y), 3, float(importance[i] / solid_angle));
    }
  }
  return weights;
}

}  // namespace

ImportanceStrategy::ImportanceStrategy(const EnvironmentMap& map, double compensate)
    : texels_(map),
      compensated_(compensate),
      table_(texels_, BaseLuminance(texels_, compensated_)) {}

ImportanceStrategy::ImportanceStrategy(const EnvironmentMap& map,
                                       const std::vector<double>& importance)
    : texels_(map),
      weights_(std::in_place, map, Weights(map, importance)),
      compensated_(0),
      table_(*weights_, 0) {}

void ImportanceStrategy::Sample(const ShadePoints&, const UniformColumns& uniforms, std::uint32_t n,
                                LightCall call, const LightColumns& out) const {
  SampleTexels(texels_.view(), table_.view(), uniforms, n, call.samples(), out);
}

void ImportanceStrategy::EvaluateEscaped(const ShadePoints&, std::uint32_t n, float samples,
                                         const EscapeColumns& rows) const {
  const InversionView inversion = table_.view();
  skywave::EvaluateEscaped(texels_.view(), {.inversion = &inversion}, n, samples, rows);
}

std::string DefaultCompensation(const StrategyUse& use) {
  if (!use.mis || use.starts_light_paths) return "0";
  return fmt::format("{}", 1.0 / use.light_samples);
}

StrategyFactory ImportanceFactory() {
  static constexpr StrategyParameter kParameters[] = {
      {"compensate", "1/n",
       "share of the mean that the density leaves to BSDF sampling, 0 to 1; 1 / light samples with "
       "multiple importance sampling, 0 without it and where light paths start",
       DefaultCompensation}};
  return {
      "importance", "2D inversion: density proportional to the map's luminance", kParameters,
      [](const EnvironmentMap& map, const StrategyValues& values) -> std::unique_ptr<EnvStrategy> {
        return std::make_unique<ImportanceStrategy>(map, NumberValue(values, "compensate", 0, 1));
      }};
}

}  // namespace skywave
