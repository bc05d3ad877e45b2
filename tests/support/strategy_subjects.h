// The strategies that are tested as one suite, and samples of them. A line in Subjects() adds a new
// strategy; a missing line fails EveryStrategyIsTested.
#pragma once

#include <algorithm>
#include <memory>
#include <string>
#include <vector>

#include "lights/strategies/strategy.h"
#include "tests/support/adversarial_maps.h"
#include "tests/support/map_cells.h"
#include "tests/support/shade_points.h"
#include "tests/support/statistics.h"
#include "tests/support/taught_visibility.h"

namespace skywave {

struct Subject {
  std::string specification;
  // Directions have a density that EvaluateEscaped reports, so histograms and integrals are
  // checked.
  bool has_density = true;
  // The mean of radiance * g / pdf is the integral of radiance * g where the density is positive.
  bool unbiased = true;
  // The density is positive wherever there is light to reflect (see EnvStrategy::complete).
  bool complete = true;
  // The density is positive below the horizon of the surface too.
  bool whole_sphere = true;
  // The mapping is monotone in both uniforms: well-distributed points stay well distributed.
  bool stratified = true;
  // There are no samples where a surface reflects none of the map's light.
  bool for_reflection = false;
  // Densities have borders of their own, beside those of the map's texels.
  bool own_borders = false;
  // A strategy that learns has been taught.
  bool taught = false;
  // Relative difference between densities from two formulae.
  float precision = 2e-6f;
};

inline const std::vector<Subject>& Subjects() {
  static const std::vector<Subject> subjects = {
      {.specification = "importance"},
      {.specification = "importance:compensate=1", .complete = false},
      {.specification = "importance:compensate=0.25", .complete = false},
      {.specification = "auto"},
      {.specification = "uniform"},
      {.specification = "cosine", .whole_sphere = false},
      {.specification = "warp"},
      {.specification = "alias", .stratified = false},
      {.specification = "presampled:lights=40", .stratified = false},
      {.specification = "presampled:lights=40,from=polyomino", .stratified = false},
      {.specification = "presampled:lights=40,mode=fixed", .has_density = false, .unbiased = false},
      // Cells are selected by differences of sums but evaluated by the terms of the sums.
      {.specification = "product:cells=30",
       .whole_sphere = false,
       .stratified = false,
       .for_reflection = true,
       .precision = 1e-3f},
      {.specification = "portal:texels=64", .own_borders = true},
      {.specification = "visibility:cells=40", .complete = false},
      {.specification = "visibility:cells=40",
       .complete = false,
       .stratified = false,
       .taught = true},
      {.specification = "visibility:cells=40,compensate=0", .stratified = false, .taught = true},
      {.specification = "ris", .has_density = false, .whole_sphere = false},
      {.specification = "bsdf", .has_density = false, .complete = false},
      {.specification = "median-cut:lights=20", .has_density = false, .unbiased = false},
      {.specification = "variance-cut:lights=20", .has_density = false, .unbiased = false},
      {.specification = "penrose:lights=20", .has_density = false, .unbiased = false},
      {.specification = "polyomino:lights=20", .has_density = false, .unbiased = false},
      {.specification = "median-cut:lights=20,longest=uv", .has_density = false, .unbiased = false},
      {.specification = "structured:lights=20", .has_density = false, .unbiased = false},
      {.specification = "k-means:lights=20", .has_density = false, .unbiased = false},
      {.specification = "kollig-keller:lights=20,pick=power",
       .has_density = false,
       .unbiased = false},
      {.specification = "presampled:lights=40,from=structured", .stratified = false},
      {.specification = "penrose:lights=40,cluster=F2,clusters=12,pick=power",
       .has_density = false,
       .unbiased = false},
      {.specification = "median-cut:lights=40,cluster=F1,clusters=10",
       .has_density = false,
       .unbiased = false},
      {.specification = "polyomino:lights=40,cluster=F3,separation=30",
       .has_density = false,
       .unbiased = false},
      {.specification = "presampled:lights=40,cluster=F2,clusters=9", .stratified = false},
      {.specification = "hybrid:lights=20", .has_density = false, .unbiased = false},
      {.specification = "hybrid:lights=20,strata=lights,angle=25,cluster=F2,clusters=8,inside=1",
       .has_density = false},
      {.specification = "hybrid:lights=20,from=median-cut,inside=1", .has_density = false},
      {.specification = "hybrid:lights=20,from=polyomino,strata=p,p=1,inside=1",
       .has_density = false},
      {.specification = "hybrid:lights=20,strata=p,p=0.4,pick=power",
       .has_density = false,
       .unbiased = false},
      {.specification = "hybrid:lights=20,strata=p,p=0.4,pick=power,rest=presampled",
       .has_density = false,
       .unbiased = false},
      {.specification = "hybrid:lights=20,strata=lights,rest=presampled,rest-samples=30",
       .has_density = false,
       .unbiased = false},
      {.specification = "hybrid:lights=20,from=median-cut,strata=p,p=0.4,rest=presampled,"
                        "rest-samples=30,rest-from=penrose",
       .has_density = false,
       .unbiased = false},
      {.specification = "hybrid:lights=20,strata=p,p=0.4,pick=power,rest=presampled,"
                        "rest-samples=30,rest-mode=jittered",
       .has_density = false,
       .unbiased = false},
      {.specification =
           "hybrid:lights=20,rest=presampled,rest-samples=30,rest-mode=jittered,inside=1",
       .has_density = false},
      {.specification = "hybrid:lights=20,strata=p,p=0.4,rest=product,rest-cells=30",
       .has_density = false,
       .unbiased = false,
       .whole_sphere = false,
       .stratified = false,
       .for_reflection = true,
       .precision = 1e-3f},
      {.specification = "hybrid:lights=20,strata=p,p=0.4,pick=power,rest=product,rest-cells=30",
       .has_density = false,
       .unbiased = false,
       .whole_sphere = false,
       .stratified = false,
       .for_reflection = true,
       .precision = 1e-3f},
  };
  return subjects;
}

inline std::unique_ptr<EnvStrategy> Make(const Subject& subject, const EnvironmentMap& map) {
  auto strategy = MakeStrategy(subject.specification, map);
  if (!subject.taught) return strategy;
  return Teach(dynamic_cast<const VisibilityStrategy&>(*strategy));
}

// Returns a map to test a subject on. Only the subject that draws by portals gets some: `auto`
// would spend a second on their tables in every test, and then draws as `importance` does.
inline EnvironmentMap MapFor(const Subject& subject, const Image& latlong,
                             const NamedOrientation& orientation) {
  EnvironmentMap map = {latlong, orientation.map_from_world, {}};
  if (subject.own_borders) map.portals = PortalsAroundTheOrigin();
  return map;
}

inline std::string NameOf(const Subject& subject) {
  std::string name = subject.specification + (subject.taught ? " taught" : "");
  for (char& c : name) c = std::isalnum(static_cast<unsigned char>(c)) ? c : '_';
  return name;
}

inline const Vec kNormal = Unit({0.3, 0.8, 0.5});
inline constexpr std::uint32_t kSamples = 40000;
inline constexpr double kRounding = 2e-6;  // error of a direction and of its transformation to the
                                           // map [rad]

// Evaluates rays along `directions` that compete with light samples; ray i left row i of
// `surfaces`.
inline soa::Table<EscapeColumns> Evaluate(const EnvStrategy& strategy,
                                          const SurfaceColumns& surfaces,
                                          const std::vector<Vec>& directions,
                                          float light_samples = 1) {
  const auto count = std::uint32_t(directions.size());
  soa::Table<EscapeColumns> rows(count);
  for (std::uint32_t i = 0; i < count; ++i) {
    Put(directions[i], i, rows->dir_x, rows->dir_y, rows->dir_z);
    rows->pdf[i] = 1;
    rows->from[i] = i;
  }
  const LambertPoints points(surfaces, count);
  soa::Table<LightColumns> samples(count);
  strategy.Sample(points, RandomUniforms(count, 1), count, {}, samples);
  strategy.EvaluateEscaped(points, count, light_samples, rows);
  return rows;
}

// What a ray through the middle of each cell of a map sees that competes with light samples of one
// surface.
struct SeenCells {
  std::vector<float> pdf, r, g, b;
};

inline SeenCells See(const EnvStrategy& strategy, const MapCells& cells, float samples) {
  constexpr std::size_t kRows = 1 << 15;  // at a time, so that they stay in the cache
  const auto surfaces = SurfacesWith(kNormal, 1);
  const LambertPoints points(surfaces, 1);
  soa::Table<LightColumns> sample(1);
  strategy.Sample(points, RandomUniforms(1, 1), 1, {}, sample);
  soa::Table<EscapeColumns> rows(kRows);
  SeenCells seen;
  for (std::vector<float>* column : {&seen.pdf, &seen.r, &seen.g, &seen.b}) {
    column->reserve(cells.size());
  }
  for (std::size_t begin = 0; begin < cells.size(); begin += kRows) {
    const auto count = std::uint32_t(std::min(kRows, cells.size() - begin));
    for (std::uint32_t i = 0; i < count; ++i) {
      Put(cells.directions()[begin + i], i, rows->dir_x, rows->dir_y, rows->dir_z);
      rows->pdf[i] = 1;
      rows->from[i] = 0;
    }
    strategy.EvaluateEscaped(points, count, samples, rows);
    seen.pdf.insert(seen.pdf.end(), rows->light_pdf, rows->light_pdf + count);
    seen.r.insert(seen.r.end(), rows->radiance_r, rows->radiance_r + count);
    seen.g.insert(seen.g.end(), rows->radiance_g, rows->radiance_g + count);
    seen.b.insert(seen.b.end(), rows->radiance_b, rows->radiance_b + count);
  }
  return seen;
}

}  // namespace skywave
