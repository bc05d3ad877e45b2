#include "lights/strategies/texels.h"

#include <fmt/format.h>

#include <algorithm>
#include <bit>
#include <cassert>
#include <cmath>

#include "base/error.h"
#include "lights/light_sets/light_builder.h"
#include "lights/light_sets/light_file.h"
#include "lights/strategies/importance.h"
#include "lights/strategies/lights.h"

namespace skywave {
namespace {

// A pyramid level: sums over regions, row-major.
struct Sums {
  std::uint32_t width, height;
  std::vector<double> value;
  double At(std::uint32_t x, std::uint32_t y) const { return value[std::size_t(y) * width + x]; }
};

// Returns the share of the first of two weights in units of 1 / kWarpOne. It is 0 or kWarpOne only
// if one of the weights is 0.
std::uint16_t Share(double first, double second) {
  if (first + second <= 0 || second <= 0) return std::uint16_t(kWarpOne);
  if (first <= 0) return 0;
  const double share = std::round(first / (first + second) * kWarpOne);
  return std::uint16_t(std::clamp(share, 1.0, double(kWarpOne - 1)));
}

}  // namespace

WarpStrategy::Tables::Tables(const EnvironmentMap& map) : texels(map) {
  const std::uint32_t width = texels.width(), height = texels.height();
  const std::vector<double> importance = TexelImportance(texels);
  std::vector<Sums> pyramid = {{std::bit_ceil(width), std::bit_ceil(height), {}}};
  pyramid[0].value.resize(std::size_t(pyramid[0].width) * pyramid[0].height);
  for (std::uint32_t y = 0; y < height; ++y) {
    std::copy_n(&importance[std::size_t(y) * width], width,
                &pyramid[0].value[std::size_t(y) * pyramid[0].width]);
  }
  // The pyramid ends with one region. Both sides are halved once they are equal, and the longer one
  // before that.
  while (pyramid.back().width > 1 || pyramid.back().height > 1) {
    const Sums& fine = pyramid.back();
    const std::uint32_t across = fine.width >= fine.height ? 2 : 1;
    const std::uint32_t down = fine.height >= fine.width ? 2 : 1;
    Sums coarse = {fine.width / across, fine.height / down, {}};
    coarse.value.assign(std::size_t(coarse.width) * coarse.height, 0.0);
    for (std::uint32_t y = 0; y < fine.height; ++y) {
      for (std::uint32_t x = 0; x < fine.width; ++x) {
        coarse.value[std::size_t(y / down) * coarse.width + x / across] += fine.At(x, y);
      }
    }
    pyramid.push_back(std::move(coarse));
  }
  const auto levels = std::uint32_t(pyramid.size() - 1);
  assert(levels <= kMaxWarpLevels);
  warp.levels = levels;
  // The way down makes the records of each level, and the probability that they give every region.
  std::vector<double> probability = {1.0};
  for (std::uint32_t l = 0; l < levels; ++l) {
    const Sums &coarse = pyramid[levels - l], &fine = pyramid[levels - l - 1];
    const bool split_x = fine.width > coarse.width, split_y = fine.height > coarse.height;
    std::vector<WarpRecord> level(coarse.value.size());
    std::vector<double> next(fine.value.size());
    for (std::uint32_t y = 0; y < coarse.height; ++y) {
      for (std::uint32_t x = 0; x < coarse.width; ++x) {
        const std::uint32_t fx = split_x ? 2 * x : x, fy = split_y ? 2 * y : y;
        double child[2][2] = {};  // [bottom][right]
        for (std::uint32_t b = 0; b <= std::uint32_t(split_y); ++b) {
          for (std::uint32_t r = 0; r <= std::uint32_t(split_x); ++r) {
            child[b][r] = fine.At(fx + r, fy + b);
          }
        }
        WarpRecord& record = level[std::size_t(y) * coarse.width + x];
        record = {Share(child[0][0] + child[0][1], child[1][0] + child[1][1]),
                  Share(child[0][0], child[0][1]), Share(child[1][0], child[1][1]), 0};
        const double top = double(record.top) / kWarpOne;
        const double left[2] = {double(record.left_of_top) / kWarpOne,
                                double(record.left_of_bottom) / kWarpOne};
        const double here = probability[std::size_t(y) * coarse.width + x];
        for (std::uint32_t b = 0; b <= std::uint32_t(split_y); ++b) {
          const double row = split_y ? (b == 0 ? top : 1 - top) : 1;
          for (std::uint32_t r = 0; r <= std::uint32_t(split_x); ++r) {
            const double column = split_x ? (r == 0 ? left[b] : 1 - left[b]) : 1;
            next[std::size_t(fy + b) * fine.width + fx + r] = here * row * column;
          }
        }
      }
    }
    records.push_back(std::move(level));
    warp.level[l] = {records.back().data(), coarse.width, split_x, split_y};
    probability = std::move(next);
  }
  density.resize(std::size_t(width) * height);
  for (std::uint32_t y = 0; y < height; ++y) {
    const double solid_angle = RowSolidAngle(int(width), int(height), int(y));
    for (std::uint32_t x = 0; x < width; ++x) {
      density[std::size_t(y) * width + x] =
          float(probability[std::size_t(y) * pyramid[0].width + x] / solid_angle);
    }
  }
}

std::size_t WarpStrategy::table_bytes() const {
  std::size_t bytes = tables_->texels.bytes() + tables_->density.size() * sizeof(float);
  for (const auto& level : tables_->records) bytes += level.size() * sizeof(WarpRecord);
  return bytes;
}

std::unique_ptr<EnvStrategy> WarpStrategy::Turned(const EnvironmentMap& map) const {
  return std::unique_ptr<EnvStrategy>(new WarpStrategy(tables_.Turned(map)));
}

void WarpStrategy::Sample(const ShadePoints&, const UniformColumns& uniforms, std::uint32_t n,
                          LightCall call, const LightColumns& out) const {
  SampleTexelsByWarp(tables_.texels(), tables_->warp, tables_->density.data(), uniforms, n,
                     call.samples(), out);
}

void WarpStrategy::EvaluateEscaped(const ShadePoints&, std::uint32_t n, float samples,
                                   const EscapeColumns& rows) const {
  skywave::EvaluateEscaped(tables_.texels(), {.table = tables_->density.data()}, n, samples, rows);
}

CellStrategy::Tables::Tables(const EnvironmentMap& map, const CellMap& cell_of_texel,
                             std::uint32_t cells)
    : texels(map),
      sampler(map.latlong->width, map.latlong->height, TexelImportance(texels), cell_of_texel,
              cells) {}

std::unique_ptr<EnvStrategy> CellStrategy::Turned(const EnvironmentMap& map) const {
  return std::unique_ptr<EnvStrategy>(new CellStrategy(name_, tables_.Turned(map)));
}

void CellStrategy::Sample(const ShadePoints&, const UniformColumns& uniforms, std::uint32_t n,
                          LightCall call, const LightColumns& out) const {
  const CellSampler& sampler = tables_->sampler;
  const SearchTreeView tree = sampler.tree();
  SampleCells(tables_.texels(), sampler.view(), sampler.cells() > 1 ? &tree : nullptr, uniforms, n,
              call.samples(), out);
}

void CellStrategy::EvaluateEscaped(const ShadePoints&, std::uint32_t n, float samples,
                                   const EscapeColumns& rows) const {
  skywave::EvaluateEscaped(tables_.texels(), {.table = tables_->sampler.density().data()}, n,
                           samples, rows);
}

StrategyFactory WarpFactory() {
  return {"warp",
          "hierarchical warp down a pyramid of luminance",
          {},
          [](const EnvironmentMap& map, const StrategyValues&) -> std::unique_ptr<EnvStrategy> {
            return std::make_unique<WarpStrategy>(map);
          }};
}

namespace {

std::unique_ptr<EnvStrategy> MakeAlias(const EnvironmentMap& map, const StrategyValues&) {
  return std::make_unique<CellStrategy>("alias", map, CellMap(map.latlong->rgb.size() / 3, 0), 1);
}

// Throws if there is light outside of the cells of a file, where no sample would find it.
void RequireCells(const SphereMap& light, const LightSet& set, const std::string& file) {
  for (std::size_t i = 0; i < light.texels(); ++i) {
    if (set.cell_of_texel[i] != kNoCell || !(light.luminance[i] > 0)) continue;
    throw InputError(
        InputPosition::File(file),
        fmt::format("texel {}, {} of the map has light and no cell: presampled needs cells "
                    "everywhere, as without --strata (hybrid takes a part of the map)",
                    i % std::size_t(light.width), i / std::size_t(light.width)));
  }
}

std::span<const StrategyParameter> PresampledParameters() {
  static const std::vector<StrategyParameter> parameters = [] {
    std::vector<StrategyParameter> all = {kFromParameter};
    all.insert(all.end(), LightParameters().begin(), LightParameters().end());
    for (StrategyParameter& parameter : all) {
      if (parameter.key == "lights")
        parameter = {"lights", "360", "number of cells, or auto:BIAS with mode=fixed"};
      parameter.chooses_lights = true;
    }
    all.insert(all.begin(), {{"mode", "jittered",
                              "fixed: the cell's light; jittered: a texel of it by importance"},
                             kFileParameter});
    return all;
  }();
  return parameters;
}

std::unique_ptr<EnvStrategy> MakePresampled(const EnvironmentMap& map,
                                            const StrategyValues& values) {
  constexpr std::string_view kModes[] = {"fixed", "jittered"};
  LightOptions options = ReadLightOptions(values);
  options.source = ReadLightSource(values);
  const std::string& file = TextValue(values, kFileParameter.key);
  if (!file.empty()) RequireDefaults("presampled", PresampledParameters(), values);
  const auto lights_of = [&](const SphereMap& light) {
    if (file.empty()) return BuildLights(light, options);
    LightSet set = ReadLightFile(file, light);
    RequireCells(light, set, file);
    return set;
  };
  if (ChoiceValue(values, "mode", kModes) == 0) {
    return std::make_unique<LightsStrategy>("presampled", map,
                                            lights_of(MakeSphereMap(map.latlong)),
                                            /*all=*/false);
  }
  if (options.bias) {
    throw OptionError("strategy", "presampled",
                      "lights=auto needs mode=fixed: samples inside cells are unbiased");
  }
  // The light that samples will find is cut into cells, so that every texel with light has one.
  const Image held = Texels(map).Held();
  const SphereMap light = MakeSphereMap(held);
  const LightSet cells = lights_of(light);
  // A black map has no cells: one that is all of it is sampled uniformly.
  if (cells.lights.empty()) return MakeAlias(map, values);
  return std::make_unique<CellStrategy>("presampled", map, cells.cell_of_texel,
                                        std::uint32_t(cells.lights.size()));
}

}  // namespace

StrategyFactory AliasFactory() {
  return {"alias", "one alias table over all texels (loses stratification)", {}, MakeAlias};
}

StrategyFactory PresampledFactory() {
  return {"presampled", "cells of the map, picked by energy (T 7.3)", PresampledParameters(),
          MakePresampled};
}

}  // namespace skywave
