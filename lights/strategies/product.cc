#include "lights/strategies/product.h"

#include <algorithm>
#include <cmath>
#include <numbers>

#include "kernels/chunk.h"
#include "lights/light_sets/variance_cut.h"
#include "lights/strategies/importance.h"

namespace skywave {

LightSet CutCells(const SphereMap& map, int cells) {
  if (map.energy <= 0)
    return {{DirectionalLight{.direction = {0, 0, 1}, .energy = 1}}, CellMap(map.texels())};
  return LightsOfRegions(map, VarianceCut(map, cells), LightPosition::kCentroid);
}

std::vector<LightCell> MakeLightCells(const SphereMap& map, const LightSet& set,
                                      const std::array<float, 9>& map_from_world) {
  std::vector<double> spread(set.lights.size());        // energy times square of the chord
  std::vector<double> nearest(set.lights.size(), 1.0);  // cosine of the largest angle
  for (int y = 0; y < map.height; ++y) {
    for (int x = 0; x < map.width; ++x) {
      const std::uint32_t cell =
          set.cell_of_texel[std::size_t(y) * std::size_t(map.width) + std::size_t(x)];
      const double energy = map.Energy(x, y);
      if (cell == kNoCell || energy <= 0) continue;
      const double cosine = Dot(set.lights[cell].direction, map.TexelCentre(x, y));
      spread[cell] += energy * (2 - 2 * cosine);
      nearest[cell] = std::min(nearest[cell], cosine);
    }
  }
  // This is the angle from the centre of a texel to its farthest corner.
  const double half_texel =
      std::hypot(std::numbers::pi / map.width, std::numbers::pi / (2 * map.height));
  std::vector<LightCell> cells;
  for (std::size_t i = 0; i < set.lights.size(); ++i) {
    const DirectionalLight& light = set.lights[i];
    const std::array<float, 3> dir = WorldFromMap(light.direction, map_from_world);
    const double angle = std::acos(std::clamp(nearest[i], -1.0, 1.0)) + half_texel;
    const double mean_square = light.energy > 0 ? std::max(0.0, spread[i] / light.energy) : 0;
    cells.push_back({.dir = {dir[0], dir[1], dir[2]},
                     .energy = float(light.energy),
                     .radius = float(std::sqrt(mean_square)),
                     .reach = angle < std::numbers::pi / 2 ? float(std::sin(angle)) : 1.0f});
  }
  return cells;
}

namespace {

// Calls run(kind, begin, count) for every run of at most kProductRows rows with a density that left
// surfaces of the same BSDF.
template <class Run>
void ForEachBsdfRun(const SurfaceRanges& ranges, const EscapeColumns& rows, std::uint32_t n,
                    Run run) {
  for (std::uint32_t begin = 0; begin < n;) {
    if (rows.pdf[begin] <= 0) {
      ++begin;
      continue;
    }
    std::uint32_t kind = 0;
    while (rows.from[begin] >= ranges.begin[kind + 1]) ++kind;
    std::uint32_t end = begin;
    while (end < n && end - begin < kProductRows && rows.pdf[end] > 0 &&
           rows.from[end] >= ranges.begin[kind] && rows.from[end] < ranges.begin[kind + 1]) {
      ++end;
    }
    run(kind, begin, end - begin);
    begin = end;
  }
}

}  // namespace

ProductStrategy::ProductStrategy(const EnvironmentMap& map, const Image& part, int cells)
    : texels_(map, part) {
  const Image held = texels_.Held();
  const SphereMap sphere = MakeSphereMap(held);
  const LightSet set = CutCells(sphere, cells);
  cells_ = MakeLightCells(sphere, set, map.map_from_world);
  sampler_.emplace(held.width, held.height, TexelImportance(texels_), set.cell_of_texel,
                   std::uint32_t(cells_.size()));
  density_ = sampler_->DensityInCells(set.cell_of_texel);
  // Texels without light have density 0 whatever their cell is.
  cell_of_texel_ = set.cell_of_texel;
  std::replace(cell_of_texel_.begin(), cell_of_texel_.end(), kNoCell, 0u);
}

std::size_t ProductStrategy::table_bytes() const {
  return texels_.bytes() + sampler_->bytes() + density_.size() * sizeof(float) +
         cell_of_texel_.size() * sizeof(std::uint32_t) + cells_.size() * sizeof(LightCell);
}

CellsView ProductStrategy::InCells() const {
  CellsView view = sampler_->view();
  view.density = density_.data();
  return view;
}

void ProductStrategy::Sample(const ShadePoints& points, const UniformColumns& uniforms,
                             std::uint32_t, LightCall call, const LightColumns& out) const {
  alignas(kColumnAlignment) float sums[kMaxProductCells * kProductStride];
  CellPicks picks;
  const auto count = std::uint32_t(cells_.size());
  ForEachBsdfBlock(
      points.ranges, kDenseBsdfs, kProductRows, [&](const BsdfKernels& bsdf, const BsdfRows& at) {
        const SurfaceColumns rows = Slice(points.surfaces, at.begin);
        bsdf.weigh_cells(rows, points.materials, at.n, cells_.data(), count, sums, kProductStride);
        PickCells(sums, count, uniforms.u + at.begin, at.n, picks, rows.light_norm);
        SamplePickedCells(texels_.view(), InCells(), picks, uniforms.v + at.begin, at.n,
                          call.samples(), Slice(out, at.begin));
      });
}

void ProductStrategy::EvaluateEscaped(const ShadePoints& points, std::uint32_t n, float samples,
                                      const EscapeColumns& rows) const {
  skywave::EvaluateEscaped(texels_.view(), {.table = density_.data()}, n, samples, rows);
  ForEachBsdfRun(
      points.ranges, rows, n, [&](std::uint32_t kind, std::uint32_t begin, std::uint32_t count) {
        Chunk<SurfaceColumns, kProductRows> surfaces;
        alignas(kColumnAlignment) std::uint32_t cell[kProductStride];
        alignas(kColumnAlignment) float weight[kProductStride];
        FindCells(texels_.view(), cell_of_texel_.data(), count, Slice(rows, begin), cell);
        const BsdfKernels& bsdf = Bsdfs()[kind];
        GatherWeighedSurfaces(points.surfaces, points.materials, bsdf, rows.from + begin, count,
                              surfaces);
        bsdf.weigh_cell(surfaces, points.materials, count, cells_.data(), cell, weight);
        ScaleByPick(weight, surfaces->light_norm, count, rows.light_pdf + begin);
      });
}

StrategyFactory ProductFactory() {
  static constexpr StrategyParameter kParameters[] = {
      {"cells", kDefaultProductCellsText, "number of cells that the map is cut into, up to 256"}};
  return {
      "product", "cells of the map picked by light times BSDF (Conty Estevez and Lecocq 2018)",
      kParameters,
      [](const EnvironmentMap& map, const StrategyValues& values) -> std::unique_ptr<EnvStrategy> {
        return std::make_unique<ProductStrategy>(
            map, IntValue(values, "cells", 1, int(kMaxProductCells)));
      }};
}

}  // namespace skywave
