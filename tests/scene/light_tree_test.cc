// Tests the tree of local lights: every light keeps a share, what is drawn is what is said, and
// what a surface gets decides.
#include "scene/light_tree.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <vector>

#include "scene/geometry.h"
#include "scene/local_lights.h"
#include "tests/support/random_rows.h"
#include "tests/support/render_scenes.h"
#include "tests/support/statistics.h"
#include "tests/support/targets.h"

namespace skywave {
namespace {

constexpr std::uint32_t kPoints = 48;

// Lamps of one and of two sides all about, points, spots and a distant light.
Scene ManyLights() {
  Scene scene;
  AddLambert(scene, "wall", glm::vec3(0.5f));
  Material sheet = scene.materials[0];
  sheet.bsdf = BsdfKind::kDiffuseTransmission;
  scene.materials.push_back(sheet);
  Random random(3);
  const auto point = [&] {
    return glm::vec3(random.Between(-4, 4), random.Between(-4, 4), random.Between(-4, 4));
  };
  for (int i = 0; i < 60; ++i) {
    const std::uint32_t lamp = AddLambert(scene, "lamp" + std::to_string(i), glm::vec3(0.5f));
    scene.materials[lamp].emission = glm::vec3(random.Between(0.1f, 5));
    scene.materials[lamp].emits_on_both_sides = i % 3 == 0;
    Mesh mesh;
    const glm::vec3 at = point();
    mesh.positions = {at, at + 0.1f * point(), at + 0.1f * point()};
    mesh.triangles = {{0, 1, 2}};
    mesh.material = lamp;
    scene.meshes.push_back(std::move(mesh));
  }
  for (int i = 0; i < 20; ++i) {
    scene.lights.push_back({.emission = glm::vec3(random.Between(0.1f, 2)), .position = point()});
    scene.lights.push_back({.kind = LocalLightKind::kSpot,
                            .emission = glm::vec3(random.Between(0.1f, 9)),
                            .position = point(),
                            .direction = glm::normalize(point()),
                            .cos_full = 0.95f,
                            .cos_dark = 0.8f});
  }
  scene.lights.push_back({.kind = LocalLightKind::kDistant,
                          .emission = glm::vec3(0.05f),
                          .direction = glm::normalize(glm::vec3(1, 2, 3))});
  return scene;
}

void PutSurface(Vec org, Vec normal, std::uint32_t material, std::uint32_t i,
                const SurfaceColumns& surfaces) {
  Put(org, i, surfaces.org_x, surfaces.org_y, surfaces.org_z);
  Put(normal, i, surfaces.ng_x, surfaces.ng_y, surfaces.ng_z);
  Put(normal, i, surfaces.ns_x, surfaces.ns_y, surfaces.ns_z);
  surfaces.lift[i] = 0;
  surfaces.material[i] = material;
}

class LightTrees : public testing::Test {
 protected:
  LightTrees()
      : scene_(ManyLights()),
        geometry_(scene_, "test", 1),
        lights_(scene_, geometry_, "test", 8, 1),
        tree_(lights_, scene_),
        tree_view_(tree_.view()),
        view_(lights_.view()),
        surfaces_(kPoints) {
    view_.tree = &tree_view_;
    Random random(5);
    for (std::uint32_t i = 0; i < kPoints; ++i) {
      const Vec org = {random.Between(-5, 5), random.Between(-5, 5), random.Between(-5, 5)};
      const Vec normal = Unit({random.Between(-1, 1), random.Between(-1, 1), 0.1});
      const std::uint32_t wall_or_sheet = i % 2 | (i % 3 == 0 ? kBackFace : 0);
      PutSurface(org, normal, wall_or_sheet, i, surfaces_);
    }
  }

  LightChoice choice(const LightChoice& whole) const {
    return {whole.first, whole.share, &tree_view_};
  }

  // The light and the density of light samples of every surface by uniform `u`, the middle of a
  // unit.
  struct Drawn {
    std::vector<int> light;
    std::vector<Vec> value, dir;
    std::vector<float> pdf;
  };
  Drawn DrawAll(const LightChoice& of, float u, float v) const {
    soa::Table<UniformColumns> uniforms(kPoints);
    std::fill_n(uniforms->u, kPoints, u);
    std::fill_n(uniforms->v, kPoints, v);
    return DrawAll(of, uniforms);
  }
  Drawn DrawAll(const LightChoice& of, const soa::Table<UniformColumns>& uniforms) const {
    soa::Table<LightColumns> out(kPoints);
    const soa::Table<ReachColumns> reach(kPoints);
    SampleLocalLights(view_, of, surfaces_, uniforms, kPoints, 1, out, reach);
    Drawn drawn;
    for (std::uint32_t i = 0; i < kPoints; ++i) {
      drawn.light.push_back(int(reach->light[i]));
      drawn.value.push_back(Get(i, out->r, out->g, out->b));
      drawn.dir.push_back(Get(i, out->dir_x, out->dir_y, out->dir_z));
      drawn.pdf.push_back(out->pdf[i]);
    }
    return drawn;
  }

  // The probability of light `index` at surface `row`, by what a ray reads that hits its triangle
  // head-on from a distance of 1.
  std::vector<double> Probabilities(std::uint32_t row) const {
    std::vector<double> found(view_.count, 0.0);
    soa::Table<RayColumns> rays(1);
    soa::Table<HitColumns> hits(1);
    soa::Table<EscapeColumns> seen(1);
    for (std::uint32_t i = 0; i < view_.count; ++i) {
      const LocalLight& light = view_.lights[i];
      if (light.kind != LocalLightKind::kTriangle) continue;
      const Vec normal = Unit(Cross(Vec{light.axis[0], light.axis[1], light.axis[2]},
                                    Vec{light.edge[0], light.edge[1], light.edge[2]}));
      Put(normal, 0, hits->ng_x, hits->ng_y, hits->ng_z);
      Put(-1 * normal, 0, rays->dir_x, rays->dir_y, rays->dir_z);
      rays->t_far[0] = 1, rays->pdf[0] = 1, rays->from[0] = row;
      hits->geom[0] = 0, hits->triangle[0] = light.triangle;
      EXPECT_EQ(IntersectEmitters(view_, choice(view_.alone), rays, hits, 1, 1, surfaces_, seen),
                1u);
      found[i] = double(seen->light_pdf[0]) * light.area;
    }
    return found;
  }

  Scene scene_;
  Geometry geometry_;
  LocalLights lights_;
  LightTree tree_;
  LightTreeView tree_view_;
  LocalLightView view_;
  soa::Table<SurfaceColumns> surfaces_;
};

TEST_F(LightTrees, EveryLightIsALeafOnItsWay) {
  for (std::uint32_t i = 0; i < view_.count; ++i) {
    std::uint32_t at = 0, depth = 0;
    while ((tree_.nodes()[at].count & kLightNodeCount) > 1) {
      at = tree_.nodes()[at].first + (tree_view_.way[i] >> depth++ & 1);
    }
    EXPECT_EQ(tree_.nodes()[at].first, i);
  }
  EXPECT_EQ(tree_.nodes().size(), 2 * std::size_t(view_.count) - 1);
  EXPECT_NEAR(tree_.nodes()[0].intensity, 1, 1e-6);
}

// What rays read is how often samples go to a light, of all lights and beside a map, and a light
// that a surface has nothing from is hardly drawn.
TEST_F(LightTrees, PicksFollowTheProbabilityThatHitsRead) {
  ForEachTarget([&] {
    constexpr int kDraws = 1 << 13;
    std::vector<std::vector<std::uint64_t>> counts(kPoints,
                                                   std::vector<std::uint64_t>(view_.count + 1));
    for (int k = 0; k < kDraws; ++k) {
      const Drawn drawn = DrawAll(choice(view_.alone), (float(k) + 0.5f) / kDraws, 0.5f);
      for (std::uint32_t i = 0; i < kPoints; ++i) {
        ASSERT_GE(drawn.light[i], 0);
        ++counts[i][std::size_t(drawn.light[i])];
      }
    }
    for (std::uint32_t row = 0; row < kPoints; ++row) {
      const std::vector<double> probability = Probabilities(row);
      for (std::uint32_t i = 0; i < view_.count; ++i) {
        if (view_.lights[i].kind != LocalLightKind::kTriangle) continue;
        // Even steps meet an interval within one step.
        ASSERT_NEAR(double(counts[row][i]), kDraws * probability[i], 1.01) << row << ", " << i;
        ASSERT_GT(probability[i], 0.9 / kChoiceUnits);
      }
    }
  });
}

TEST_F(LightTrees, BesideAMapTheirShareIsThatOfThePower) {
  const float share = view_.shared.share;
  ASSERT_GT(share, 0.05f);
  ASSERT_LT(share, 1);
  const float unit = 1.0f / float(kChoiceUnits);
  for (const int light : DrawAll(choice(view_.shared), share - unit, 0.5f).light) {
    EXPECT_GE(light, 0);
  }
  for (const int light : DrawAll(choice(view_.shared), share, 0.5f).light) EXPECT_EQ(light, -1);
}

// The mean of light samples is the irradiance of all lights without the tree, for both sides of a
// sheet. No light that shines on a surface is taken for dark, which would be seen as noise.
TEST_F(LightTrees, SamplesGiveTheLightOfAll) {
  constexpr int kDraws = 1 << 14;
  std::vector<double> by_tree(kPoints), by_power(kPoints), square(kPoints),
      square_by_power(kPoints);
  const auto gather = [&](const LightChoice& of, std::vector<double>& sum,
                          std::vector<double>& squares) {
    Random random(17);
    soa::Table<UniformColumns> uniforms(kPoints);
    for (int k = 0; k < kDraws; ++k) {
      for (std::uint32_t i = 0; i < kPoints; ++i) {
        uniforms->u[i] = random.Between(0, 1), uniforms->v[i] = random.Between(0, 1);
      }
      const Drawn drawn = DrawAll(of, uniforms);
      for (std::uint32_t i = 0; i < kPoints; ++i) {
        if (!(drawn.pdf[i] > 0)) continue;
        double cosine =
            Dot(drawn.dir[i], Get(i, surfaces_->ns_x, surfaces_->ns_y, surfaces_->ns_z));
        cosine = i % 2 == 1 ? std::abs(cosine) : std::max(cosine, 0.0);
        const double density = drawn.pdf[i] == kPunctual ? 1 : double(drawn.pdf[i]);
        const double value = drawn.value[i].y * cosine / density / kDraws;
        sum[i] += value, squares[i] += value * value;
      }
    }
  };
  gather(choice(view_.alone), by_tree, square);
  gather(view_.alone, by_power, square_by_power);
  double tree_noise = 0, power_noise = 0;
  for (std::uint32_t i = 0; i < kPoints; ++i) {
    const double deviation = std::sqrt(square[i] + square_by_power[i]);
    EXPECT_NEAR(by_tree[i], by_power[i], 4.5 * deviation) << i;
    tree_noise += square[i] / (by_power[i] * by_power[i]);
    power_noise += square_by_power[i] / (by_power[i] * by_power[i]);
  }
  EXPECT_LT(tree_noise, 2 * power_noise);
}

// Under a ceiling of 1600 lamps a surface draws those above it: the variance of a light sample is
// at most a fifth of that by power.
TEST(LightTree, SurfacesDrawTheLampsThatAreNear) {
  Scene scene;
  Place(scene, Quad(1), AddLambert(scene, "floor", glm::vec3(0.5f)), glm::vec3(0));
  for (int k = 0; k < 1600; ++k) {
    const int i = 707 * k % 1600;  // in no order
    scene.lights.push_back({.emission = glm::vec3(1), .position = {i % 40, 1.3f, i / 40}});
  }
  const Geometry geometry(scene, "test", 1);
  const LocalLights lights(scene, geometry, "test", 1, 0);
  const LightTree tree(lights, scene);
  const LightTreeView tree_view = tree.view();
  const LocalLightView view = lights.view();
  soa::Table<SurfaceColumns> surfaces(kPoints);
  Random random(7);
  for (std::uint32_t i = 0; i < kPoints; ++i) {
    PutSurface({random.Between(5, 35), 0, random.Between(5, 35)}, {0, 1, 0}, 0, i, surfaces);
  }
  double noise[2] = {};
  for (const bool by_tree : {false, true}) {
    LightChoice choice = view.alone;
    if (by_tree) choice.tree = &tree_view;
    constexpr int kDraws = 4096;
    std::vector<double> sum(kPoints), squares(kPoints);
    for (int k = 0; k < kDraws; ++k) {
      soa::Table<UniformColumns> uniforms(kPoints);
      for (std::uint32_t i = 0; i < kPoints; ++i) uniforms->u[i] = random.Between(0, 1);
      soa::Table<LightColumns> out(kPoints);
      const soa::Table<ReachColumns> reach(kPoints);
      SampleLocalLights(view, choice, surfaces, uniforms, kPoints, 1, out, reach);
      for (std::uint32_t i = 0; i < kPoints; ++i) {
        const double value = double(out->r[i]) * double(out->dir_y[i]);
        sum[i] += value, squares[i] += value * value;
      }
    }
    for (std::uint32_t i = 0; i < kPoints; ++i) {
      noise[int(by_tree)] += kDraws * squares[i] / (sum[i] * sum[i]) - 1;
    }
  }
  EXPECT_LT(noise[1], 0.2 * noise[0]);
}

TEST(LightTree, LightsAtOnePlaceAreDividedAllTheSame) {
  Scene scene;
  Place(scene, Quad(1), AddLambert(scene, "floor", glm::vec3(0.5f)), glm::vec3(0));
  scene.lights.assign(3000, {.emission = glm::vec3(1), .position = {0, 1, 0}});
  const Geometry geometry(scene, "test", 1);
  const LocalLights lights(scene, geometry, "test", 1, 0);
  const LightTree tree(lights, scene);
  EXPECT_EQ(tree.nodes().size(), 5999u);
}

}  // namespace
}  // namespace skywave
