// Compares coated surfaces with light that walks through their layers, and with figures in closed
// form.
#include "kernels/bsdf/coat_tables.h"

#include <gtest/gtest.h>

#include <cmath>
#include <limits>
#include <string>
#include <vector>

#include "kernels/bsdf/material.h"
#include "tests/support/bsdf_albedo.h"
#include "tests/support/layered_walk.h"

namespace skywave {
namespace {

MaterialCase CaseOf(const std::string& name, const Material& material) {
  return {name, material.bsdf, RecordWithCoat(material)};
}

Material Body(float reflectance, float alpha = 0, float ior = 1.5f) {
  return {.bsdf = BsdfKind::kCoatedDiffuse,
          .reflectance = glm::vec3(reflectance),
          .alpha = alpha,
          .ior = ior};
}
Material Metal(float eta, float k, float alpha, float coat_alpha = 0, float ior = 1.5f) {
  return {.bsdf = BsdfKind::kCoatedConductor,
          .reflectance = glm::vec3(1),
          .eta = glm::vec3(eta),
          .k = glm::vec3(k),
          .alpha = alpha,
          .ior = ior,
          .coat_alpha = coat_alpha};
}
Material Misty(Material material, float thickness, float albedo, float g) {
  material.coat_thickness = thickness, material.coat_albedo = glm::vec3(albedo);
  material.coat_asymmetry = g;
  return material;
}

// Its widths come from an image.
Material Imaged(Material material) {
  material.roughness_texture = 0;
  return material;
}

struct Layered {
  std::string name;
  Material material;
};
const std::vector<Layered>& Cases() {
  static const std::vector<Layered> cases = {
      {"dim", Body(0.2f)},
      {"grey", Body(0.5f)},
      {"bright", Body(0.8f)},
      {"white", Body(1)},
      {"water", Body(0.6f, 0, 1.33f)},
      {"glass", Body(0.6f, 0.1f, 1.8f)},
      {"satin", Body(0.5f, 0.3f)},
      {"rough", Body(0.7f, 0.7f)},
      {"dark", Misty(Body(0.5f), 1, 0, 0)},
      {"milk", Misty(Body(0.3f), 1, 0.9f, 0)},
      {"haze", Misty(Body(0.5f, 0.2f), 0.3f, 0.6f, 0.7f)},
      {"backward", Misty(Body(0.5f), 3, 0.8f, -0.5f)},
      {"thin", Misty(Body(0.8f), 0.01f, 0.5f, 0)},
      {"steel", Metal(1, 3.0550505f, 0.05f)},
      {"silver", Metal(0.2f, 3.9f, 0.05f)},
      {"brushed", Metal(0.2f, 3.9f, 0.3f, 0.1f)},
      {"dull", Metal(1, 2, 0.5f, 0.3f, 1.8f)},
      {"narrow", Metal(0.2f, 3.9f, 0.01f, 0.3f)},
      {"tarnished", Misty(Metal(0.2f, 3.9f, 0.2f, 0.05f), 0.5f, 0.7f, 0.3f)},
      {"smoked", Misty(Metal(0.2f, 3.9f, 0.1f), 0.4f, 0, 0)},
      {"imaged_smooth", Imaged(Body(0.6f, 0))},
      {"imaged_gloss", Imaged(Body(0.6f, 0.04f, 1.8f))},
      {"imaged_satin", Imaged(Body(0.5f, 0.3f))},
      {"imaged_rough", Imaged(Body(0.7f, 0.75f))},
      {"imaged_haze", Imaged(Misty(Body(0.5f, 0.25f), 0.3f, 0.6f, 0.7f))},
      {"imaged_steel", Imaged(Metal(1, 3.0550505f, 0.05f))},
      {"imaged_brushed", Imaged(Metal(0.2f, 3.9f, 0.3f, 0.1f))},
      {"imaged_dull", Imaged(Metal(1, 2, 0.5f, 0.3f, 1.8f))},
      {"imaged_tarnished", Imaged(Misty(Metal(0.2f, 3.9f, 0.2f, 0.05f), 0.5f, 0.7f, 0.3f))},
  };
  return cases;
}

class Coats : public testing::TestWithParam<std::size_t> {
 protected:
  const Layered& layered_ = Cases()[GetParam()];
};

constexpr int kWalks = 100000;

// The directional albedo is within 2 % of that of the layers, which has an error of its own.
TEST_P(Coats, ReflectWhatTheirLayersReflect) {
  const MaterialCase material = CaseOf(layered_.name, layered_.material);
  for (const double cosine : {1.0, 0.75, 0.5, 0.3, 0.15}) {
    Random random(7);
    double sum = 0, squares = 0;
    for (int i = 0; i < kWalks; ++i) {
      const Vec wo = {std::sqrt(1 - cosine * cosine), 0, cosine};
      const double weight = WalkLayers(layered_.material, 1, wo, random).weight;
      sum += weight, squares += weight * weight;
    }
    const double exact = sum / kWalks;
    const double error = std::sqrt((squares / kWalks - exact * exact) / kWalks);
    EXPECT_NEAR(Albedo(material, cosine)[1], exact, 0.02 * exact + 3 * error) << cosine;
  }
}

// The light leaves in the same directions: the cosines have the same distribution. Metals under
// rough coats have a lobe of the right width and not quite of the right shape.
TEST_P(Coats, ScatterWhereTheirLayersScatter) {
  constexpr int kBins = 5;
  constexpr std::uint32_t kSamples = 1 << 16;
  const MaterialCase material = CaseOf(layered_.name, layered_.material);
  const double tolerance = material.kind == BsdfKind::kCoatedConductor ? 0.05 : 0.01;
  const Vec normal = {0, 0, 1};
  for (const double cosine : {0.9, 0.5}) {
    const Vec wo = AtAngle(normal, cosine);
    const ShadingRows rows(material, kSamples, normal, wo);
    const ScatterRows uniforms(kSamples, 3);
    soa::Table<RayColumns> rays(kSamples);
    const std::uint32_t alive = rows.kernels.scatter(rows.surfaces, rows.materials(),
                                                     uniforms.view(), kSamples, {}, rays, 0);
    double engine[kBins] = {}, exact[kBins] = {};
    const auto bin = [](double z) { return std::clamp(int(z * kBins), 0, kBins - 1); };
    for (std::uint32_t i = 0; i < alive; ++i) {
      engine[bin(rays->dir_z[i])] += double(rays->throughput_g[i]) / kSamples;
    }
    Random random(8);
    for (int i = 0; i < kWalks; ++i) {
      const LayeredPath path = WalkLayers(layered_.material, 1, wo, random);
      if (path.weight > 0) exact[bin(path.direction.z)] += path.weight / kWalks;
    }
    for (int b = 0; b < kBins; ++b) {
      EXPECT_NEAR(engine[b], exact[b], tolerance) << cosine << ", bin " << b;
    }
  }
}

INSTANTIATE_TEST_SUITE_P(All, Coats, testing::Range(std::size_t{0}, Cases().size()),
                         [](const auto& test) { return Cases()[test.param].name; });

// Balls in a white furnace, seen from far away through a square of 0.7 of their radius. A body
// shows r (1 - F) / (1 - r F) of what enters, F = 0.596 being the mean reflectance of the coat from
// inside; a smooth metal shows R (1 - f) / (1 - R f) of it, with the reflectances for its
// direction.
TEST(CoatedBalls, HaveTheirBrightnessInAFurnace) {
  const struct {
    const char* name;
    Material material;
    double exact;
  } balls[] = {{"0.2", Body(0.2f), 0.1359},
               {"0.5", Body(0.5f), 0.3222},
               {"0.8", Body(0.8f), 0.6361},
               {"steel", Metal(1, 3.0550505f, 0), 0.623},
               {"silver", Metal(0.2f, 3.9f, 0), 0.934}};
  for (const auto& ball : balls) {
    const MaterialCase material = CaseOf(ball.name, ball.material);
    double sum = 0;
    constexpr int kSide = 8;
    for (int i = 0; i < kSide * kSide; ++i) {
      const double x = 0.7 * (i % kSide + 0.5) / kSide, y = 0.7 * (i / kSide + 0.5) / kSide;
      sum += Albedo(material, std::sqrt(1 - x * x - y * y))[1];
    }
    EXPECT_NEAR(sum / (kSide * kSide), ball.exact, 0.005 * ball.exact) << ball.name;
  }
}

// A mirror shows no light without extent, and neither does a smooth coat, nor smooth metal below
// it. They show lights that stand for a part of a map, and rough coats show all.
TEST(SmoothCoats, HideLightsWithoutExtent) {
  const Vec normal = {0, 0, 1}, wo = AtAngle(normal, 0.7);
  const Vec mirrored = {-wo.x, -wo.y, wo.z};
  const auto value = [&](const Material& material, float pdf) {
    const ShadingRows rows(CaseOf("coat", material), 1, normal, wo);
    soa::Table<LightColumns> lights(1);
    Put(mirrored, 0, lights->dir_x, lights->dir_y, lights->dir_z);
    lights->r[0] = lights->g[0] = lights->b[0] = 1, lights->pdf[0] = pdf;
    rows.kernels.evaluate_lights(rows.surfaces, rows.materials(), 1, {}, lights);
    return lights->g[0];
  };
  constexpr float kPart = std::numeric_limits<float>::infinity();
  EXPECT_EQ(value(Body(0), kPunctual), 0);
  EXPECT_GT(value(Body(0), kPart), 1e3f);
  EXPECT_EQ(value(Body(0, 0.1f), kPunctual), value(Body(0, 0.1f), kPart));
  EXPECT_EQ(value(Metal(0.2f, 3.9f, 0), kPunctual), 0);
  EXPECT_GT(value(Metal(0.2f, 3.9f, 0), kPart), 1e4f);
  // What lies below a smooth coat is seen through it.
  EXPECT_NEAR(value(Body(0.5f), kPunctual), 0.3 * 0.7 / kPi, 0.1);
  const Material brushed = Metal(0.2f, 3.9f, 0.3f);
  const float coat = value(Body(0), kPart);
  EXPECT_GT(value(brushed, kPunctual), 0.1f);
  EXPECT_NEAR(value(brushed, kPart) - value(brushed, kPunctual), coat, 1e-4f * coat);
}

// Each channel has its own medium and its own metal.
TEST(ColouredCoats, ReflectWhatTheirLayersReflect) {
  Material milk = Misty(Body(0.6f), 1, 0, 0.3f);
  milk.coat_albedo = {0.95f, 0.5f, 0.05f}, milk.reflectance = {0.3f, 0.6f, 0.9f};
  Material gold = Misty(Metal(0.2f, 3.9f, 0.2f, 0.05f), 0.5f, 0, 0);
  gold.coat_albedo = {0.1f, 0.6f, 0.9f};
  gold.eta = {0.14f, 0.38f, 1.44f}, gold.k = {3.98f, 2.39f, 1.60f};
  for (const auto& [name, material] : {std::pair{"milk", milk}, std::pair{"gold", gold}}) {
    const MaterialCase packed = CaseOf(name, material);
    for (const double cosine : {0.9, 0.4}) {
      const std::array<double, 3> engine = Albedo(packed, cosine);
      for (int channel = 0; channel < 3; ++channel) {
        Random random(9);
        double sum = 0, squares = 0;
        for (int i = 0; i < kWalks; ++i) {
          const Vec wo = {std::sqrt(1 - cosine * cosine), 0, cosine};
          const double weight = WalkLayers(material, channel, wo, random).weight;
          sum += weight, squares += weight * weight;
        }
        const double exact = sum / kWalks;
        const double error = std::sqrt((squares / kWalks - exact * exact) / kWalks);
        EXPECT_NEAR(engine[std::size_t(channel)], exact, 0.03 * exact + 3 * error)
            << name << ", cosine " << cosine << ", channel " << channel;
      }
    }
  }
}

// Materials share a table only if all agrees on which it depends.
TEST(CoatKeys, DifferInAllThatTablesDependOn) {
  const auto expect_changes = [](const Material& material, auto change, const char* what) {
    Material other = material;
    change(other);
    EXPECT_NE(CoatKeyOf(other), CoatKeyOf(material)) << what;
  };
  const Material body = Misty(Body(0.5f, 0.2f), 0.3f, 0.6f, 0.4f);
  const Material metal = Misty(Metal(0.2f, 3.9f, 0.3f, 0.1f), 0.3f, 0.6f, 0.4f);
  for (const Material& material : {body, metal}) {
    expect_changes(
        material, [](Material& m) { m.ior = 1.6f; }, "ior");
    expect_changes(
        material, [](Material& m) { m.alpha = 0.4f; }, "alpha");
    expect_changes(
        material, [](Material& m) { m.coat_thickness = 0.4f; }, "thickness");
    expect_changes(
        material, [](Material& m) { m.coat_asymmetry = 0.3f; }, "asymmetry");
    expect_changes(
        material, [](Material& m) { m.roughness_texture = 0; }, "texture");
    for (int c = 0; c < 3; ++c) {
      expect_changes(
          material, [&](Material& m) { m.coat_albedo[c] = 0.1f; }, "albedo");
    }
  }
  expect_changes(
      metal, [](Material& m) { m.coat_alpha = 0.2f; }, "width of the coat");
  for (int c = 0; c < 3; ++c) {
    expect_changes(
        metal, [&](Material& m) { m.eta[c] = 1; }, "eta");
    expect_changes(
        metal, [&](Material& m) { m.k[c] = 1; }, "k");
  }
  EXPECT_NE(CoatKeyOf(body), CoatKeyOf(metal));
  // The body's reflectance is no part of the table.
  Material darker = body;
  darker.reflectance = glm::vec3(0.1f);
  EXPECT_EQ(CoatKeyOf(darker), CoatKeyOf(body));
}

TEST(MistyCoats, ScatterStraightOnOrStraightBack) {
  const MaterialCase clear = CaseOf("clear", Body(0.5f));
  const MaterialCase forward = CaseOf("forward", Misty(Body(0.5f), 0.3f, 1, 1));
  for (const double cosine : {0.9, 0.5}) {
    // The engine scatters a little to the sides: its asymmetry is 0.95 at most.
    const double exact = Albedo(clear, cosine)[1];
    EXPECT_NEAR(Albedo(forward, cosine)[1], exact, 0.03 * exact) << cosine;  // false for NaN
  }
  // Straight back from a thick medium without absorption: nothing reaches the black body.
  const Material back = Misty(Body(0), 3, 1, -1);
  EXPECT_GT(Albedo(CaseOf("back", back), 0.9)[1], 0.5);
}

}  // namespace
}  // namespace skywave
