#include "lights/strategies/visibility.h"

#include <tbb/parallel_for.h>
#include <tbb/parallel_sort.h>

#include <algorithm>
#include <cmath>
#include <numbers>
#include <optional>

#include "lights/strategies/importance.h"
#include "lights/strategies/product.h"
#include "lights/tables/inversion_table.h"

namespace skywave {
namespace {

constexpr std::uint32_t kCellBits = 8, kCellShift = kPlaceWordShift + 1;
static_assert(kCellBits + 1 == kPlaceWordFree);

// A node is split where so many rays have begun.
constexpr std::size_t kSplitRays = 1024;
// The estimate of the node above counts as so many rays.
constexpr double kPriorRays = 3;
// A place is drawn from as it was learnt if that has so many times less variance than light alone,
// whose samples are better stratified.
constexpr double kWorthwhile = 2;
// Chunks of rows with both kinds of places pay for both. So where learning pays for more than the
// first share of the rays it is used everywhere, and below the second one nowhere.
constexpr double kMostly = 0.25, kHardly = 0.02;

std::uint32_t CellOf(VisibilityRay ray) {
  return std::uint32_t(ray >> kCellShift) & ((1u << kCellBits) - 1);
}
bool Arrived(VisibilityRay ray) { return (ray >> kPlaceWordShift & 1) != 0; }

// Returns about the mean of max(cos, 0) over normals with this mean.
double MeanCosine(const std::array<double, 3>& normal, const LightCell& cell) {
  double along = 0, square = 0;
  for (std::size_t i = 0; i < 3; ++i) {
    along += normal[i] * double(cell.dir[i]), square += normal[i] * normal[i];
  }
  const double spread =
      std::max(0.0, 1 - square) / 3 + 0.5 * std::pow(std::min(double(cell.radius), 1.0), 2);
  return 0.5 * (along + std::sqrt(along * along + 0.64 * spread));
}

using Visibility = std::vector<float>;  // of each cell: share of the rays that get out

// Returns the estimate for every cell from `rays`, with `above` as the prior.
Visibility Learn(std::span<const VisibilityRay> rays, const Visibility& above) {
  std::vector<std::uint32_t> all(above.size()), arrived(above.size());
  for (const VisibilityRay ray : rays) {
    const std::uint32_t cell = CellOf(ray);
    ++all[cell], arrived[cell] += Arrived(ray);
  }
  Visibility learnt(above.size());
  for (std::size_t i = 0; i < above.size(); ++i) {
    learnt[i] = float((double(arrived[i]) + kPriorRays * double(above[i])) / (all[i] + kPriorRays));
  }
  return learnt;
}

}  // namespace

VisibilityRay PackVisibilityRay(const PlaceBox& box, const std::array<float, 3>& org,
                                const std::array<float, 3>& normal, std::uint32_t cell,
                                bool arrived) {
  return PackPlace(box, org, normal) | std::uint64_t(cell) << kCellShift |
         std::uint64_t(arrived) << kPlaceWordShift;
}

struct VisibilityStrategy::MapTables {
  MapTables(const EnvironmentMap& map, const VisibilityOptions& options)
      : texels(map),
        compensated(options.compensate),
        base(BaseLuminance(texels, compensated)),
        plain(texels, base) {
    const Image held = texels.Held();
    const SphereMap sphere = MakeSphereMap(held);
    const LightSet set = CutCells(sphere, options.cells);
    cells = MakeLightCells(sphere, set, map.map_from_world);
    for (const DirectionalLight& light : set.lights) solid_angle.push_back(light.solid_angle);
    const auto count = std::uint32_t(cells.size());
    const std::vector<double> importance = TexelImportance(texels);
    sampler.emplace(held.width, held.height, importance, set.cell_of_texel, count);
    density = sampler->DensityInCells(set.cell_of_texel);
    // Texels without light have density 0 whatever their cell is.
    cell_of_texel = set.cell_of_texel;
    std::replace(cell_of_texel.begin(), cell_of_texel.end(), kNoCell, 0u);
    const EnvironmentView view = texels.view();
    const CellsView in_cells = sampler->view();
    slot_texels.resize(in_cells.begin[count]);
    for (std::size_t slot = 0; slot < slot_texels.size(); ++slot) {
      const std::uint32_t texel = in_cells.texel[slot];
      const std::uint32_t row = texel / view.width, column = texel % view.width;
      const TexelLine& line = view.texels[std::size_t(row) * view.lines + column / kLineTexels];
      slot_texels[slot] = {texel, line.texel[column % kLineTexels], density[texel], 0};
    }
    above.resize(count);
    double all = 0;
    for (std::size_t i = 0; i < importance.size(); ++i) {
      const auto x = std::uint32_t(i) % view.width, y = std::uint32_t(i) / view.width;
      if (importance[i] <= 0) continue;
      const double share = base < 0 ? 1 : 1 - double(base) / double(texels.Luminance(x, y));
      above[cell_of_texel[i]] += importance[i] * std::max(0.0, share);
      all += importance[i] * std::max(0.0, share);
    }
    for (double& share : above) share /= all;
  }
  std::size_t bytes() const {
    return texels.bytes() + plain.bytes() + sampler->bytes() + density.size() * sizeof(float) +
           slot_texels.size() * sizeof(SlotTexel) + cell_of_texel.size() * sizeof(std::uint32_t) +
           cells.size() * sizeof(LightCell);
  }
  SlotTexelsView slots() const {
    const CellsView view = sampler->view();
    return {.begin = view.begin, .slots = view.slots, .texels = slot_texels.data()};
  }

  Texels texels;
  double compensated;
  float base;
  InversionTable plain;   // as `importance` has it
  CellMap cell_of_texel;  // no kNoCell: texels without light belong to cell 0
  std::vector<LightCell> cells;
  std::vector<double> solid_angle;  // of each cell [sr]
  std::vector<double> above;        // how often `plain` draws each cell
  std::optional<CellSampler> sampler;
  std::vector<SlotTexel> slot_texels;
  std::vector<float> density;  // of each texel inside its cell [1/sr]
};

VisibilityStrategy::VisibilityStrategy(const EnvironmentMap& map, const VisibilityOptions& options)
    : VisibilityStrategy(std::make_shared<MapTables>(map, options), options, 0) {
  tree_.words.assign(kPlaceRoots, kPlaceLeaf);
  tree_.box.side = 1;
}

VisibilityStrategy::VisibilityStrategy(std::shared_ptr<const MapTables> tables,
                                       const VisibilityOptions& options, std::size_t learnt)
    : map_(std::move(tables)),
      options_(options),
      learnt_(learnt),
      trees_(std::uint32_t(map_->cells.size()), std::uint32_t(learnt)),
      probability_(learnt * map_->cells.size()) {}

bool VisibilityStrategy::complete() const { return map_->compensated == 0; }

VisibilityStrategy::PlaceWeights VisibilityStrategy::Weigh(
    std::span<const float> visibility, const std::array<double, 3>& normal) const {
  const std::size_t count = map_->cells.size();
  std::vector<double> cosine(count), wanted(count), weight(count);
  double all = 0, unseen = 0;
  for (std::size_t i = 0; i < count; ++i) {
    const LightCell& cell = map_->cells[i];
    cosine[i] = MeanCosine(normal, cell);
    wanted[i] = double(cell.energy) * cosine[i] * std::sqrt(double(visibility[i]));
    all += wanted[i];
    weight[i] = double(cell.energy) * (cosine[i] + 0.1);
    unseen += weight[i];
  }
  if (all <= 0) return {};
  // One light sample and one BSDF sample are to have a density in proportion to light together;
  // that of the light sample is twice the wanted one less the BSDF sample's.
  double rest = 0;
  std::vector<double> left(count), by_bsdf(count);
  for (std::size_t i = 0; i < count; ++i) {
    by_bsdf[i] = cosine[i] * map_->solid_angle[i] / std::numbers::pi;
    left[i] = std::max(
        0.0, (1 + options_.compensate) * wanted[i] / all - options_.compensate * by_bsdf[i]);
    rest += left[i];
  }
  double by_plain = 0, by_learnt = 0;  // variances, but for what both have in common
  for (std::size_t i = 0; i < count; ++i) {
    weight[i] *= options_.defensive / unseen;
    weight[i] += (1 - options_.defensive) * (rest > 0 ? left[i] / rest : wanted[i] / all);
    const double square = wanted[i] * wanted[i];
    if (square <= 0) continue;
    by_plain += square / (map_->above[i] + by_bsdf[i]);
    by_learnt += square / (weight[i] + by_bsdf[i]);
  }
  return {std::move(weight), by_plain >= kWorthwhile * by_learnt};
}

void VisibilityStrategy::SetPlace(std::size_t place, const std::vector<double>& weights) {
  const std::size_t count = map_->cells.size();
  std::vector<std::uint16_t> mass(count);
  std::vector<double> leaf(trees_.leaves());
  trees_.Set(std::uint32_t(place), weights.data(), mass.data(), leaf.data());
  for (std::size_t i = 0; i < count; ++i) {
    probability_[place * count + i] = float(leaf[i / kNodeFan] * mass[i]);
  }
}

std::unique_ptr<VisibilityStrategy> VisibilityStrategy::Taught(std::vector<VisibilityRay>& rays,
                                                               const PlaceBox& box) const {
  tbb::parallel_sort(rays.begin(), rays.end());
  PlaceTree tree = BuildPlaceTree(rays, box, kSplitRays, std::size_t(options_.places));
  const std::size_t cells = map_->cells.size();
  const auto rays_of = [&](const PlaceTree::Node& node) {
    return std::span<const VisibilityRay>(rays).subspan(node.begin, node.end - node.begin);
  };
  const Visibility all = Learn(rays, Visibility(cells, 0.5f));
  std::vector<Visibility> visibility;
  for (const PlaceTree::Node& node : tree.nodes) {
    const bool is_root = node.parent == visibility.size();
    visibility.push_back(Learn(rays_of(node), is_root ? all : visibility[node.parent]));
  }
  const auto node_of = [&](std::size_t place) { return tree.nodes[tree.places[place]]; };
  std::vector<PlaceWeights> weights(tree.places.size());
  tbb::parallel_for(std::size_t{0}, tree.places.size(), [&](std::size_t i) {
    weights[i] = Weigh(visibility[tree.places[i]], MeanNormal(rays_of(node_of(i))));
  });
  std::size_t paying = 0, rays_of_all = 0;
  for (std::size_t i = 0; i < tree.places.size(); ++i) {
    const std::size_t count = node_of(i).end - node_of(i).begin;
    paying += weights[i].pays ? count : 0, rays_of_all += count;
  }
  const bool pays_mostly = double(paying) > kMostly * double(rays_of_all);
  const bool pays_hardly = double(paying) < kHardly * double(rays_of_all);
  const auto keeps = [&](std::size_t i) {
    return !weights[i].of_cells.empty() && !pays_hardly && (pays_mostly || weights[i].pays);
  };
  // Places without tables have all the same number.
  std::vector<std::uint32_t> place(tree.places.size());
  std::uint32_t learnt = 0;
  for (std::size_t i = 0; i < tree.places.size(); ++i) place[i] = keeps(i) ? learnt++ : 0;
  for (std::size_t i = 0; i < tree.places.size(); ++i) {
    if (!keeps(i)) place[i] = learnt;
  }
  tree.Renumber(place);
  std::unique_ptr<VisibilityStrategy> taught(new VisibilityStrategy(map_, options_, learnt));
  tbb::parallel_for(std::size_t{0}, tree.places.size(), [&](std::size_t i) {
    if (keeps(i)) taught->SetPlace(place[i], weights[i].of_cells);
  });
  taught->tree_ = std::move(tree);
  return taught;
}

std::size_t VisibilityStrategy::table_bytes() const {
  return map_->bytes() + trees_.bytes() + tree_.bytes() + probability_.size() * sizeof(float);
}

PlacePicksView VisibilityStrategy::Picks() const {
  return {.trees = trees_.view(),
          .probability = probability_.data(),
          .cells = std::uint32_t(map_->cells.size()),
          .learnt = std::uint32_t(learnt_)};
}

void VisibilityStrategy::Sample(const ShadePoints& points, const UniformColumns& uniforms,
                                std::uint32_t n, LightCall call, const LightColumns& out) const {
  // The first sample of a surface finds its place for all others: until then no BSDF has moved the
  // surface to the side of its light.
  float* const places = points.surfaces.light_norm;
  if (call.index == 0) {
    FindPlaces(tree_.view(), n, points.surfaces, places);
  }
  const EnvironmentView map = map_->texels.view();
  for (std::uint32_t begin = 0; begin < n; begin += kPlaceRows) {
    const std::uint32_t count = std::min(kPlaceRows, n - begin);
    const UniformColumns some = Slice(uniforms, begin);
    const LightColumns lights = Slice(out, begin);
    const auto learnt = std::uint32_t(std::count_if(places + begin, places + begin + count,
                                                    [&](float p) { return p < float(learnt_); }));
    if (learnt < count) SampleTexels(map, map_->plain.view(), some, count, call.samples(), lights);
    if (learnt == 0) continue;
    SampleFromPlaces(map, map_->slots(), Picks(), places + begin, some, count, call.samples(),
                     learnt < count, lights);
  }
}

void VisibilityStrategy::EvaluateEscaped(const ShadePoints& points, std::uint32_t n, float samples,
                                         const EscapeColumns& rows) const {
  alignas(kColumnAlignment) std::uint32_t cell[PaddedRows(kPlaceRows)];
  alignas(kColumnAlignment) float plain[PaddedRows(kPlaceRows)];
  const EnvironmentView map = map_->texels.view();
  const InversionView inversion = map_->plain.view();
  const float* const places = points.surfaces.light_norm;
  for (std::uint32_t begin = 0; begin < n; begin += kPlaceRows) {
    const std::uint32_t count = std::min(kPlaceRows, n - begin);
    const EscapeColumns some = Slice(rows, begin);
    std::uint32_t learnt = 0, all = 0;
    for (std::uint32_t i = 0; i < count; ++i) {
      if (!(some.pdf[i] > 0)) continue;
      ++all, learnt += places[some.from[i]] < float(learnt_);
    }
    skywave::EvaluateEscaped(map, {.inversion = &inversion}, count, samples, some);
    if (learnt == 0) continue;
    std::copy_n(some.light_pdf, count, plain);
    skywave::EvaluateEscaped(map, {.table = map_->density.data()}, count, samples, some);
    FindCells(map, map_->cell_of_texel.data(), count, some, cell);
    ScaleByPlace(Picks(), places, cell, learnt < all ? plain : nullptr, count, some);
  }
}

void VisibilityStrategy::CellsOf(const float* dir_x, const float* dir_y, const float* dir_z,
                                 std::uint32_t n, std::uint32_t* cell) const {
  EscapeColumns rows = {};
  rows.dir_x = const_cast<float*>(dir_x);
  rows.dir_y = const_cast<float*>(dir_y);
  rows.dir_z = const_cast<float*>(dir_z);
  FindCells(map_->texels.view(), map_->cell_of_texel.data(), n, rows, cell);
}

StrategyFactory VisibilityFactory() {
  static constexpr StrategyParameter kParameters[] = {
      {"cells", "128", "number of cells that the map is cut into, up to 256"},
      {"places", "4096", "number of places of the scene, at most: bounds the memory"},
      {"compensate", "1",
       "share of what BSDF samples find that is left to them, 0 to 1: 1 / light samples"},
      {"defensive", "0.1", "share of samples that do not trust what was learnt, from 0.001 to 1"}};
  return {
      "visibility", "cells of the map picked by the light that a pilot saw arrive", kParameters,
      [](const EnvironmentMap& map, const StrategyValues& values) -> std::unique_ptr<EnvStrategy> {
        return std::make_unique<VisibilityStrategy>(
            map, VisibilityOptions{.cells = IntValue(values, "cells", 1, int(kMaxVisibilityCells)),
                                   .places = IntValue(values, "places", 16, 1 << 20),
                                   .compensate = NumberValue(values, "compensate", 0, 1),
                                   .defensive = NumberValue(values, "defensive", 0.001, 1)});
      }};
}

}  // namespace skywave
