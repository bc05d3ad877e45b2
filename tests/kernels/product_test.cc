// Tests strategies that use the BSDF of the surfaces for which they draw: their estimate must be
// the reflected light, computed here by summing BSDF times map over the sphere.

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>

#include "kernels/sampler.h"
#include "lights/strategies/strategy.h"
#include "tests/support/adversarial_maps.h"
#include "tests/support/bsdf_cases.h"
#include "tests/support/map_cells.h"
#include "tests/support/shade_points.h"
#include "tests/support/shading_rows.h"
#include "tests/support/statistics.h"

namespace skywave {
namespace {

constexpr std::uint32_t kRows = 8192;

const std::vector<MaterialCase>& Materials() {
  static const std::vector<MaterialCase> materials = {
      {"Lambert", BsdfKind::kLambert, {.color = {0.2f, 0.5f, 0.8f}}},
      {"Gold", BsdfKind::kConductor, GoldConductor(0.3f)},
      {"Rough", BsdfKind::kConductor, GoldConductor(0.9f)},
      {"Varnish", BsdfKind::kMetallicRoughness, MetallicRoughness(0.3f, 0.2f)},
      {"Leaf",
       BsdfKind::kDiffuseTransmission,
       {.color = {0.4f, 0.3f, 0.1f}, .eta = {0.2f, 0.5f, 0.6f}}},
      *std::find_if(DenseCases().begin(), DenseCases().end(), IsTilted),
  };
  return materials;
}

const std::vector<std::string>& Specifications() {
  static const std::vector<std::string> all = {
      "product:cells=1",  "product:cells=24", "product", "product:cells=256", "ris",
      "ris:map=1,bsdf=3", "ris:map=3,bsdf=0"};
  return all;
}

// One path of a different pixel per row, and the rows of one material that they hit.
struct Hits {
  explicit Hits(const MaterialCase& material)
      : shading(material, kRows, kNormal, AtAngle(kNormal, 0.6)),
        ranges(RangesOf(material.kind, kRows)),
        paths(kRows) {
    const Vec geometric = Unit(kNormal + Vec{0.2, -0.1, 0.15});
    for (std::uint32_t i = 0; i < kRows; ++i) {
      shading.Set(i, kNormal, geometric, AtAngle(kNormal, 0.6));
      shading.surfaces->path[i] = i;
      paths->seed[i] = PixelSeed(i, i / 7, 5);
      paths->sample[i] = i % 5;
    }
  }
  ShadePoints Points() const {
    return {.surfaces = shading.surfaces, .ranges = ranges, .materials = materials, .paths = paths};
  }
  static inline const Vec kNormal = Unit({0.3, 0.8, 0.5});
  ShadingRows shading;
  SurfaceRanges ranges;
  soa::Table<PathColumns> paths;
  MaterialView materials = shading.materials();
};

// Returns the sum of value times radiance over the sphere.
double ReflectedLight(const EnvironmentMap& map, const MaterialCase& material, const Hits& hits) {
  const MapCells cells(map, 512);
  const Image held = HeldMap(map);
  const ShadingRows one(material, std::uint32_t(cells.size()), Hits::kNormal, Hits::kNormal);
  const SurfaceColumns& s = hits.shading.surfaces;
  for (std::uint32_t i = 0; i < cells.size(); ++i) {
    const_cast<ShadingRows&>(one).Set(i, Get(0, s.ns_x, s.ns_y, s.ns_z),
                                      Get(0, s.ng_x, s.ng_y, s.ng_z),
                                      Get(0, s.wo_x, s.wo_y, s.wo_z));
  }
  const auto values = one.Evaluate(cells.directions());
  double sum = 0;
  for (std::uint32_t i = 0; i < cells.size(); ++i) {
    double u, v;
    MapPosition(map.map_from_world, cells.directions()[i], u, v);
    const float* light = held.Pixel(std::clamp(int(u * held.width), 0, held.width - 1),
                                    std::clamp(int(v * held.height), 0, held.height - 1));
    sum += cells.solid_angle(i) *
           Weighted(light[0] * values->r[i], light[1] * values->g[i], light[2] * values->b[i]);
  }
  return sum;
}

// Returns the mean over the rows of light sample `index` in a plan for two.
Moments Estimate(const EnvStrategy& strategy, const Hits& hits, std::uint32_t index) {
  soa::Table<LightColumns> out(kRows);
  strategy.Sample(hits.Points(), RandomUniforms(kRows, 40 + index), kRows,
                  {.index = index, .requested = 2, .pair = 1}, out);
  soa::Table<BsdfValueColumns> values(kRows);
  hits.shading.kernels.evaluate(hits.shading.surfaces, hits.materials, out, kRows, values);
  Moments moments;
  for (std::uint32_t i = 0; i < kRows; ++i) {
    const double worth = std::isinf(out->pdf[i]) ? 1
                         : out->pdf[i] > 0       ? 1 / double(out->pdf[i])
                                                 : 0;
    moments.Add(
        2 * worth *
        Weighted(out->r[i] * values->r[i], out->g[i] * values->g[i], out->b[i] * values->b[i]));
  }
  return moments;
}

TEST(Product, EstimatesTheReflectedLight) {
  const std::size_t tests =
      Specifications().size() * Materials().size() * AdversarialMaps().size() * 2;
  std::size_t judged = 0;
  for (const MaterialCase& material : Materials()) {
    const Hits hits(material);
    for (const NamedMap& named : AdversarialMaps()) {
      const EnvironmentMap map = {named.latlong, Orientations()[1].map_from_world};
      const double exact = ReflectedLight(map, material, hits);
      for (const std::string& specification : Specifications()) {
        const auto strategy = MakeStrategy(specification, map);
        for (const std::uint32_t index : {0u, 1u}) {
          const Moments moments = Estimate(*strategy, hits, index);
          // If hardly any sample finds the light, the mean is not normally distributed.
          if (moments.standard_error() > 0.05 * exact) continue;
          ++judged;
          EXPECT_TRUE(AgreesWith(moments.mean(), moments.standard_error(), exact, SidakLevel(tests),
                                 2e-3 * exact))
              << specification << ", " << material.name << ", " << named.name << ", sample "
              << index;
        }
      }
    }
  }
  EXPECT_GT(judged, tests * 9 / 10);
}

// On a diffuse surface under a map that is brightest below the horizon, the variance of product
// sampling is at most a thirtieth of that of sampling by the map alone.
TEST(Product, DrawsNoLightBelowTheHorizon) {
  Image image(64, 32);
  for (int y = 0; y < image.height; ++y) {
    for (int x = 0; x < image.width; ++x) {
      for (int c = 0; c < 3; ++c) image.Pixel(x, y)[c] = y < 16 ? 1.0f : 50.0f;
    }
  }
  const EnvironmentMap map = {image, Orientations()[0].map_from_world};
  Hits hits(Materials()[0]);
  const Vec up = WorldDirection(map.map_from_world, 0.5, 0);
  for (std::uint32_t i = 0; i < kRows; ++i) hits.shading.Set(i, up, up, up);
  const Moments product = Estimate(*MakeStrategy("product", map), hits, 0);
  const Moments importance = Estimate(*MakeStrategy("importance", map), hits, 0);
  EXPECT_LT(product.standard_error(), 0.18 * importance.standard_error());
}

// The evaluated density must be the sampling density for every BSDF, also if rows that left
// different surfaces are mixed with rows without a density.
TEST(Product, DensitySeenIsTheOneDrawn) {
  std::vector<MaterialCase> materials = Materials();
  for (const MaterialCase& material : DenseCases()) {
    if (material.name == "PaneOily") materials.push_back(material);  // with images of its film
  }
  ASSERT_EQ(materials.size(), Materials().size() + 1);
  for (const MaterialCase& material : materials) {
    const Hits hits(material);
    const EnvironmentMap map = {AdversarialMap("Noise"), Orientations()[1].map_from_world};
    const auto strategy = MakeStrategy("product", map);
    soa::Table<LightColumns> out(kRows);
    strategy->Sample(hits.Points(), RandomUniforms(kRows, 50), kRows, {.requested = 3}, out);
    soa::Table<EscapeColumns> rows(kRows);
    for (std::uint32_t i = 0; i < kRows; ++i) {
      Put(Get(i, out->dir_x, out->dir_y, out->dir_z), i, rows->dir_x, rows->dir_y, rows->dir_z);
      rows->pdf[i] = i % 11 == 3 ? 0.0f : 1.0f;
      rows->from[i] = i % 11 == 3 ? 0xFFFFFFFFu : i;
    }
    strategy->EvaluateEscaped(hits.Points(), kRows, 3, rows);
    std::uint32_t apart = 0;
    for (std::uint32_t i = 0; i < kRows; ++i) {
      if (i % 11 == 3) continue;
      apart += std::fabs(rows->light_pdf[i] - out->pdf[i]) > 1e-3f * out->pdf[i];
    }
    // A few directions lie on the border of two texels.
    EXPECT_LE(apart, kRows / 500) << material.name;
  }
}

}  // namespace
}  // namespace skywave
