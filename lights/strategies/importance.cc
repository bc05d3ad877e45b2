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
  Image weights(map.latlong->width, map.latlong->height);
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

ImportanceStrategy::Tables::Tables(const EnvironmentMap& map, double compensate)
    : texels(map), compensated(compensate), inversion(texels, BaseLuminance(texels, compensated)) {}

ImportanceStrategy::Tables::Tables(const EnvironmentMap& map, const std::vector<double>& importance)
    : texels(map),
      weights(std::in_place, map, Weights(map, importance)),
      compensated(0),
      inversion(*weights, 0) {}

ImportanceStrategy::ImportanceStrategy(const EnvironmentMap& map, double compensate)
    : tables_(std::make_shared<const Tables>(map, compensate), map) {}

ImportanceStrategy::ImportanceStrategy(const EnvironmentMap& map,
                                       const std::vector<double>& importance)
    : tables_(std::make_shared<const Tables>(map, importance), map) {}

std::size_t ImportanceStrategy::table_bytes() const {
  return tables_->texels.bytes() + (tables_->weights ? tables_->weights->bytes() : 0) +
         tables_->inversion.bytes();
}

std::unique_ptr<EnvStrategy> ImportanceStrategy::Turned(const EnvironmentMap& map) const {
  return std::unique_ptr<EnvStrategy>(new ImportanceStrategy(tables_.Turned(map)));
}

void ImportanceStrategy::Sample(const ShadePoints&, const UniformColumns& uniforms, std::uint32_t n,
                                LightCall call, const LightColumns& out) const {
  SampleTexels(tables_.texels(), tables_->inversion.view(), uniforms, n, call.samples(), out);
}

void ImportanceStrategy::EvaluateEscaped(const ShadePoints&, std::uint32_t n, float samples,
                                         const EscapeColumns& rows) const {
  const InversionView inversion = tables_->inversion.view();
  skywave::EvaluateEscaped(tables_.texels(), {.inversion = &inversion}, n, samples, rows);
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
