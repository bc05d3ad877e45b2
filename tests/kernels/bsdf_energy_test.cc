// Tests that BSDFs lose and add no energy.
#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <cmath>

#include "kernels/bsdf/bsdf.h"
#include "kernels/bsdf/material.h"
#include "kernels/bsdf/pack.h"
#include "tests/support/bsdf_albedo.h"
#include "tests/support/bsdf_cases.h"
#include "tests/support/targets.h"

namespace skywave {
namespace {

const std::vector<MaterialCase>& Materials() { return DenseCases(); }
const double kCosines[] = {1.0, 0.9, 0.6, 0.3, 0.1, 0.02};

TEST(BsdfEnergy, LambertReflectsItsColor) {
  for (const double cosine : kCosines) {
    const auto albedo = Albedo(Materials()[1], cosine);
    EXPECT_NEAR(albedo[0], 0.8, 1e-5);
    EXPECT_NEAR(albedo[1], 0.05, 1e-6);
    EXPECT_EQ(albedo[2], 0);
  }
}

// This is a furnace test: a conductor that absorbs nothing reflects everything, at every width and
// angle. The error of Kulla and Conty's lobe comes from interpolation in its 32 x 32 table: at most
// 0.48 % from cosine 0.1 up (at alpha 0.017) and 1.7 % below (at alpha 0.004, cosine 0.015) were
// measured.
TEST(BsdfEnergy, WhiteConductorLosesNothing) {
  for (int a = 0; a <= 40; ++a) {
    const float alpha = float(0.001 + 0.999 * (a / 40.0) * (a / 40.0));
    const MaterialCase white = {"", BsdfKind::kConductor, WhiteConductor(alpha)};
    for (const double cosine : {1.0, 0.95, 0.8, 0.6, 0.4, 0.25, 0.15, 0.1, 0.06, 0.03, 0.015}) {
      EXPECT_NEAR(Albedo(white, cosine)[1], 1, cosine >= 0.1 ? 6e-3 : 2e-2)
          << "alpha " << alpha << ", cosine " << cosine;
    }
  }
}

// So does brushed metal. Interpolation in the table of two widths makes errors of 1 %, or of 1.5 %
// where one width is six times the other or more, and up to 2.5 times these at grazing angles.
TEST(BsdfEnergy, WhiteBrushedMetalLosesNothing) {
  for (const float along : {0.03f, 0.1f, 0.3f, 0.6f, 1.0f}) {
    for (const float across : {0.05f, 0.2f, 0.45f, 0.8f, 1.0f}) {
      MaterialRecord record = {.color = {1, 1, 1}, .alpha = along, .ior = across};
      record = Keeping(record);
      const bool extreme = std::max(along, across) > 5.9f * std::min(along, across);
      const double bound = extreme ? 1.5e-2 : 1e-2;
      for (const double turn : {0.0, 0.4, 0.8, 1.2, kPi / 2}) {
        const MaterialCase white = {"", BsdfKind::kAnisotropicConductor, record, false, turn};
        for (const double cosine : {1.0, 0.8, 0.5, 0.3, 0.15, 0.1, 0.03}) {
          EXPECT_NEAR(Albedo(white, cosine)[1], 1, cosine >= 0.1 ? bound : 2.5 * bound)
              << "widths " << along << " and " << across << ", turned by " << turn << ", cosine "
              << cosine;
        }
      }
    }
  }
}

// Reflectance and transmittance of white rough glass add up to 1 on both of its sides, also with a
// table for all widths (by rows).
TEST(BsdfEnergy, WhiteRoughGlassLosesNothing) {
  for (const float ior : {1.1f, 1.33f, 1.5f, 2.0f, 0.6f}) {
    const DielectricTable all_widths = MakeDielectricTable(ior);
    for (const float alpha : {0.02f, 0.1f, 0.2f, 0.37f, 0.6f, 0.85f, 1.0f}) {
      const Material glass = RoughGlass(alpha, ior);
      const MaterialRecord records[] = {RecordOfGlass(glass, MakeDielectricTable(alpha, ior)),
                                        RecordOfGlass(glass, all_widths)};
      for (const MaterialRecord& record : records) {
        for (const bool back : {false, true}) {
          const MaterialCase milky = {"", BsdfKind::kRoughDielectric, record, back};
          for (const double cosine : {1.0, 0.9, 0.75, 0.6, 0.45, 0.3, 0.2, 0.1, 0.03}) {
            EXPECT_NEAR(Albedo(milky, cosine)[0], 1, cosine >= 0.1 ? 6e-3 : 1.5e-2)
                << "ior " << ior << ", alpha " << alpha << (back ? ", inside" : ", outside")
                << ", cosine " << cosine << (&record == records ? ", own table" : "");
          }
        }
      }
    }
  }
}

// So does glass of two widths, whose rows are azimuths.
TEST(BsdfEnergy, WhiteGroundGlassLosesNothing) {
  for (const auto [along, across, ior] : {std::array{0.05f, 0.3f, 1.5f},
                                          {0.6f, 0.15f, 1.5f},
                                          {1.0f, 0.4f, 1.2f},
                                          {0.3f, 0.9f, 0.7f}}) {
    Material glass = RoughGlass(along, ior);
    glass.alpha_across = across;
    const MaterialRecord record = RecordOfGlass(glass, MakeDielectricTable(along, across, ior));
    for (const bool back : {false, true}) {
      for (const double turn : {0.0, 0.4, 0.8, 1.2, kPi / 2}) {
        const MaterialCase ground = {"", BsdfKind::kRoughDielectric, record, back, turn};
        for (const double cosine : {1.0, 0.75, 0.45, 0.2, 0.1, 0.03}) {
          EXPECT_NEAR(Albedo(ground, cosine)[0], 1, 1e-2)
              << "ior " << ior << ", widths " << along << " and " << across
              << (back ? ", inside" : ", outside") << ", turn " << turn << ", cosine " << cosine;
        }
      }
    }
  }
}

// Rough glass lets as much diffuse light through as the smooth interface (Walsh 1926) where both
// sides lose alike, and no side more.
TEST(BsdfEnergy, DiffuseTransmittanceIsThatOfWalsh) {
  for (const double n : {1.1, 1.33, 1.5, 2.0, 2.4}) {
    const double n2 = n * n, n4 = n2 * n2;
    const double reflected =
        0.5 + (n - 1) * (3 * n + 1) / (6 * (n + 1) * (n + 1)) +
        n2 * (n2 - 1) * (n2 - 1) / std::pow(n2 + 1, 3) * std::log((n - 1) / (n + 1)) -
        2 * n2 * n * (n2 + 2 * n - 1) / ((n2 + 1) * (n4 - 1)) +
        8 * n4 * (n4 + 1) / ((n2 + 1) * (n4 - 1) * (n4 - 1)) * std::log(n);
    EXPECT_NEAR(DiffuseTransmittance(float(n)), 1 - reflected, 1e-4) << "index " << n;
    // What enters is what leaves: n^2 as many rays are inside.
    EXPECT_NEAR(DiffuseTransmittance(float(1 / n)) * n2, 1 - reflected, 3e-4) << "index " << n;
  }
}

// White bodies under their coat, white metals and all their mixtures pass the furnace test too, for
// any index; the coat alone, over black, reflects less than it receives.
TEST(BsdfEnergy, WhiteMetallicRoughnessLosesNothing) {
  for (const float metallic : {0.0f, 0.3f, 1.0f}) {
    for (const float ior : {1.0f, 1.5f, 2.2f}) {
      for (int a = 0; a <= 12; ++a) {
        const float alpha = float(0.001 + 0.999 * (a / 12.0) * (a / 12.0));
        MaterialRecord record = MetallicRoughness(alpha, metallic);
        for (float& channel : record.color) channel = 1;
        record.ior = ior;
        const MaterialCase white = {"", BsdfKind::kMetallicRoughness, record};
        for (const double cosine : {1.0, 0.8, 0.5, 0.25, 0.1, 0.03}) {
          EXPECT_NEAR(Albedo(white, cosine)[1], 1, cosine >= 0.1 ? 1e-2 : 4e-2)
              << "metallic " << metallic << ", ior " << ior << ", alpha " << alpha << ", cosine "
              << cosine;
        }
      }
    }
  }
  MaterialRecord black = MetallicRoughness(0.3f, 0);
  for (float& channel : black.color) channel = 0;
  const double coat = Albedo({"", BsdfKind::kMetallicRoughness, black}, 1)[1];
  EXPECT_GT(coat, 0.035);
  EXPECT_LT(coat, 0.05);
}

// The materials are rough white clay and a sheet that absorbs nothing.
TEST(BsdfEnergy, WhiteDiffuseSurfacesLoseNothing) {
  for (const double cosine : kCosines) {
    for (const float roughness : {0.0f, 0.3f, 1.0f}) {
      const MaterialRecord clay = {.color = {1, 1, 1}, .alpha = roughness};
      EXPECT_NEAR(Albedo({"", BsdfKind::kOrenNayar, clay}, cosine)[1], 1, 2e-3)
          << "roughness " << roughness << ", cosine " << cosine;
    }
    const MaterialRecord sheet = {.color = {0.3f, 0.3f, 0.3f}, .eta = {0.7f, 0.7f, 0.7f}};
    EXPECT_NEAR(Albedo({"", BsdfKind::kDiffuseTransmission, sheet}, cosine)[1], 1, 1e-4);
  }
}

// What the coat does not reflect passes, so a white sheet loses nothing; a black one has the coat.
TEST(BsdfEnergy, WhiteSheetsUnderACoatLoseNothing) {
  for (const float alpha : {0.02f, 0.1f, 0.37f, 1.0f}) {
    for (const float ior : {1.0f, 1.5f, 2.2f}) {
      const auto albedo = [&](float color, double cosine) {
        const MaterialRecord sheet = PackMaterial({.bsdf = BsdfKind::kCoatedDiffuseTransmission,
                                                   .reflectance = glm::vec3(color),
                                                   .alpha = alpha,
                                                   .ior = ior},
                                                  {});
        return Albedo({"", BsdfKind::kCoatedDiffuseTransmission, sheet}, cosine)[1];
      };
      for (const double cosine : kCosines) {
        EXPECT_NEAR(albedo(1, cosine), 1, 6e-3)
            << "alpha " << alpha << ", ior " << ior << ", cosine " << cosine;
      }
      const double f0 = (ior - 1) * (ior - 1) / ((ior + 1) * (ior + 1));
      const double coat = albedo(0, 1);
      EXPECT_TRUE(alpha > 0.3f || std::fabs(coat - f0) < 1e-3 + 0.02 * f0) << coat << ", " << f0;
    }
  }
}

// Its two lobes lose what a white conductor of the same width loses.
TEST(BsdfEnergy, WhiteRoughPanesLoseNothing) {
  for (const float alpha : {0.02f, 0.1f, 0.37f, 1.0f}) {
    const MaterialRecord pane = PackMaterial({.bsdf = BsdfKind::kRoughThinDielectric,
                                              .reflectance = glm::vec3(1),
                                              .alpha = alpha,
                                              .ior = 1.5f},
                                             {});
    for (const double cosine : kCosines) {
      EXPECT_NEAR(Albedo({"", BsdfKind::kRoughThinDielectric, pane}, cosine)[1], 1, 6e-3)
          << "alpha " << alpha << ", cosine " << cosine;
    }
  }
}

// A coat takes from both sides of glass what it reflects, or a little more where light is scattered
// to angles at which the coat reflects more than at that of the eye. Light that a narrow pane
// transmits goes straight on, so hardly anything is lost there.
TEST(BsdfEnergy, WhiteGlassUnderACoatReflectsNoMoreThanArrives) {
  const auto coated = [](BsdfKind kind, float alpha) {
    return Material{
        .bsdf = kind, .reflectance = glm::vec3(1), .alpha = alpha, .coat = 1, .coat_alpha = 0.02f};
  };
  for (const double cosine : kCosines) {
    for (const bool back : {false, true}) {
      const auto pane = [&](float alpha) {
        const BsdfKind kind = BsdfKind::kCoatedRoughThinDielectric;
        return Albedo({"", kind, PackMaterial(coated(kind, alpha), {}), back}, cosine)[1];
      };
      EXPECT_NEAR(pane(0.02f), 1, cosine > 0.4 ? 6e-3 : 0.03) << cosine;
      const BsdfKind kind = BsdfKind::kCoatedRoughDielectric;
      const double solid = Albedo(
          {"", kind, RecordOfGlass(coated(kind, 0.3f), MakeDielectricTable(0.3f, 1.5f)), back},
          cosine)[1];
      for (const double rough : {pane(0.4f), solid}) {
        EXPECT_LT(rough, 1 + 6e-3) << cosine;
        EXPECT_GT(rough, 0.85) << cosine;
      }
    }
  }
}

// Layers over white keep the furnace white: a weaker dielectric, a grain, and a film. What facets
// under a film reflect depends on their own angles, and the body knows that of the surface alone:
// up to a tenth is lost there, and more at grazing angles.
TEST(BsdfEnergy, WhiteLayersLoseNothing) {
  for (const float metallic : {0.0f, 0.5f, 1.0f}) {
    for (const float anisotropy : {0.0f, 0.4f}) {
      for (const float film : {0.0f, 1.0f}) {
        const Material white = {.bsdf = BsdfKind::kLayeredMetallicRoughness,
                                .reflectance = glm::vec3(1),
                                .alpha = 0.25f,
                                .metallic = metallic,
                                .coat = 0,
                                .specular = 0.6f,
                                .specular_color = glm::vec3(2),
                                .anisotropy = anisotropy,
                                .film = film,
                                .film_ior = 1.4f,
                                .film_thick = 600};
        const MaterialCase packed = {"", BsdfKind::kLayeredMetallicRoughness,
                                     PackMaterial(white, {}), false, 0.5};
        for (const double cosine : {1.0, 0.8, 0.5, 0.3}) {
          const auto albedo = Albedo(packed, cosine);
          const double largest = std::max({albedo[0], albedo[1], albedo[2]});
          EXPECT_LE(largest, 1.02) << metallic << anisotropy << film << cosine;
          if (film > 0 && cosine < 0.5) continue;
          EXPECT_GE(largest, film > 0 ? 0.9 : 0.98) << metallic << anisotropy << film << cosine;
        }
      }
    }
  }
}

// Without its own layers it is metallic-roughness, and coated metallic-roughness with a coat.
TEST(BsdfEnergy, LayersThatAreNotThereChangeNothing) {
  const Vec normal = Unit({0.3, -0.2, 0.9});
  const Vec wo = AtAngle(normal, 0.6);
  Random random(12);
  std::vector<Vec> wi;
  for (int i = 0; i < 200; ++i) wi.push_back(random.DirectionAbout(normal));
  for (const bool coated : {false, true}) {
    const auto value = [&](BsdfKind kind) {
      const Material material = {.bsdf = kind,
                                 .reflectance = {0.9f, 0.5f, 0.2f},
                                 .alpha = 0.3f,
                                 .metallic = 0.4f,
                                 .coat = coated ? 0.8f : 0.0f,
                                 .coat_alpha = 0.2f,
                                 .sheen = glm::vec3(coated ? 0.4f : 0.0f)};
      return ShadingRows({"", kind, PackMaterial(material, {})}, std::uint32_t(wi.size()), normal,
                         wo)
          .Evaluate(wi);
    };
    const auto layered = value(BsdfKind::kLayeredMetallicRoughness);
    const auto plain =
        value(coated ? BsdfKind::kCoatedMetallicRoughness : BsdfKind::kMetallicRoughness);
    for (std::size_t i = 0; i < wi.size(); ++i) {
      EXPECT_NEAR(layered->r[i], plain->r[i], 1e-5f * (1 + plain->r[i]));
      EXPECT_NEAR(layered->b[i], plain->b[i], 1e-5f * (1 + plain->b[i]));
      EXPECT_NEAR(layered->pdf[i], plain->pdf[i], 1e-5f * (1 + plain->pdf[i]));
    }
  }
}

TEST(BsdfEnergy, NoMaterialReflectsMoreThanItGets) {
  for (const MaterialCase& material : Materials()) {
    for (const double cosine : kCosines) {
      for (const double channel : Albedo(material, cosine)) {
        EXPECT_LE(channel, 1.01) << material.name << " at cosine " << cosine;
      }
    }
  }
}

// At a smooth surface, gold's albedo is its Fresnel reflectance, computed here in complex numbers.
TEST(BsdfEnergy, SmoothGoldReflectsByFresnel) {
  const MaterialRecord gold = GoldConductor(0.001f);
  for (const double cosine : kCosines) {
    const auto albedo = Albedo({"", BsdfKind::kConductor, gold}, cosine);
    for (int c = 0; c < 3; ++c) {
      EXPECT_NEAR(albedo[c], FresnelReflectance(cosine, {gold.eta[c], gold.k[c]}), 2e-3)
          << "channel " << c << ", cosine " << cosine;
    }
  }
}

}  // namespace
}  // namespace skywave
