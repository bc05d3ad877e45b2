// A way to light by an illumination map: where its light samples come from and with what density.
//
// Strategies are interchangeable: each is a file pair strategy_*.{h,cc}, one line in the table of
// strategies.cc, and is run through one suite of statistical tests.
#pragma once

#include <cstddef>
#include <cstdint>
#include <memory>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "kernels/columns.h"
#include "lights/environment_map.h"

namespace skywave {

// Immutable after construction, shared by all threads. Sample and EvaluateEscaped are called once a
// wave; their bodies are kernel calls.
class EnvStrategy {
 public:
  virtual ~EnvStrategy() = default;
  virtual std::string_view name() const = 0;
  virtual std::size_t table_bytes() const = 0;

  // Draws one light sample for each of surfaces [0, n): writes dir (unit, world), r, g, b (radiance
  // from there) and pdf [1/sr] of `out`. pdf <= 0 says that there is no sample.
  virtual void Sample(const SurfaceColumns& surfaces, const UniformColumns& uniforms,
                      std::uint32_t n, const LightColumns& out) const = 0;

  // Writes radiance and light_pdf of rows [0, n): what a ray that leaves the scene sees, and the
  // density with which Sample would have chosen its direction at surface `from` of `surfaces`
  // [1/sr]. Where pdf is 0 the ray had no light sample for a partner and light_pdf is unspecified.
  virtual void EvaluateEscaped(const SurfaceColumns& surfaces, std::uint32_t n,
                               const EscapeColumns& rows) const = 0;

  // False: the density misses light that is there (it is zero where radiance is not), so the
  // strategy is right only together with BSDF sampling.
  virtual bool complete() const { return true; }
};

// A parameter of a strategy as the user gives it: --strategy name:key=value,key=value.
struct StrategyParameter {
  std::string_view key, default_value, meaning;
};
using StrategyValues = std::vector<std::pair<std::string, std::string>>;

struct StrategyFactory {
  std::string_view name, description;
  std::span<const StrategyParameter> parameters;
  std::unique_ptr<EnvStrategy> (*make)(const EnvironmentMap& map, const StrategyValues& values);
};

std::span<const StrategyFactory> Strategies();

// Makes the strategy of a specification "name" or "name:key=value,...". Throws InputError with the
// names or keys there are, where one is unknown.
std::unique_ptr<EnvStrategy> MakeStrategy(const std::string& specification,
                                          const EnvironmentMap& map);

// The value of `key`, which the factory declares: given or default.
bool BoolValue(const StrategyValues& values, std::string_view key);

}  // namespace skywave
