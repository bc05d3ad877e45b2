#include "lights/strategies/hybrid.h"

#include <algorithm>
#include <numbers>

#include "base/error.h"
#include "kernels/borrowed.h"
#include "kernels/lights/environment.h"
#include "kernels/lights/texel_samplers.h"
#include "lights/light_sets/light_file.h"
#include "lights/strategies/importance.h"
#include "lights/strategies/lights.h"

namespace skywave {
namespace {

constexpr std::string_view kDivisions[] = {"variation", "p", "lights"};
constexpr std::string_view kRests[] = {"importance", "presampled", "product"};
constexpr std::string_view kRestModes[] = {"fixed", "jittered"};
constexpr std::string_view kSameSource = "same";

struct StratumColumns {
  float* u;  // in [0, 1)

  template <class Self, class F>
  static constexpr void ForEachColumn(Self& self, F f) {
    f(self.u);
  }
};

// Stratum B reuses the rescaled uniform (SplitUniforms). t_far of light samples is free until they
// are evaluated, so it holds that uniform.
struct StratumUniforms : Borrowed<StratumColumns> {
  StratumUniforms(const LightColumns& samples, std::uint32_t n)
      : Borrowed({samples.t_far}, n, "StratumUniforms") {}
};

// Returns luminance of the light times solid angle over A; solid angle alone where that is black.
std::vector<double> ImportanceOfA(const Texels& light, const SphereMap& map, const CellMap& cells) {
  std::vector<double> importance(map.texels());
  double total = 0;
  for (int y = 0; y < map.height; ++y) {
    for (int x = 0; x < map.width; ++x) {
      const std::size_t i = std::size_t(y) * std::size_t(map.width) + std::size_t(x);
      if (cells[i] == kNoCell) continue;
      total += importance[i] =
          light.Luminance(std::uint32_t(x), std::uint32_t(y)) * map.solid_angle[std::size_t(y)];
    }
  }
  if (total <= 0) {
    for (std::size_t i = 0; i < importance.size(); ++i) {
      importance[i] = map.solid_angle[i / std::size_t(map.width)];
    }
  }
  return importance;
}

// The stratum A is where a file has cells.
Strata StrataOfCells(const CellMap& cells) {
  Strata strata;
  strata.in_a.resize(cells.size());
  std::transform(cells.begin(), cells.end(), strata.in_a.begin(),
                 [](std::uint32_t cell) { return std::uint8_t(cell != kNoCell); });
  return strata;
}

}  // namespace

// Divides the map into `a` and `b` and returns the lights of A, whose cells are texels of A alone.
LightSet HybridStrategy::MakeLightsOfA(const SphereMap& map, Image& a, Image& b) {
  LightSet lights;
  Strata strata;
  if (options_.file.empty()) {
    strata = DivideMap(map, options_.strata);
  } else {
    lights = ReadLightFile(options_.file, map);
    strata = StrataOfCells(lights.cell_of_texel);
  }
  a = StratumImage(map, strata, true);
  b = StratumImage(map, strata, false);
  const SphereMap of_a = MakeSphereMap(a);
  share_ = map.energy > 0 ? float(std::clamp(of_a.energy / map.energy, 0.0, 1.0)) : 0;
  if (options_.file.empty()) {
    LightOptions options = options_.lights;
    if (options.bias && share_ > 0) options.bias = *options.bias / share_;
    lights = BuildLights(of_a, options);
    lights.bias *= share_;
  }
  for (std::size_t i = 0; i < strata.in_a.size(); ++i) {
    if (strata.in_a[i] == 0) lights.cell_of_texel[i] = kNoCell;
  }
  return lights;
}

// Makes what draws from B. An escaped ray sees as a light what random samples could have found: B,
// and A if its cells are sampled inside, but not what directional lights stand for.
void HybridStrategy::MakeRest(const EnvironmentMap& map, const Image& b) {
  Texels& light = rest_texels_ ? *rest_texels_ : *texels_;
  LightOptions cells = options_.lights;
  cells.source = options_.rest_source;
  cells.lights = options_.rest_samples;
  cells.bias.reset();
  cells.cluster.reset();
  switch (options_.rest) {
    case HybridRest::kImportance: {
      double compensate = 0;
      rest_table_.emplace(light, BaseLuminance(light, compensate));
      break;
    }
    case HybridRest::kLights:
      rest_lights_.emplace(MakeLights(map, b, cells));
      rest_is_dark_ = rest_lights_->size() == 0;
      break;
    case HybridRest::kCells: {
      const Image held = light.Held();
      const LightSet set = BuildLights(MakeSphereMap(held), cells);
      // A black stratum has no cells: one that is all of it is sampled uniformly.
      const bool dark = set.lights.empty();
      rest_cells_.emplace(b.width, b.height, TexelImportance(light),
                          dark ? CellMap(set.cell_of_texel.size()) : set.cell_of_texel,
                          dark ? 1 : std::uint32_t(set.lights.size()));
      break;
    }
    case HybridRest::kProduct:
      rest_product_.emplace(map, b, options_.rest_cells);
      break;
  }
  rest_is_dark_ = rest_is_dark_ || share_ >= 1;
}

HybridStrategy::HybridStrategy(const EnvironmentMap& map, const HybridOptions& options)
    : options_(options) {
  // A and B divide the light that samples will find, and exactly that.
  const Image held = Texels(map).Held();
  const SphereMap sphere = MakeSphereMap(held);
  Image a, b;
  const LightSet lights = MakeLightsOfA(sphere, a, b);
  note_ = NoteOfLights(lights);
  lights_.emplace(lights.lights, map.map_from_world);

  const int width = map.latlong->width, height = map.latlong->height;
  if (options.rest == HybridRest::kLights) {
    texels_.emplace(map, options.inside ? a : Image(width, height));
  } else {
    texels_.emplace(map, options.inside ? held : b);
    if (options.inside) rest_texels_.emplace(map, b);
  }
  MakeRest(map, b);
  if (options.inside && !lights.lights.empty()) {
    const CellMap& cells = lights.cell_of_texel;
    cells_.emplace(width, height, ImportanceOfA(*texels_, sphere, cells), cells, lights_->size());
    cell_density_ = cells_->DensityInCells(cells);
  }
}

std::size_t HybridStrategy::table_bytes() const {
  return texels_->bytes() + lights_->bytes() + (cells_ ? cells_->bytes() : 0) +
         cell_density_.size() * sizeof(float) + (rest_table_ ? rest_table_->bytes() : 0) +
         (rest_texels_ ? rest_texels_->bytes() : 0) + (rest_lights_ ? rest_lights_->bytes() : 0) +
         (rest_cells_ ? rest_cells_->bytes() : 0) +
         (rest_product_ ? rest_product_->table_bytes() : 0);
}

LightPlan HybridStrategy::Plan(std::uint32_t requested) const {
  // A stratum without light needs no samples.
  if (options_.all) {
    return {.fixed = lights_->size(),
            .drawn = rest_is_dark_ ? 0 : requested,
            .random_fixed = options_.inside};
  }
  return {.drawn = rest_is_dark_ && lights_->size() == 0 ? 0 : requested};
}

void HybridStrategy::SampleRest(const ShadePoints& points, const UniformColumns& uniforms,
                                std::uint32_t n, LightCall call, const LightColumns& out) const {
  if (rest_table_) {
    SampleTexels(texels_->view(), rest_table_->view(), uniforms, n, call.samples(), out);
  } else if (rest_lights_) {
    PickDirectional(rest_lights_->records(), rest_lights_->tree(), uniforms.u, n, call.samples(),
                    out);
  } else if (rest_cells_) {
    const SearchTreeView tree = rest_cells_->tree();
    SampleCells(texels_->view(), rest_cells_->view(), rest_cells_->cells() > 1 ? &tree : nullptr,
                uniforms, n, call.samples(), out);
  } else {
    rest_product_->Sample(points, uniforms, n, call, out);
  }
}

void HybridStrategy::Sample(const ShadePoints& points, const UniformColumns& uniforms,
                            std::uint32_t n, LightCall call, const LightColumns& out) const {
  if (options_.all && call.index < lights_->size()) {
    if (options_.inside) {
      SampleOneCell(texels_->view(), cells_->view(), call.index, cells_->Scale(call.index),
                    uniforms, n, out);
    } else {
      FillDirectional((*lights_)[call.index], n, out);
    }
  } else if (options_.all || lights_->size() == 0) {
    SampleRest(points, uniforms, n, call, out);
  } else if (rest_is_dark_) {
    PickDirectional(lights_->records(), lights_->tree(), uniforms.u, n, call.samples(), out);
  } else {
    // Uniforms below the share of A pick one of its lights, those above it draw from B.
    {
      const StratumUniforms of_b(out, n);
      SplitUniforms(uniforms.u, n, share_, of_b->u);
      LightCall rest = call;
      rest.share *= 1 - share_;
      SampleRest(points, {.u = of_b->u, .v = uniforms.v}, n, rest, out);
    }
    PickOverSplit(lights_->records(), lights_->tree(), uniforms.u, n, share_, call.samples(), out);
  }
}

void HybridStrategy::EvaluateEscaped(const ShadePoints& points, std::uint32_t n, float samples,
                                     const EscapeColumns& rows) const {
  const float of_rest = samples * (rest_is_dark_ ? 0 : options_.all ? 1 : 1 - share_);
  if (rest_product_ && !rest_is_dark_)
    return rest_product_->EvaluateEscaped(points, n, of_rest, rows);
  TexelDensity density = {.fixed = cell_density_.empty() ? nullptr : cell_density_.data()};
  InversionView inversion;
  if (rest_table_) {
    inversion = rest_table_->view();
    density.inversion = &inversion;
  } else if (rest_cells_) {
    density.table = rest_cells_->density().data();
  }
  skywave::EvaluateEscaped(texels_->view(), density, n, of_rest, rows);
}

std::span<const StrategyParameter> HybridParameters() {
  static const std::vector<StrategyParameter> parameters = [] {
    std::vector<StrategyParameter> all = {
        {.key = "strata",
         .default_value = "variation",
         .meaning = "where the bright part A ends: variation, p or lights",
         .chooses_lights = true},
        {.key = "p",
         .default_value = "0.5",
         .meaning = "fraction of the energy in A (strata=p)",
         .chooses_lights = true},
        {.key = "angle",
         .default_value = "10",
         .meaning = "degrees between the lights A has room for (strata=lights)",
         .chooses_lights = true},
        kFromParameter,
        kFileParameter};
    all.insert(all.end(), LightParameters().begin(), LightParameters().end());
    all.push_back(kPickParameter);
    all.push_back({"rest", "importance", "how B is drawn: importance, presampled or product"});
    all.push_back({"rest-samples", "360", "cells of B (rest=presampled)"});
    all.push_back({"rest-from", kSameSource, "who places these cells: as from; same: from's own"});
    all.push_back(
        {"rest-mode", "fixed", "fixed: the light of such a cell; jittered: a texel in it"});
    all.push_back({"rest-cells", kDefaultProductCellsText, "cells of B (rest=product)"});
    all.push_back({"inside", "0", "1: a random sample inside each of A's cells, not its light"});
    return all;
  }();
  return parameters;
}

HybridOptions ReadHybridOptions(const StrategyValues& values) {
  HybridOptions options;
  options.lights = ReadLightOptions(values);
  options.strata = {.kind = StrataRequest::Kind(ChoiceValue(values, "strata", kDivisions)),
                    .fraction = NumberValue(values, "p", 0, 1),
                    .lights = options.lights.lights,
                    .separation = NumberValue(values, "angle", 0, 360) * std::numbers::pi / 180};
  options.lights.source = ReadLightSource(values);
  options.all = ReadPickAll(values);
  options.file = TextValue(values, kFileParameter.key);
  const std::string_view rest = kRests[ChoiceValue(values, "rest", kRests)];
  const bool jittered = ChoiceValue(values, "rest-mode", kRestModes) == 1;
  options.rest = rest == "presampled" ? (jittered ? HybridRest::kCells : HybridRest::kLights)
                 : rest == "product"  ? HybridRest::kProduct
                                      : HybridRest::kImportance;
  options.rest_samples = IntValue(values, "rest-samples", 1, kMostLights);
  options.rest_cells = IntValue(values, "rest-cells", 1, int(kMaxProductCells));
  options.rest_source = TextValue(values, "rest-from") == kSameSource
                            ? options.lights.source
                            : ReadLightSource(values, "rest-from");
  options.inside = BoolValue(values, "inside");
  if (options.inside && !options.all) {
    throw OptionError("strategy", "hybrid", "inside=1 needs pick=all");
  }
  if (options.inside && options.rest == HybridRest::kProduct) {
    throw OptionError("strategy", "hybrid",
                      "inside=1 needs another rest than product, whose density is of B alone");
  }
  if (!options.file.empty()) RequireDefaults("hybrid", HybridParameters(), values);
  const bool for_lights = options.strata.kind == StrataRequest::Kind::kLights;
  if (options.lights.bias && (options.inside || for_lights)) {
    throw OptionError("strategy", "hybrid",
                      options.inside
                          ? "lights=auto needs inside=0: samples inside cells are unbiased"
                          : "lights=auto needs strata=variation or strata=p");
  }
  return options;
}

StrategyFactory HybridFactory() {
  return {
      "hybrid", "the bright part as lights, the rest at random (T 7.4)", HybridParameters(),
      [](const EnvironmentMap& map, const StrategyValues& values) -> std::unique_ptr<EnvStrategy> {
        return std::make_unique<HybridStrategy>(map, ReadHybridOptions(values));
      }};
}

}  // namespace skywave
