// Compares layers of smooth glass with their formulae in double, and renders glass with layers in
// constant light, where what it shows is known.
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>

#include "kernels/bsdf/material.h"
#include "kernels/bsdf/pack.h"
#include "tests/support/bsdf_albedo.h"
#include "tests/support/bsdf_cases.h"
#include "tests/support/glass_formulas.h"
#include "tests/support/lobe_grid.h"
#include "tests/support/picture_estimate.h"
#include "tests/support/render_scenes.h"
#include "tests/support/screens_scene.h"
#include "tests/support/statistics.h"

namespace skywave {
namespace {

const Vec kNormal = Unit({0.5, -0.3, -0.7});

Material Soapy(BsdfKind kind, float ior = 1.5f) {
  return {.bsdf = kind,
          .reflectance = {1, 0.5f, 0.25f},
          .ior = ior,
          .specular = 0.8f,
          .specular_color = {0.5f, 1, 2},
          .film = 0.9f,
          .film_ior = 1.7f,
          .film_thin = 150,
          .film_thick = 500,
          .reflection = glm::vec3(0.5f, 1, 0.75f)};
}

void ExpectNear(const glm::dvec3& value, const glm::dvec3& exact, double tolerance) {
  for (int c = 0; c < 3; ++c) EXPECT_NEAR(value[c], exact[c], tolerance) << "channel " << c;
}

// Textures have halved the share of the film and taken its thickness to a third, and those of the
// dielectric are 0.64, 0.25, 0.81 and 0.4.
constexpr std::array<std::uint32_t, 4> kTextured = {~0u, ~0u, 0x66E680CC, 0xFFFF5580};

TEST(GlassLayers, SmoothGlassReflectsTheirColoursFromBothSides) {
  for (const float ior : {1.0f, 1.33f, 1.5f, 2.4f}) {
    const Material soapy = Soapy(BsdfKind::kDielectric, ior);
    for (const auto& layers : {kTextured, MaterialCase{}.layers}) {
      for (const bool back : {false, true}) {
        const MaterialCase glass = {"", soapy.bsdf, PackMaterial(soapy, {}), back, 0, layers};
        const double near = back ? ior : 1, far = back ? 1 : ior, scale = near / far;
        for (const double cosine : {1.0, 0.8, 0.5, 0.2}) {
          SCOPED_TRACE(testing::Message() << ior << (back ? " inside " : " outside ") << cosine);
          const GlassFacet facet = FacetOfGlass(glass, cosine, near, far);
          const LobeGrid grid(glass, kNormal, AtAngle(kNormal, cosine));
          ExpectNear(grid.Reflected(), facet.rgb * glm::dvec3(*soapy.reflection), 3e-4);
          ExpectNear(grid.Transmitted() / (scale * scale),
                     (1 - facet.largest) * glm::dvec3(soapy.reflectance), 3e-4);
        }
      }
    }
  }
}

TEST(GlassLayers, PanesReflectTheirColours) {
  Material soapy = Soapy(BsdfKind::kThinDielectric);
  for (const bool own : {true, false}) {
    if (!own) soapy.reflection.reset();
    for (const bool back : {false, true}) {
      const MaterialCase pane = {"", soapy.bsdf, PackMaterial(soapy, {}), back, 0, kTextured};
      for (const double cosine : {1.0, 0.6, 0.2}) {
        // The film is the same from both sides of a pane.
        const GlassFacet facet = FacetOfGlass(pane, cosine, 1, soapy.ior);
        const double once = facet.largest, both = own ? once : 2 * once / (1 + once);
        const LobeGrid grid(pane, kNormal, AtAngle(kNormal, cosine));
        const glm::dvec3 color(own ? *soapy.reflection : soapy.reflectance);
        ExpectNear(grid.Reflected(), facet.rgb / once * both * color, 5e-4);
        ExpectNear(grid.Transmitted(), (1 - both) * glm::dvec3(soapy.reflectance), 5e-4);
      }
    }
  }
}

// The brightest channel of white glass loses nothing.
TEST(GlassLayers, TheBrightestChannelOfWhiteGlassLosesNothing) {
  for (const BsdfKind kind : {BsdfKind::kRoughDielectric, BsdfKind::kRoughThinDielectric}) {
    double least = 1;
    Material soapy = Soapy(kind);
    soapy.reflectance = glm::vec3(1), soapy.reflection = glm::vec3(1), soapy.film = 1;
    soapy.specular = 1, soapy.specular_color = glm::vec3(1);
    for (const float alpha : {0.05f, 0.2f}) {
      soapy.alpha = alpha;
      const bool solid = kind == BsdfKind::kRoughDielectric;
      const MaterialRecord record =
          solid ? RecordOfGlass(soapy, MakeDielectricTable(alpha, soapy.ior))
                : PackMaterial(soapy, {});
      for (const bool back : {false, true}) {
        for (const double cosine : {1.0, 0.7, 0.4}) {
          const auto albedo = Albedo({"", kind, record, back}, cosine);
          // Facets of other angles have another brightest channel.
          const double largest = std::max({albedo[0], albedo[1], albedo[2]});
          EXPECT_NEAR(largest, 1, 0.015) << alpha << (back ? " inside " : " outside ") << cosine;
          least = std::min({least, albedo[0], albedo[1], albedo[2]});
        }
      }
    }
    EXPECT_LT(least, 0.95) << "other channels lose light";
  }
}

// A square pane with images of all of its layers.
TEST(GlassLayers, ImagesOfThemAreSeenInPictures) {
  for (const BsdfKind kind : {BsdfKind::kThinDielectric, BsdfKind::kRoughThinDielectric}) {
    Scene scene;
    Material pane = Soapy(kind);
    pane.alpha = 1e-3f;
    const auto plain = [&](const glm::vec3& value) {
      scene.images.push_back(Plain(value));
      scene.textures.push_back({.image = std::uint32_t(scene.images.size() - 1)});
      return std::uint32_t(scene.textures.size() - 1);
    };
    // Green counts, and all of colours.
    pane.film_texture = plain({0.9f, 0.6f, 0.4f});
    pane.film_thickness_texture = plain({0.9f, 0.2f, 0.4f});
    pane.specular_texture = plain({0.9f, 0.8f, 0.4f});
    pane.specular_color_texture = plain({0.64f, 0.36f, 1});
    scene.materials = {pane};
    Place(scene, Quad(1), 0, glm::vec3(0));
    SetConstantLight(scene, 1);
    scene.camera = LookAtCamera({0, 50, 0}, glm::vec3(0), {0, 0, 1}, 0.5f, false);
    MaterialCase here = {"", kind, PackMaterial(pane, {})};
    here.layers[2] = 204u << 24 | 255u << 16 | 153u << 8 | 204u;  // roots of 0.64, 0.36 and 1; 0.8
    here.layers[3] = 51u << 8 | 153u;                             // a fifth and three fifths
    const GlassFacet facet = FacetOfGlass(here, 1, 1, pane.ior);
    JobRequest request = SmallRequest(8, 8, 256);
    const PictureEstimate mean =
        MeanOfBlocks(EstimateFromEngine(RenderJob(scene, request), 6, 3), 8);
    for (int c = 0; c < 3; ++c) {
      const double exact = facet.rgb[c] * double((*pane.reflection)[c]) +
                           (1 - facet.largest) * double(pane.reflectance[c]);
      const double error = std::sqrt(mean.variance[std::size_t(c)]);
      EXPECT_NEAR(mean.mean[std::size_t(c)], exact, 2e-3 + 5 * error) << "channel " << c;
      EXPECT_LT(error, 0.01);
    }
  }
}

}  // namespace
}  // namespace skywave
