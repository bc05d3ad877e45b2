// Compares sampling and intersection of local lights with references in double.
#include "kernels/lights/local_lights.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <memory>
#include <vector>

#include "scene/local_lights.h"
#include "tests/support/random_rows.h"
#include "tests/support/render_scenes.h"
#include "tests/support/statistics.h"
#include "tests/support/targets.h"

namespace skywave {
namespace {

constexpr float kInfinity = std::numeric_limits<float>::infinity();

// Returns one light of every kind and a mesh of three triangles, one of them without area; each
// light has a different colour. The last mesh is two-sided; the first does not emit.
Scene LitScene() {
  Scene scene;
  const std::uint32_t dark = AddLambert(scene, "dark", glm::vec3(0.5f));
  const std::uint32_t one = AddLambert(scene, "one", glm::vec3(0.5f));
  const std::uint32_t both = AddLambert(scene, "both", glm::vec3(0.5f));
  scene.materials[one].emission = {3, 1, 2};
  scene.materials[both].emission = {1, 7, 0.5f};
  scene.materials[both].emits_on_both_sides = true;
  const auto add = [&](std::uint32_t material, std::vector<glm::vec3> positions,
                       std::vector<glm::uvec3> triangles) {
    Mesh mesh;
    mesh.positions = std::move(positions), mesh.triangles = std::move(triangles);
    mesh.material = material;
    scene.meshes.push_back(std::move(mesh));
  };
  add(dark, {{-9, -9, 0}, {9, -9, 0}, {0, 9, 0}}, {{0, 1, 2}});
  add(one, {{-1, 0, 3}, {1, 0, 3}, {0, 2, 3.5f}, {3, 0, 3}}, {{0, 1, 2}, {0, 1, 3}});
  add(both, {{4, 0, 1}, {5, 1, 1}, {4, 1, 3}}, {{0, 1, 2}});
  scene.lights = {{.kind = LocalLightKind::kPoint, .emission = {5, 4, 3}, .position = {1, 2, 4}},
                  {.kind = LocalLightKind::kSpot,
                   .emission = {90, 70, 80},
                   .position = {-2, 1, 5},
                   .direction = glm::normalize(glm::vec3(0.4f, 0.1f, -1)),
                   .cos_full = 0.95f,
                   .cos_dark = 0.7f},
                  {.kind = LocalLightKind::kDistant,
                   .emission = {0.2f, 0.3f, 0.1f},
                   .direction = glm::normalize(glm::vec3(1, 2, 3))}};
  return scene;
}

class LocalLightKernels : public testing::Test {
 protected:
  LocalLightKernels()
      : scene_(LitScene()),
        geometry_(scene_, "test", 1),
        lights_(scene_, geometry_, "test", 2, 0),
        view_(lights_.view()) {}

  std::uint32_t UnitOf(float u) const { return std::uint32_t(u * float(kChoiceUnits)); }
  std::uint32_t LightAt(std::uint32_t unit) const {
    std::uint32_t light = 0;
    while (view_.alone.first[light + 1] <= unit) ++light;
    return light;
  }
  double Probability(std::uint32_t light) const {
    return double(view_.alone.first[light + 1] - view_.alone.first[light]) / kChoiceUnits;
  }

  Scene scene_;
  Geometry geometry_;
  LocalLights lights_;
  LocalLightView view_;
};

Vec Of(const float* v) { return {v[0], v[1], v[2]}; }

soa::Table<SurfaceColumns> RandomSurfaces(std::uint32_t n, std::uint32_t seed) {
  soa::Table<SurfaceColumns> surfaces(n);
  Random random(seed);
  for (std::uint32_t i = 0; i < n; ++i) {
    Put({random.Between(-2, 2), random.Between(-2, 2), random.Between(0, 2)}, i, surfaces->org_x,
        surfaces->org_y, surfaces->org_z);
  }
  return surfaces;
}

TEST_F(LocalLightKernels, AChoiceFollowsPowerToAUnit) {
  ASSERT_EQ(view_.count, 5u);  // two of the three emitting triangles have an area
  EXPECT_EQ(view_.alone.first[0], 0u);
  EXPECT_EQ(view_.alone.first[view_.count], kChoiceUnits);
  EXPECT_EQ(view_.alone.share, 1);
  // The power of each kind is computed by hand; `radius` is 2.
  const double lum_one = 0.2125 * 3 + 0.7154 + 0.0721 * 2, lum_both = 0.2125 + 7 * 0.7154 + 0.03605;
  const double area_one = 0.5 * 2 * std::sqrt(4.25),
               area_both = 0.5 * Length(Cross({1, 1, 0}, {0, 1, 2}));
  const double spot = 2 * kPi * (0.05 + 0.125);
  const double power[] = {4 * kPi * (0.2125 * 5 + 0.7154 * 4 + 0.0721 * 3),
                          spot * (0.2125 * 90 + 0.7154 * 70 + 0.0721 * 80),
                          4 * kPi * (0.2125 * 0.2 + 0.7154 * 0.3 + 0.0721 * 0.1),
                          kPi * area_one * lum_one, 2 * kPi * area_both * lum_both};
  double total = 0;
  for (const double p : power) total += p;
  for (std::uint32_t i = 0; i < view_.count; ++i) {
    EXPECT_NEAR(Probability(i), power[i] / total, 1e-6) << i;
  }
  EXPECT_EQ(lights_.totals()[0].count, 2u);
  EXPECT_NEAR(lights_.totals()[1].power, power[0], 1e-5 * power[0]);
}

TEST_F(LocalLightKernels, SharesWithTheMapByPowerWithinBounds) {
  double power = 0;
  for (const LocalLightTotal& total : lights_.totals()) power += total.power;
  for (const auto& [environment, share] :
       {std::pair{3 * power, 0.25}, std::pair{1e9 * power, 1.0 / 16},
        std::pair{1e-9 * power, 15.0 / 16}}) {
    const LocalLights lights(scene_, geometry_, "test", 2, environment);
    const LocalLightView view = lights.view();
    EXPECT_NEAR(view.shared.share, share, 1e-6);
    EXPECT_EQ(view.shared.share, float(view.shared.first[view.count]) / float(kChoiceUnits));
    EXPECT_EQ(view.alone.share, 1);
  }
}

TEST(LocalLightTables, DimLightsAmongManyAreStillPicked) {
  Scene scene;
  const std::uint32_t lamp = AddLambert(scene, "lamp", glm::vec3(0.5f));
  scene.materials[lamp].emission = glm::vec3(1e-12f);
  Place(scene, Sphere(1, 8), lamp, glm::vec3(0));
  scene.lights = {{.emission = glm::vec3(1e9f)}};
  const Geometry geometry(scene, "test", 1);
  const LocalLights lights(scene, geometry, "test", 1, 1);
  const LocalLightView view = lights.view();
  ASSERT_EQ(view.count, 1 + geometry.triangle_count());
  for (const LightChoice& choice : {view.alone, view.shared}) {
    for (std::uint32_t i = 0; i < view.count; ++i) {
      ASSERT_LT(choice.first[i], choice.first[i + 1]) << i;
    }
  }
}

TEST(LocalLightTables, ASceneWithoutLocalLightsHasNoTable) {
  Scene scene;
  Place(scene, Quad(1), AddLambert(scene, "dark", glm::vec3(0.5f)), glm::vec3(0));
  EXPECT_FALSE(HasLocalLights(scene));
  const LocalLights lights(scene, Geometry(scene, "test", 1), "test", 1, 1);
  EXPECT_EQ(lights.view().count, 0u);
  EXPECT_EQ(lights.view().light_of_triangle, nullptr);
  EXPECT_EQ(lights.bytes(), 0u);
}

// The square's texture is red in the lower left half and black elsewhere.
TEST(LocalLightTables, MeanOfTheTextureIsTheirPower) {
  constexpr int kSide = 64;
  Scene scene;
  Image image(kSide, kSide);
  for (int y = 0; y < kSide; ++y) {
    for (int x = 0; x < kSide; ++x) image.Pixel(x, y)[0] = x < y ? 0.8f : 0.0f;
  }
  scene.images = {image};
  scene.textures = {{.image = 0}};
  const std::uint32_t lamp = AddLambert(scene, "lamp", glm::vec3(0.5f));
  scene.materials[lamp].emission = {2, 1, 1};
  scene.materials[lamp].emission_texture = 0;
  Mesh mesh;
  mesh.uvs = {{0, 0}, {1, 0}, {1, 1}, {0, 1}, {0.5f, 0.1f}, {0.9f, 0.1f}, {0.9f, 0.4f}};
  for (const glm::vec2& uv : mesh.uvs) mesh.positions.push_back({uv.x, uv.y, 0});
  mesh.triangles = {{4, 5, 6}, {0, 2, 3}, {0, 1, 3}, {0, 1, 2}};
  mesh.material = lamp;
  scene.meshes = {mesh};
  const Geometry geometry(scene, "test", 1);
  const LocalLights lights(scene, geometry, "test", 1, 0);
  const LocalLightView view = lights.view();
  // The first triangle lies in the black half, so it is not a light. The last one touches the edge
  // of the bright half, so it must be a light, however dim.
  ASSERT_EQ(view.count, 3u);
  EXPECT_EQ(view.light_of_triangle[0], kNoLight);
  for (std::uint32_t i = 0; i < 3; ++i) {
    EXPECT_EQ(view.light_of_triangle[i + 1], i);
    EXPECT_EQ(view.emission_texture[i], 1u);
    EXPECT_EQ(view.lights[i].emission[0], 2);
  }
  // Coordinates beyond the unit square wrap around: the same triangle stays dark.
  for (const float turns : {3.0f, -2.0f}) {
    Scene beyond = scene;
    for (glm::vec2& uv : beyond.meshes[0].uvs) uv += turns;
    const Geometry moved(beyond, "test", 1);
    EXPECT_EQ(LocalLights(beyond, moved, "test", 1, 0).view().count, 3u) << turns;
  }
  const auto units = [&](std::uint32_t i) {
    return double(view.alone.first[i + 1]) - view.alone.first[i];
  };
  EXPECT_NEAR(units(1) / units(0), 0.5, 0.02);
  EXPECT_LT(units(2), 0.02 * units(0));
  EXPECT_GE(lights.brightest(), 1.6f);
}

// The first and the last uniform of every light select it, and none is selected beyond the choice's
// share.
TEST_F(LocalLightKernels, UniformsAtTheEndsOfALightPickIt) {
  std::vector<std::uint32_t> first(view_.alone.first, view_.alone.first + view_.count + 1);
  for (std::uint32_t& f : first) f = f / 2 + (&f - first.data());  // a share of about a half
  const LightChoice choice = {first.data(), float(first.back()) / float(kChoiceUnits)};
  ForEachTarget([&] {
    for (std::uint32_t light = 0; light < view_.count; ++light) {
      soa::Table<UniformColumns> uniforms(3);
      const std::uint32_t units[] = {first[light], first[light + 1] - 1, first[view_.count]};
      for (int i = 0; i < 3; ++i) {
        uniforms->u[i] = float(units[i]) / float(kChoiceUnits), uniforms->v[i] = 0.5f;
      }
      const auto surfaces = RandomSurfaces(3, 5);
      soa::Table<LightColumns> out(3);
      const soa::Table<ReachColumns> reach(3);
      for (std::uint32_t i = 0; i < 3; ++i) out->r[i] = -1, out->g[i] = 2;
      SampleLocalLights(view_, choice, surfaces, uniforms, 3, 1, out, reach);
      const float* emission = view_.lights[light].emission;
      for (int i = 0; i < 2; ++i) {
        EXPECT_NEAR(out->r[i] * emission[1], out->g[i] * emission[0],
                    1e-5f * std::abs(out->r[i] * emission[1]))
            << light;
        EXPECT_NE(out->r[i], -1) << light;
      }
      EXPECT_EQ(out->r[2], -1);
      EXPECT_EQ(reach->distance[2], kInfinity);
      EXPECT_EQ(reach->light[0], float(light));
      EXPECT_EQ(reach->light[1], float(light));
      EXPECT_EQ(reach->light[2], -1);
    }
  });
}

TEST_F(LocalLightKernels, SamplesMatchTheReference) {
  constexpr double kSamples = 3;
  ForEachTarget([&] {
    for (const std::uint32_t n : kRowCounts) {
      const auto surfaces = RandomSurfaces(n, 11);
      const auto uniforms = RandomUniforms(n, 12);
      soa::Table<LightColumns> out(n);
      const soa::Table<ReachColumns> reach(n);
      SampleLocalLights(view_, view_.alone, surfaces, uniforms, n, float(kSamples), out, reach);
      for (std::uint32_t i = 0; i < n; ++i) {
        const std::uint32_t unit = UnitOf(uniforms->u[i]), index = LightAt(unit);
        const LocalLight& light = view_.lights[index];
        const double probability = kSamples * Probability(index);
        const Vec org = Get(i, surfaces->org_x, surfaces->org_y, surfaces->org_z);
        const Vec dir = Get(i, out->dir_x, out->dir_y, out->dir_z);
        Vec at = Of(light.position);
        double pdf = kInfinity, worth = 1 / probability, own = 0, grazing = 1;
        if (light.kind == LocalLightKind::kTriangle) {
          const double x = (unit - view_.alone.first[index] + 0.5) /
                           (view_.alone.first[index + 1] - view_.alone.first[index]);
          const double root = std::sqrt(x), y = uniforms->v[i];
          at = at + (1 - root) * Of(light.axis) + (y * root) * Of(light.edge);
          const Vec way = at - org, cross = Cross(Of(light.axis), Of(light.edge));
          double cosine = -Dot(Unit(cross), Unit(way));
          if (light.two_sided) cosine = std::abs(cosine);
          pdf = cosine > 0 ? probability * Dot(way, way) / (0.5 * Length(cross) * cosine) : 0;
          worth = 1;
          own = Lift(LargestCoordinate(at), Of(light.axis), Of(light.edge));
          grazing = std::max(cosine, 1.0 / 256);
        }
        const double distance = Length(at - org);
        if (light.kind == LocalLightKind::kPoint) worth /= distance * distance;
        if (light.kind == LocalLightKind::kSpot) {
          const double cosine = -Dot(Unit(at - org), Of(light.axis));
          const double t = std::clamp((cosine - 0.7) / 0.25, 0.0, 1.0);
          worth *= t * t * (3 - 2 * t) / (distance * distance);
        }
        const bool distant = light.kind == LocalLightKind::kDistant;
        const Vec expected = distant ? Of(light.axis) : Unit(at - org);
        ASSERT_LT(Length(dir - expected), 1e-5) << i;
        if (std::isinf(pdf)) {
          ASSERT_EQ(out->pdf[i], kPunctual) << i;
        } else {
          ASSERT_NEAR(out->pdf[i], pdf, 1e-4 * pdf) << i;
        }
        const float rgb[3] = {out->r[i], out->g[i], out->b[i]};
        for (int c = 0; c < 3; ++c) {
          const double value = worth * light.emission[c];
          ASSERT_NEAR(rgb[c], value, 1e-4 * value + 1e-6) << i;
        }
        if (distant) {
          ASSERT_EQ(reach->distance[i], kInfinity);
        } else {
          const double short_of = (own + distance * 0x1p-19) / grazing + 2 * surfaces->lift[i];
          ASSERT_NEAR(reach->distance[i], distance - short_of, 3e-7 * distance + 1e-3 * short_of)
              << i;
        }
      }
    }
  });
}

TEST_F(LocalLightKernels, SamplesAreTheSameOnEveryTarget) {
  const auto surfaces = RandomSurfaces(kFullWave, 21);
  const auto uniforms = RandomUniforms(kFullWave, 22);
  ExpectSameOnEveryTarget([&] {
    soa::Table<LightColumns> out(kFullWave);
    const soa::Table<ReachColumns> reach(kFullWave);
    SampleLocalLights(view_, view_.alone, surfaces, uniforms, kFullWave, 2, out, reach);
    return ColumnBits(out.columns(), kFullWave);
  });
}

// A scene of one triangle, with all surfaces at one point.
struct OneTriangle {
  OneTriangle(bool two_sided) {
    const std::uint32_t lamp = AddLambert(scene, "lamp", glm::vec3(0.5f));
    scene.materials[lamp].emission = {3, 1, 2};
    scene.materials[lamp].emits_on_both_sides = two_sided;
    Mesh mesh;
    mesh.positions = {{0.2f, -0.5f, 1}, {1.3f, 0.1f, 1.4f}, {-0.4f, 1.1f, 0.8f}};
    mesh.triangles = {{0, 2, 1}};  // emits downwards
    mesh.material = lamp;
    scene.meshes = {mesh};
    geometry = std::make_unique<Geometry>(scene, "test", 1);
    lights = LocalLights(scene, *geometry, "test", 1, 0);
  }
  Scene scene;
  std::unique_ptr<Geometry> geometry;
  LocalLights lights;
};

// Returns the solid angle of a triangle from the origin (Van Oosterom and Strackee 1983).
double SolidAngle(Vec a, Vec b, Vec c) {
  const double la = Length(a), lb = Length(b), lc = Length(c);
  const double over = std::abs(Dot(a, Cross(b, c)));
  return 2 * std::atan2(over, la * lb * lc + Dot(a, b) * lc + Dot(a, c) * lb + Dot(b, c) * la);
}

TEST(LocalLightDensity, InverseDensitiesSumToTheSolidAngle) {
  const OneTriangle one(false);
  const LocalLightView view = one.lights.view();
  constexpr std::uint32_t kRows = 1 << 16;
  soa::Table<SurfaceColumns> surfaces(kRows);  // all at the origin
  soa::Table<LightColumns> out(kRows);
  const soa::Table<ReachColumns> reach(kRows);
  SampleLocalLights(view, view.alone, surfaces, RandomUniforms(kRows, 3), kRows, 2, out, reach);
  Moments inverse;
  for (std::uint32_t i = 0; i < kRows; ++i) inverse.Add(2 / double(out->pdf[i]));
  const LocalLight& light = view.lights[0];
  const Vec a = Of(light.position);
  EXPECT_TRUE(AgreesWith(inverse.mean(), inverse.standard_error(),
                         SolidAngle(a, a + Of(light.axis), a + Of(light.edge)), 1e-3, 1e-5));
}

// Cells of equal area receive equal counts.
TEST(LocalLightDensity, PointsAreUniformOverTheTriangle) {
  const OneTriangle one(false);
  const LocalLightView view = one.lights.view();
  constexpr std::uint32_t kRows = 1 << 16;
  constexpr int kSide = 8;
  soa::Table<SurfaceColumns> surfaces(kRows);
  soa::Table<LightColumns> out(kRows);
  const soa::Table<ReachColumns> reach(kRows);
  SampleLocalLights(view, view.alone, surfaces, RandomUniforms(kRows, 4), kRows, 1, out, reach);
  const LocalLight& light = view.lights[0];
  const Vec p = Of(light.position), a = Of(light.axis), b = Of(light.edge), n = Cross(a, b);
  std::vector<double> counts(kSide * kSide * 2), expected(kSide * kSide * 2);
  for (int y = 0; y < kSide; ++y) {
    for (int x = 0; x < kSide; ++x) {
      for (const int upper : {0, 1}) {
        if (x + y + upper < kSide)
          expected[2 * (y * kSide + x) + upper] = double(kRows) / (kSide * kSide);
      }
    }
  }
  for (std::uint32_t i = 0; i < kRows; ++i) {
    const Vec dir = Get(i, out->dir_x, out->dir_y, out->dir_z);
    const Vec at = (Dot(p, n) / Dot(dir, n)) * dir - p;
    const double u = Dot(Cross(at, b), n) / Dot(n, n) * kSide,
                 v = Dot(Cross(a, at), n) / Dot(n, n) * kSide;
    const int x = std::clamp(int(u), 0, kSide - 1), y = std::clamp(int(v), 0, kSide - 1);
    ++counts[2 * (y * kSide + x) + (u - x + v - y > 1)];
  }
  EXPECT_TRUE(MatchesExpected(counts, expected, 1e-3, /*strays=*/5));
}

// Rays are traced along light samples: those that hit a triangle must find the density with which
// they were drawn.
TEST_F(LocalLightKernels, HitTrianglesHaveTheDensityOfTheirSamples) {
  constexpr float kSamples = 3;
  for (const std::uint32_t n : kRowCounts) {
    const auto surfaces = RandomSurfaces(n, 31);
    const auto uniforms = RandomUniforms(n, 32);
    soa::Table<LightColumns> samples(n);
    const soa::Table<ReachColumns> reach(n);
    SampleLocalLights(view_, view_.alone, surfaces, uniforms, n, kSamples, samples, reach);
    soa::Table<RayColumns> rays(n);
    soa::Table<HitColumns> hits(n);
    std::vector<std::uint32_t> expected;
    for (std::uint32_t i = 0; i < n; ++i) {
      rays->dir_x[i] = samples->dir_x[i], rays->dir_y[i] = samples->dir_y[i];
      rays->dir_z[i] = samples->dir_z[i];
      rays->throughput_r[i] = float(i), rays->throughput_g[i] = float(2 * i);
      rays->throughput_b[i] = float(3 * i);
      rays->pdf[i] = 0.5f, rays->path[i] = n - i, rays->from[i] = 7 * i;
      const std::uint32_t light = LightAt(UnitOf(uniforms->u[i]));
      hits->geom[i] = kNoHit, hits->triangle[i] = 123456789;  // stale data for a miss
      if (view_.lights[light].kind != LocalLightKind::kTriangle) continue;
      // Triangles that do not emit are hit as well.
      const bool dark = i % 3 == 0;
      hits->geom[i] = 0;
      hits->triangle[i] = dark ? 0 : light == 3 ? 1 : 3;
      const Vec cross = Cross(Of(view_.lights[light].axis), Of(view_.lights[light].edge));
      Put(cross, i, hits->ng_x, hits->ng_y, hits->ng_z);
      rays->t_far[i] = reach->distance[i];
      if (!dark && samples->pdf[i] > 0) expected.push_back(i);
    }
    ForEachTarget([&] {
      soa::Table<EscapeColumns> emitter_hits(n);
      FillWithGarbage(emitter_hits.columns(), n);
      const std::uint32_t count =
          IntersectEmitters(view_, view_.alone, rays, hits, n, kSamples, surfaces, emitter_hits);
      ASSERT_EQ(count, expected.size());
      for (std::uint32_t k = 0; k < count; ++k) {
        const std::uint32_t i = expected[k];
        ASSERT_EQ(emitter_hits->path[k], rays->path[i]);
        ASSERT_EQ(emitter_hits->from[k], rays->from[i]);
        ASSERT_EQ(emitter_hits->pdf[k], 0.5f);
        ASSERT_EQ(emitter_hits->dir_x[k], rays->dir_x[i]);
        ASSERT_EQ(emitter_hits->dir_y[k], rays->dir_y[i]);
        ASSERT_EQ(emitter_hits->dir_z[k], rays->dir_z[i]);
        ASSERT_EQ(emitter_hits->throughput_r[k], float(i));
        ASSERT_EQ(emitter_hits->throughput_g[k], float(2 * i));
        ASSERT_EQ(emitter_hits->throughput_b[k], float(3 * i));
        ASSERT_EQ(emitter_hits->radiance_r[k], samples->r[i]);
        ASSERT_EQ(emitter_hits->radiance_g[k], samples->g[i]);
        ASSERT_EQ(emitter_hits->radiance_b[k], samples->b[i]);
        ASSERT_NEAR(emitter_hits->light_pdf[k], samples->pdf[i], 1e-3 * samples->pdf[i]);
      }
    });
    if (n == kFullWave) {
      EXPECT_GT(expected.size(), 100u);
    }
  }
}

TEST(LocalLightIntersection, OneSidedTrianglesAreDarkFromBehind) {
  for (const bool two_sided : {false, true}) {
    const OneTriangle one(two_sided);
    soa::Table<RayColumns> rays(2);
    soa::Table<HitColumns> hits(2);
    for (std::uint32_t i = 0; i < 2; ++i) {
      rays->dir_z[i] = i == 0 ? 1.0f : -1.0f;  // first from below, then from above
      rays->t_far[i] = 1;
      hits->ng_x[i] = 0, hits->ng_y[i] = 0, hits->ng_z[i] = -1;
    }
    soa::Table<EscapeColumns> emitter_hits(2);
    const LocalLightView view = one.lights.view();
    EXPECT_EQ(IntersectEmitters(view, view.alone, rays, hits, 2, 1, {}, emitter_hits),
              two_sided ? 2u : 1u);
    EXPECT_EQ(emitter_hits->dir_z[0], 1);
  }
}

}  // namespace
}  // namespace skywave
