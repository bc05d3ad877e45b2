// Compares every kernel that draws light samples with the same sampling in scalar double
// arithmetic, row by row: the texel or light that a uniform selects, the direction inside it,
// radiance and density.

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <functional>

#include "kernels/bsdf/product.h"
#include "kernels/bsdf/resampling.h"
#include "kernels/lights/directional.h"
#include "kernels/lights/texel_samplers.h"
#include "lights/light_sets/directional_lights.h"
#include "lights/strategies/strategy.h"
#include "lights/tables/cell_sampler.h"
#include "lights/tables/inversion_table.h"
#include "lights/tables/texels.h"
#include "tests/support/adversarial_maps.h"
#include "tests/support/shade_points.h"
#include "tests/support/shading_rows.h"
#include "tests/support/targets.h"

namespace skywave {
namespace {

constexpr std::uint32_t kRows = 3000;
constexpr float kSamples = 3;  // densities include this number of samples

const EnvironmentMap& Map() {
  static const EnvironmentMap map = {AdversarialMap("Noise"), Orientations()[1].map_from_world};
  return map;
}
std::vector<double> Importance(const Image& light) {
  std::vector<double> importance;
  for (int y = 0; y < light.height; ++y) {
    for (int x = 0; x < light.width; ++x) {
      importance.push_back(Luminance(light.Pixel(x, y)) *
                           RowSolidAngle(light.width, light.height, y));
    }
  }
  return importance;
}

// Returns the item of a tree at position x in [0, 1); x receives the position within the item.
std::uint32_t WalkTree(const SearchTreeView& view, std::uint32_t tree, double& x) {
  std::uint32_t item = 0;
  for (std::uint32_t level = 0; level < view.levels; ++level) {
    const SearchNode& node = view.level[level][tree * view.nodes[level] + item];
    std::uint32_t child = kNodeFan - 1;
    while (node.start[child] > x * kNodeMass) --child;
    const double end = child + 1 < kNodeFan ? node.start[child + 1] : int(kNodeMass);
    x = (x * kNodeMass - node.start[child]) / (end - node.start[child]);
    item = item * kNodeFan + child;
  }
  return item;
}

struct Drawn {
  int column, row;
  double fx, fy, pdf;
};

// Compares rows of `out` with draw(u, v). A uniform within rounding of a border may fall on either
// side of it; such rows are few.
void ExpectDrawn(const std::function<void(const UniformColumns&, const LightColumns&)>& kernel,
                 const std::function<Drawn(double u, double v)>& draw, double rounding) {
  const Image held = HeldMap(Map());
  const auto uniforms = RandomUniforms(kRows, 5);
  ForEachTarget([&] {
    soa::Table<LightColumns> out(kRows);
    kernel(uniforms, out);
    std::uint32_t elsewhere = 0;
    for (std::uint32_t i = 0; i < kRows; ++i) {
      const Drawn d = draw(uniforms->u[i], uniforms->v[i]);
      const double top = std::cos(kPi * d.row / held.height);
      const double bottom = std::cos(kPi * (d.row + 1) / held.height);
      const double v = std::acos(std::clamp(top + d.fy * (bottom - top), -1.0, 1.0)) / kPi;
      const Vec direction = WorldDirection(Map().map_from_world, (d.column + d.fx) / held.width, v);
      const float* texel = held.Pixel(d.column, d.row);
      const bool same = Angle(Get(i, out->dir_x, out->dir_y, out->dir_z), direction) < rounding &&
                        std::fabs(out->pdf[i] / d.pdf - 1) < 1e-5 && out->r[i] == texel[0] &&
                        out->g[i] == texel[1] && out->b[i] == texel[2];
      elsewhere += !same;
    }
    EXPECT_LE(elsewhere, kRows / 200);
  });
}

TEST(SamplingReference, Inversion) {
  Texels texels(Map());
  const Image held = texels.Held();
  const InversionTable table(texels, 0);
  const InversionView view = table.view();
  const auto probability = [&](const SearchTreeView& trees, std::uint32_t tree,
                               std::uint32_t item) {
    double p = 1;
    for (std::uint32_t level = trees.levels; level-- > 0; item /= kNodeFan) {
      const SearchNode& node = trees.level[level][tree * trees.nodes[level] + item / kNodeFan];
      const std::uint32_t k = item % kNodeFan;
      p *= ((k + 1 < kNodeFan ? node.start[k + 1] : int(kNodeMass)) - node.start[k]) /
           double(kNodeMass);
    }
    return p;
  };
  ExpectDrawn(
      [&](const UniformColumns& uniforms, const LightColumns& out) {
        SampleTexels(texels.view(), view, uniforms, kRows, kSamples, out);
      },
      [&](double u, double v) {
        const std::uint32_t row = WalkTree(view.rows, 0, v);
        const std::uint32_t line = WalkTree(view.lines, row, u);
        const int first = int(line * kLineTexels);
        const int end = std::min(first + int(kLineTexels), held.width);
        const auto weight = [&](int x) { return Luminance(held.Pixel(x, int(row))); };
        double total = 0;
        for (int x = first; x < end; ++x) total += weight(x);
        int column = first;
        for (u *= total; u >= weight(column); ++column) u -= weight(column);
        const double p = probability(view.rows, 0, row) * probability(view.lines, row, line) *
                         weight(column) / total;
        return Drawn{column, int(row), u / weight(column), v,
                     kSamples * p / RowSolidAngle(held.width, held.height, int(row))};
      },
      3e-4);
}

// The test uses the pyramid of the reported densities: if those are right, so are the splits.
TEST(SamplingReference, Warp) {
  const auto strategy = MakeStrategy("warp", Map());
  const Image held = HeldMap(Map());
  const auto n = std::uint32_t(held.width * held.height);
  const soa::Table<SurfaceColumns> surfaces(1);
  soa::Table<EscapeColumns> centres(n);
  for (std::uint32_t i = 0; i < n; ++i) {
    Put(WorldDirection(Map().map_from_world, (int(i) % held.width + 0.5) / held.width,
                       (int(i) / held.width + 0.5) / held.height),
        i, centres->dir_x, centres->dir_y, centres->dir_z);
    centres->pdf[i] = 1;
  }
  strategy->EvaluateEscaped(LambertPoints(surfaces, 1), n, 1, centres);
  const auto sum = [&](int x0, int y0, int x1, int y1) {
    double total = 0;
    for (int y = y0; y < std::min(y1, held.height); ++y) {
      for (int x = x0; x < std::min(x1, held.width); ++x) {
        total += centres->light_pdf[y * held.width + x] * RowSolidAngle(held.width, held.height, y);
      }
    }
    return total;
  };
  const auto split = [](double share, double& x) {
    const bool behind = x >= share;
    x = behind ? (x - share) / (1 - share) : x / share;
    return int(behind);
  };
  ExpectDrawn(
      [&](const UniformColumns& uniforms, const LightColumns& out) {
        strategy->Sample(LambertPoints(surfaces, 1), uniforms, kRows,
                         {.requested = std::uint32_t(kSamples)}, out);
      },
      [&](double u, double v) {
        int x = 0, y = 0, width = 1, height = 1;
        while (width < held.width) width *= 2;
        while (height < held.height) height *= 2;
        while (width > 1 || height > 1) {
          const int half_width = std::max(1, width / 2), half_height = std::max(1, height / 2);
          if (half_height < height) {
            const double whole = sum(x, y, x + width, y + height);
            y += half_height * split(sum(x, y, x + width, y + half_height) / whole, v);
          }
          if (half_width < width) {
            const double whole = sum(x, y, x + width, y + half_height);
            x += half_width * split(sum(x, y, x + half_width, y + half_height) / whole, u);
          }
          width = half_width, height = half_height;
        }
        return Drawn{x, y, u, v, kSamples * double(centres->light_pdf[y * held.width + x])};
      },
      2e-3);
}

struct Cells {
  Cells() : texels(Map()) {
    const Image held = texels.Held();
    for (int y = 0; y < held.height; ++y) {
      for (int x = 0; x < held.width; ++x) map.push_back(std::uint32_t(x / 5 + 7 * (y / 6)) % 19);
    }
    sampler.emplace(held.width, held.height, Importance(held), map, 19);
  }
  // Returns a texel of `cell` at (x, y) by its alias table; the pdf is conditional on the cell.
  Drawn InCell(std::uint32_t cell, double x, double y) const {
    const CellsView view = sampler->view();
    const std::uint32_t begin = view.begin[cell], count = view.begin[cell + 1] - begin;
    const double position = x * count;
    std::uint32_t slot = begin + std::min(std::uint32_t(position), count - 1);
    const double keep = view.slots[slot].keep, fx = position - std::floor(position);
    const bool kept = y < keep;
    const double fy = kept ? y / keep : (y - keep) / (1 - keep);
    if (!kept) slot = view.slots[slot].other;
    const std::uint32_t texel = view.texel[slot], width = texels.width();
    return {int(texel % width), int(texel / width), fx, fy,
            double(view.density[texel]) * sampler->Scale(cell)};
  }
  Texels texels;
  CellMap map;
  std::optional<CellSampler> sampler;
};

TEST(SamplingReference, PickedCells) {
  const Cells cells;
  const SearchTreeView tree = cells.sampler->tree();
  ExpectDrawn(
      [&](const UniformColumns& uniforms, const LightColumns& out) {
        SampleCells(cells.texels.view(), cells.sampler->view(), &tree, uniforms, kRows, kSamples,
                    out);
      },
      [&](double u, double v) {
        const std::uint32_t cell = WalkTree(tree, 0, u);
        Drawn d = cells.InCell(cell, u, v);
        d.pdf *= kSamples / cells.sampler->Scale(cell);
        return d;
      },
      3e-3);
}

TEST(SamplingReference, OneCell) {
  const Cells cells;
  for (const std::uint32_t cell : {0u, 7u, 18u}) {
    ExpectDrawn(
        [&](const UniformColumns& uniforms, const LightColumns& out) {
          SampleOneCell(cells.texels.view(), cells.sampler->view(), cell,
                        cells.sampler->Scale(cell), uniforms, kRows, out);
        },
        [&](double u, double v) { return cells.InCell(cell, u, v); }, 1e-3);
  }
}

TEST(SamplingReference, SphereAndCosine) {
  const auto uniforms = RandomUniforms(kRows, 6);
  soa::Table<SurfaceColumns> surfaces(kRows);
  Random random(7);
  for (std::uint32_t i = 0; i < kRows; ++i) PutSurface(random.Direction(), i, surfaces);
  ForEachTarget([&] {
    soa::Table<LightColumns> sphere(kRows), cosine(kRows);
    SampleSphere(uniforms, kRows, kSamples, sphere);
    SampleCosine(surfaces, uniforms, kRows, kSamples, cosine);
    soa::Table<EscapeColumns> escaped(kRows);
    for (std::uint32_t i = 0; i < kRows; ++i) {
      const double u = uniforms->u[i], v = uniforms->v[i];
      const double z = 1 - 2 * v, sine = std::sqrt(1 - z * z);
      ASSERT_LT(Angle(Get(i, sphere->dir_x, sphere->dir_y, sphere->dir_z),
                      {sine * std::cos(2 * kPi * u), sine * std::sin(2 * kPi * u), z}),
                1e-6);
      ASSERT_NEAR(sphere->pdf[i], kSamples / (4 * kPi), 1e-7);
      // The azimuth depends on the choice of frame, so only heights about the normal are compared.
      const Vec normal = Get(i, surfaces->ns_x, surfaces->ns_y, surfaces->ns_z);
      const Vec drawn = Get(i, cosine->dir_x, cosine->dir_y, cosine->dir_z);
      ASSERT_NEAR(Dot(normal, drawn), std::sqrt(1 - v), 1e-6);
      ASSERT_NEAR(cosine->pdf[i], kSamples * std::sqrt(1 - v) / kPi, 1e-6);
      const std::uint32_t from = (i * 7) % kRows;
      Put(drawn, i, escaped->dir_x, escaped->dir_y, escaped->dir_z);
      escaped->from[i] = from;
    }
    CosineDensity(surfaces, kRows, kSamples, escaped);
    for (std::uint32_t i = 0; i < kRows; ++i) {
      const Vec normal = Get((i * 7) % kRows, surfaces->ns_x, surfaces->ns_y, surfaces->ns_z);
      const double height = Dot(normal, Get(i, cosine->dir_x, cosine->dir_y, cosine->dir_z));
      ASSERT_NEAR(escaped->light_pdf[i], kSamples * std::max(0.0, height) / kPi, 1e-6);
    }
  });
}

std::vector<DirectionalLight> SomeLights() {
  std::vector<DirectionalLight> lights;
  Random random(8);
  for (int i = 0; i < 40; ++i) {
    const Vec d = random.Direction();
    const double power = std::pow(10, random.Between(-2, 1));
    lights.push_back({.direction = {d.x, d.y, d.z},
                      .irradiance = {power, 0.5 * power, 0.1 * power},
                      .energy = power});
  }
  return lights;
}

void ExpectLight(const LightColumns& out, std::uint32_t i, const LightRecord& light, double worth) {
  ASSERT_EQ(out.dir_x[i], light.direction[0]);
  ASSERT_EQ(out.dir_y[i], light.direction[1]);
  ASSERT_EQ(out.dir_z[i], light.direction[2]);
  ASSERT_NEAR(out.r[i], worth * light.irradiance[0], 1e-5 * worth * light.irradiance[0]);
  ASSERT_NEAR(out.g[i], worth * light.irradiance[1], 1e-5 * worth * light.irradiance[1]);
  ASSERT_NEAR(out.b[i], worth * light.irradiance[2], 1e-5 * worth * light.irradiance[2]);
  ASSERT_TRUE(std::isinf(out.pdf[i]));
}

TEST(SamplingReference, DirectionalLights) {
  const DirectionalLights lights(SomeLights(), Map().map_from_world);
  const auto uniforms = RandomUniforms(kRows, 9);
  constexpr float kShare = 0.3f;
  ForEachTarget([&] {
    soa::Table<LightColumns> one(kRows), picked(kRows), split(kRows);
    FillDirectional(lights[5], kRows, one);
    PickDirectional(lights.records(), lights.tree(), uniforms->u, kRows, kSamples, picked);
    soa::Table<UniformColumns> rest(kRows);
    SplitUniforms(uniforms->u, kRows, kShare, rest->u);
    for (std::uint32_t i = 0; i < kRows; ++i) split->pdf[i] = split->r[i] = float(i);
    PickOverSplit(lights.records(), lights.tree(), uniforms->u, kRows, kShare, kSamples, split);
    for (std::uint32_t i = 0; i < kRows; ++i) {
      ExpectLight(one, i, lights[5], 1);
      double x = uniforms->u[i];
      const LightRecord& light = lights[WalkTree(lights.tree(), 0, x)];
      ExpectLight(picked, i, light, 1 / (double(light.probability) * kSamples));
      if (uniforms->u[i] < kShare) {
        double y = uniforms->u[i] / double(kShare);
        const LightRecord& other = lights[WalkTree(lights.tree(), 0, y)];
        // This is within rounding of a border between two lights.
        if (y < 1e-4 || y > 1 - 1e-4) continue;
        ExpectLight(split, i, other, 1 / (double(other.probability) * kSamples * kShare));
      } else {
        ASSERT_NEAR(rest->u[i], (uniforms->u[i] - double(kShare)) / (1 - double(kShare)), 1e-6);
        ASSERT_EQ(split->pdf[i], float(i));
        ASSERT_EQ(split->r[i], float(i));
      }
    }
  });
}

TEST(SamplingReference, CellsAreFoundAndScaled) {
  const Cells cells;
  soa::Table<EscapeColumns> rows(kRows);
  Random random(13);
  std::vector<Vec> directions(kRows);
  for (std::uint32_t i = 0; i < kRows; ++i) {
    directions[i] = random.Direction();
    Put(directions[i], i, rows->dir_x, rows->dir_y, rows->dir_z);
  }
  ForEachTarget([&] {
    std::vector<std::uint32_t> cell(PaddedRows(kRows));
    FindCells(cells.texels.view(), cells.map.data(), kRows, rows, cell.data());
    const int width = int(cells.texels.width()), height = int(cells.texels.height());
    for (std::uint32_t i = 0; i < kRows; ++i) {
      double u, v;
      MapPosition(Map().map_from_world, directions[i], u, v);
      if (BorderDistance(width, height, u, v) < 1e-5) continue;
      ASSERT_EQ(cell[i], cells.map[std::size_t(int(v * height) * width + int(u * width))]);
    }
    soa::Table<LightColumns> t(4);
    const float weight[PaddedRows(4)] = {1, 2, 0, 3}, norm[PaddedRows(4)] = {4, 4, 4, 0};
    std::fill_n(t->pdf, 4, 8.0f);
    ScaleByPick(weight, norm, 4, t->pdf);
    EXPECT_EQ(t->pdf[0], 2);
    EXPECT_EQ(t->pdf[1], 4);
    EXPECT_EQ(t->pdf[2], 0);
    EXPECT_EQ(t->pdf[3], 0);
  });
}

}  // namespace
}  // namespace skywave
