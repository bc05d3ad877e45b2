#include "tests/support/bsdf_cases.h"

#include <algorithm>
#include <array>
#include <cstring>
#include <map>
#include <stdexcept>
#include <string>
#include <utility>

#include "kernels/bsdf/coat_tables.h"
#include "kernels/bsdf/conductor_tables.h"
#include "kernels/bsdf/dielectric_tables.h"
#include "kernels/bsdf/material.h"
#include "kernels/bsdf/pack.h"
#include "tests/support/glass_formulas.h"
#include "tests/support/layered_formulas.h"
#include "tests/support/oracle_bsdf.h"

namespace skywave {
namespace {

constexpr float kGoldEta[3] = {0.143f, 0.375f, 1.442f}, kGoldK[3] = {3.983f, 2.386f, 1.603f};

// Returns gold of width `along` along the tangent and `across` across it.
MaterialRecord Brushed(float along, float across, bool white) {
  MaterialRecord record = {.color = {1, 0.8f, 0.5f}, .alpha = along, .ior = across};
  for (int c = 0; c < 3 && !white; ++c) record.eta[c] = kGoldEta[c], record.k[c] = kGoldK[c];
  for (int c = 0; c < 3 && white; ++c) record.color[c] = 1;
  return record;
}

MaterialRecord Glossy(float alpha) {  // Phong
  return {.color = {0.3f, 0.2f, 0.1f}, .alpha = alpha, .eta = {0.4f, 0.5f, 0.7f}};
}

MaterialRecord CoatedVarnish(float strength, float coat_alpha, float sheen, float sheen_alpha) {
  MaterialRecord record = MetallicRoughness(0.4f, 0.3f);
  record.k[0] = strength, record.k[1] = coat_alpha, record.k[2] = sheen_alpha;
  record.multiscatter[0] = sheen, record.multiscatter[1] = 0.5f * sheen;
  return record;
}

Material CoatedGold(float alpha, float coat_alpha) {
  Material material = {.bsdf = BsdfKind::kCoatedConductor,
                       .reflectance = glm::vec3(1),
                       .alpha = alpha,
                       .coat_alpha = coat_alpha};
  for (int c = 0; c < 3; ++c) material.eta[c] = kGoldEta[c], material.k[c] = kGoldK[c];
  return material;
}

Material Lacquered(float alpha, float ior) {
  return {.bsdf = BsdfKind::kCoatedDiffuse,
          .reflectance = {0.8f, 0.5f, 0.2f},
          .alpha = alpha,
          .ior = ior};
}

Material Misty(Material material) {
  material.coat_thickness = 0.8f, material.coat_asymmetry = 0.4f;
  material.coat_albedo = {0.9f, 0.5f, 0.1f};
  return material;
}

std::vector<CoatTable>& Coats() {
  static std::vector<CoatTable> coats;
  return coats;
}

std::vector<DielectricTable>& Dielectrics() {
  static std::vector<DielectricTable> tables;
  return tables;
}

MaterialRecord Milky(float alpha, float ior) {
  return RecordOfGlass(RoughGlass(alpha, ior), MakeDielectricTable(alpha, ior));
}

std::vector<MaterialCase> MakeDenseCases() {
  using enum BsdfKind;
  std::vector<MaterialCase> list;
  list.push_back({"LambertWhite", kLambert, {.color = {1, 1, 1}}});
  list.push_back({"LambertRed", kLambert, {.color = {0.8f, 0.05f, 0}}});
  for (const float alpha : {0.001f, 0.01f, 0.05f, 0.1f, 0.25f, 0.5f, 0.77f, 1.0f}) {
    const std::string name = std::to_string(int(alpha * 1000));
    list.push_back({"White" + name, kConductor, WhiteConductor(alpha)});
    list.push_back({"Gold" + name, kConductor, GoldConductor(alpha)});
  }
  for (const float alpha : {0.001f, 0.05f, 0.25f, 1.0f}) {
    const std::string name = std::to_string(int(alpha * 1000));
    list.push_back({"Varnish" + name, kMetallicRoughness, MetallicRoughness(alpha, 0)});
    list.push_back({"Mixed" + name, kMetallicRoughness, MetallicRoughness(alpha, 0.6f)});
    list.push_back({"Copper" + name, kMetallicRoughness, MetallicRoughness(alpha, 1)});
  }
  for (const float roughness : {0.0f, 0.4f, 1.0f}) {
    list.push_back({"Clay" + std::to_string(int(roughness * 10)),
                    kOrenNayar,
                    {.color = {0.8f, 0.5f, 0.1f}, .alpha = roughness}});
  }
  list.push_back({"ClayWhite", kOrenNayar, {.color = {1, 1, 1}, .alpha = 1}});
  list.push_back(
      {"Leaf", kDiffuseTransmission, {.color = {0.4f, 0.3f, 0.1f}, .eta = {0.2f, 0.5f, 0.6f}}});
  list.push_back({"LeafBlack", kDiffuseTransmission, {.color = {0, 0, 0}, .eta = {1, 1, 1}}});
  for (const bool back : {false, true}) {
    const std::string side = back ? "Inside" : "Outside";
    for (const float alpha : {0.05f, 0.3f, 1.0f}) {
      list.push_back({"Frosted" + std::to_string(int(alpha * 100)) + side,
                      kRoughDielectric,
                      {.color = {1, 0.9f, 0.5f}, .alpha = alpha, .ior = 1.5f},
                      back});
    }
    list.push_back(
        {"Stained" + side,
         kRoughDielectric,
         {.color = {0.2f, 0.6f, 0.9f}, .alpha = 0.3f, .eta = {1, 0.8f, 0.5f}, .ior = 1.5f},
         back});
    list.push_back({"Bubble" + side,
                    kRoughDielectric,
                    {.color = {1, 1, 1}, .alpha = 0.2f, .ior = 0.75f},
                    back});
    for (const float alpha : {0.1f, 0.4f, 1.0f}) {
      list.push_back({"Milky" + std::to_string(int(alpha * 100)) + side, kRoughDielectric,
                      Milky(alpha, 1.5f), back});
    }
    Material ground = RoughGlass(0.3f, 1.5f);
    ground.alpha_across = HeldWidth(0.1), ground.energy_compensation = false;
    list.push_back(
        {"Ground" + side, kRoughDielectric, PackMaterial(ground, {}), back, HeldTurn(0.7)});
    ground = RoughGlass(0.15f, 1.33f), ground.alpha_across = HeldWidth(0.6);
    list.push_back({"MilkyGround" + side, kRoughDielectric,
                    RecordOfGlass(ground, MakeDielectricTable(0.15f, 0.6f, 1.33f)), back,
                    HeldTurn(-2.1)});
    list.push_back({"MilkyBubble" + side, kRoughDielectric, Milky(0.6f, 0.75f), back});
  }
  for (const BsdfKind kind : {kAnisotropicConductor, kBeckmannConductor}) {
    const std::string name = kind == kBeckmannConductor ? "Gauss" : "Brushed";
    list.push_back({name + "Gold", kind, Brushed(0.3f, 0.1f, false), false, 0.7});
    list.push_back({name + "White", kind, Brushed(0.08f, 0.5f, true), false, -2.1});
    list.push_back({name + "Round", kind, Brushed(0.2f, 0.2f, true)});
    list.push_back({name + "Narrow", kind, Brushed(0.01f, 0.02f, true), false, 3.0});
    list.push_back({name + "Rough", kind, Brushed(1, 0.8f, true), false, 1.5});
  }
  const auto kept = [&](const std::string& name, MaterialRecord record, double turn) {
    list.push_back(
        {"Brushed" + name + "Kept", kAnisotropicConductor, Keeping(record), false, turn});
  };
  kept("Gold", Brushed(0.5f, 0.2f, false), 0.7);
  kept("White", Brushed(0.15f, 0.9f, true), -2.1);
  kept("Round", Brushed(0.3f, 0.3f, true), 0);
  for (const float alpha : {0.05f, 0.3f, 0.9f}) {
    const std::string name = std::to_string(int(alpha * 100));
    list.push_back({"Plastic" + name, kPhong, Glossy(alpha)});
    MaterialRecord blinn = GoldConductor(alpha);
    list.push_back({"Blinn" + name, kBlinn, blinn});
  }
  for (const float alpha : {0.05f, 0.4f}) {
    const std::string name = std::to_string(int(alpha * 100));
    const Material brick = {
        .reflectance = {0.5f, 0.3f, 0.1f}, .alpha = alpha, .second_color = {0.3f, 0.4f, 0.9f}};
    for (const bool back : {false, true}) {
      Material toy = brick;
      toy.bsdf = kGlossyDiffuse;
      list.push_back({"Brick" + name + (back ? "Inside" : "Outside"), kGlossyDiffuse,
                      PackMaterial(toy, {}), back});
    }
    Material plastic = brick, glaze = brick;
    plastic.bsdf = kGlossyDiffuse, plastic.ior = 1 / 1.5f;
    glaze.bsdf = kFresnelBlend;
    list.push_back({"Plastic3" + name, kGlossyDiffuse, PackMaterial(plastic, {})});
    list.push_back({"Glaze" + name, kFresnelBlend, PackMaterial(glaze, {})});
  }
  list.push_back({"BlinnWhite", kBlinn, WhiteConductor(0.2f)});
  list.push_back({"WardSatin", kWard, Brushed(0.3f, 0.1f, true), false, 0.7});
  list.push_back({"WardNarrow", kWard, Brushed(0.05f, 0.03f, true), false, 2.0});
  list.push_back({"Lacquer", kCoatedMetallicRoughness, CoatedVarnish(1, 0.1f, 0, 0.3f)});
  list.push_back({"Velvet", kCoatedMetallicRoughness, CoatedVarnish(0, 0.1f, 1, 0.2f)});
  list.push_back({"Both", kCoatedMetallicRoughness, CoatedVarnish(0.5f, 0.3f, 0.6f, 0.6f)});
  const auto layered = [&](const std::string& name, const Material& material, double turn = 0,
                           std::array<std::uint32_t, 4> layers = {~0u, ~0u, ~0u, ~0u}) {
    list.push_back({"Layered" + name, kLayeredMetallicRoughness, PackMaterial(material, {}), false,
                    HeldTurn(turn), layers});
  };
  Material paint = {.bsdf = kLayeredMetallicRoughness,
                    .reflectance = {0.8f, 0.3f, 0.5f},
                    .alpha = 0.2f,
                    .metallic = 0.3f,
                    .coat = 0,
                    .specular = 0.7f,
                    .specular_color = {2, 0.5f, 1}};
  layered("Tinted", paint);
  paint.anisotropy = 0.7f;
  layered("Grained", paint, 0.7);
  paint.alpha = 0.05f, paint.metallic = 1;
  layered("GrainedMetal", paint, -2.1);
  paint.anisotropy = 0, paint.alpha = 0.15f, paint.film = 0.8f, paint.film_thick = 450;
  layered("Oily", paint);
  paint.metallic = 0, paint.film = 1, paint.film_ior = 1.8f, paint.film_thick = 300;
  layered("Soapy", paint);
  paint.coat = 1, paint.coat_alpha = 0.3f, paint.sheen = {0.5f, 0.8f, 0.3f};
  paint.sheen_alpha = 0.5f, paint.anisotropy = 0.5f, paint.alpha = 0.4f, paint.metallic = 0.5f;
  layered("All", paint, 1.3, {0xB4C8A0D7, 0x00A0FF78, 0xC090FFE0, 0x00C85AB4});
  // Below a coat that does not follow its relief. Coordinates that EncodeNormal keeps exactly.
  list.push_back(list.back());
  list.back().name = "LayeredTilted", list.back().turn = 0;
  list.back().base_normal = Unit({0.25, -0.125, 0.625});
  list.push_back({"CoatedGold", kCoatedConductor, RecordWithCoat(CoatedGold(0.3f, 0.05f))});
  list.push_back({"MistyGold", kCoatedConductor, RecordWithCoat(Misty(CoatedGold(0.1f, 0.2f)))});
  list.push_back({"Enamel", kCoatedDiffuse, RecordWithCoat(Lacquered(0.05f, 1.5f))});
  list.push_back({"Satin", kCoatedDiffuse, RecordWithCoat(Lacquered(0.4f, 1.8f))});
  list.push_back({"Misty", kCoatedDiffuse, RecordWithCoat(Misty(Lacquered(0.2f, 1.33f)))});
  for (const float alpha : {0.05f, 0.4f, 1.0f}) {
    list.push_back({"Shade" + std::to_string(int(alpha * 100)), kCoatedDiffuseTransmission,
                    PackMaterial({.bsdf = kCoatedDiffuseTransmission,
                                  .reflectance = {0.9f, 0.6f, 0.2f},
                                  .alpha = alpha,
                                  .ior = 1.8f},
                                 {})});
    list.push_back({"Pane" + std::to_string(int(alpha * 100)), kRoughThinDielectric,
                    PackMaterial({.bsdf = kRoughThinDielectric,
                                  .reflectance = {0.9f, 0.6f, 0.2f},
                                  .alpha = alpha,
                                  .reflection = glm::vec3(1, 0.8f, 0.5f)},
                                 {})});
  }
  list.push_back({"PaneWhite", kRoughThinDielectric,
                  PackMaterial({.bsdf = kRoughThinDielectric,
                                .reflectance = glm::vec3(1),
                                .alpha = 0.2f,
                                .ior = 1.8f,
                                .energy_compensation = false},
                               {}),
                  true});
  // Layers that images change: films are thinner, and left out in parts.
  const auto oily = [](Material glass) {
    glass.reflection = glm::vec3(1, 0.8f, 0.5f);
    glass.specular = 0.9f, glass.specular_color = {2, 1, 0.5f};
    glass.film = 0.9f, glass.film_ior = 1.7f, glass.film_thin = 200, glass.film_thick = 600;
    return glass;
  };
  const std::array<std::uint32_t, 4> images = {~0u, ~0u, 0xE0C090FF, 0xFFFF60D0};
  list.push_back(
      {"PaneOily", kRoughThinDielectric,
       PackMaterial(
           oily({.bsdf = kRoughThinDielectric, .reflectance = {0.9f, 0.6f, 0.2f}, .alpha = 0.15f}),
           {}),
       false, 0, images});
  for (const bool back : {false, true}) {
    list.push_back({std::string("Oily") + (back ? "Inside" : "Outside"), kRoughDielectric,
                    RecordOfGlass(oily(RoughGlass(0.2f, 1.5f)), MakeDielectricTable(0.2f, 1.5f)),
                    back, 0, images});
  }
  // Coats over glass, one of which does not follow its relief.
  const auto lamp = [&](const std::string& name, const Material& glass, bool back,
                        Vec base_normal) {
    const bool solid = glass.bsdf == kCoatedRoughDielectric;
    list.push_back({"Coated" + name, glass.bsdf,
                    solid ? RecordOfGlass(glass, MakeDielectricTable(glass.alpha, glass.ior))
                          : PackMaterial(glass, {}),
                    back, 0, images, base_normal});
  };
  for (const bool back : {false, true}) {
    const std::string side = back ? "Inside" : "Outside";
    Material glass = RoughGlass(0.3f, 1.5f);
    glass.bsdf = kCoatedRoughDielectric, glass.coat_alpha = 0.1f;
    lamp("Glass" + side, glass, back, {0, 0, 1});
    glass.alpha = 0.2f, glass.coat = 0.8f, glass.coat_alpha = 0.3f;
    lamp("TiltedGlass" + side, oily(glass), back, Unit({0.125, -0.0625, 0.8125}));
    glass.bsdf = kCoatedRoughThinDielectric;
    lamp("Pane" + side, oily(glass), back, {0, 0, 1});
    glass.alpha = 0.4f, glass.coat_alpha = 0.1f;
    lamp("TiltedPane" + side, glass, back, Unit({0.125, -0.0625, 0.8125}));
  }
  list.push_back({"Measured", kMeasured, {.color = {1, 1, 1}, .alpha = 0.3f, .ior = 0.6f}});
  return list;
}

}  // namespace

const std::vector<MaterialCase>& DenseCases() {
  static const std::vector<MaterialCase> cases = MakeDenseCases();
  return cases;
}

const std::vector<MaterialCase>& DeltaCases() {
  static const std::vector<MaterialCase> cases = [] {
    MaterialRecord mirror = Conductor(0, kGoldEta, kGoldK);
    mirror.color[0] = 0.9f, mirror.color[1] = 0.5f, mirror.color[2] = 0.25f;
    const MaterialRecord glass = {.color = {1, 0.5f, 0.25f}, .ior = 1.5f};
    return std::vector<MaterialCase>{{"mirror", BsdfKind::kMirror, mirror},
                                     {"glass", BsdfKind::kDielectric, glass},
                                     {"pane", BsdfKind::kThinDielectric, glass}};
  }();
  return cases;
}

const MaterialCase& ExampleOf(BsdfKind kind) {
  for (const auto* cases : {&DenseCases(), &DeltaCases()}) {
    for (const MaterialCase& material : *cases) {
      if (material.kind == kind && material.record.color[2] > 0 &&
          (cases == &DeltaCases() || LobeWidth(material) >= 0.05)) {
        return material;
      }
    }
  }
  throw std::logic_error(std::string(Bsdfs()[std::size_t(kind)].name) + " has no case");
}

double LobeWidth(const MaterialCase& material) {
  const MaterialRecord& m = material.record;
  switch (material.kind) {
    case BsdfKind::kLambert:
    case BsdfKind::kOrenNayar:
    case BsdfKind::kDiffuseTransmission:
      return 1;
    case BsdfKind::kAnisotropicConductor:
    case BsdfKind::kBeckmannConductor:
    case BsdfKind::kWard:
      return std::min(m.alpha, m.ior);
    case BsdfKind::kRoughDielectric:
      return m.multiscatter[2] > 0 ? std::min(m.alpha, m.multiscatter[2]) : m.alpha;
    case BsdfKind::kCoatedRoughDielectric:
    case BsdfKind::kCoatedRoughThinDielectric:
      return std::min(m.alpha, CoatOfGlass(m).alpha);
    case BsdfKind::kCoatedMetallicRoughness:
      return std::min(m.alpha, m.k[1]);
    case BsdfKind::kCoatedConductor:
      return std::min(m.alpha, m.multiscatter[1]);
    case BsdfKind::kLayeredMetallicRoughness:
      return LobeWidthOfLayers(material);
    default:
      return m.alpha;
  }
}

std::vector<float> SyntheticMeasuredTable() {
  std::vector<float> table(kMeasuredFloats);
  std::size_t at = 0;
  for (std::uint32_t h = 0; h < kMeasuredHalf; ++h) {
    const double root = (h + 0.5) / kMeasuredHalf, theta = kPi / 2 * root * root;
    const double slope = std::tan(theta) / 0.3,
                 spread = std::cos(theta) * std::cos(theta) * (1 + slope * slope);
    const double ggx = 1 / (kPi * 0.3 * 0.3 * spread * spread);
    for (std::uint32_t d = 0; d < kMeasuredDifference; ++d) {
      const double away = (d + 0.5) / kMeasuredDifference;
      for (std::uint32_t t = 0; t < kMeasuredTurn; ++t) {
        const double turn = std::cos(2 * kPi * (t + 0.5) / kMeasuredTurn);
        const double gloss = ggx * 0.1 * (1 - away * away);
        const double body = 0.1 * (1 + 0.3 * turn * away);
        for (const double color : {1.0, 0.7, 0.3}) table[at++] = float(gloss + color * body);
      }
    }
  }
  return table;
}

MaterialRecord RecordWithCoat(const Material& material) {
  MaterialRecord record = PackMaterial(material, {});
  PutField(record, MaterialField::kCoatTable, std::uint32_t(Coats().size()));
  if (material.roughness_texture) {
    const std::vector<CoatTable> by_width = MakeCoatTables(material);
    Coats().insert(Coats().end(), by_width.begin(), by_width.end());
  } else {
    Coats().push_back(MakeCoatTable(material));
  }
  return record;
}

std::vector<Material> BeyondTheBuiltinOnes() {
  return {{.name = "frosted pane",
           .bsdf = BsdfKind::kRoughThinDielectric,
           .reflectance = {0.9f, 0.7f, 0.3f},
           .alpha = 0.2f,
           .reflection = glm::vec3(1)},
          {.name = "lacquered pane",
           .bsdf = BsdfKind::kCoatedRoughThinDielectric,
           .reflectance = {0.9f, 0.7f, 0.3f},
           .alpha = 0.3f,
           .coat_alpha = 0.1f,
           .reflection = glm::vec3(1)},
          {.name = "lacquered glass",
           .bsdf = BsdfKind::kCoatedRoughDielectric,
           .reflectance = {0.9f, 0.7f, 0.3f},
           .alpha = 0.3f,
           .coat = 0.8f,
           .coat_alpha = 0.1f},
          {.name = "lamp shade",
           .bsdf = BsdfKind::kCoatedDiffuseTransmission,
           .reflectance = {0.9f, 0.7f, 0.3f},
           .alpha = 0.2f},
          {.name = "toy brick",
           .bsdf = BsdfKind::kGlossyDiffuse,
           .reflectance = {0.5f, 0.1f, 0.1f},
           .alpha = 0.2f,
           .ior = 1.6f,
           .second_color = {0.6f, 0.7f, 0.8f}},
          {.name = "glaze",
           .bsdf = BsdfKind::kFresnelBlend,
           .reflectance = {0.2f, 0.5f, 0.3f},
           .alpha = 0.2f,
           .second_color = {0.2f, 0.1f, 0.05f}},
          {.name = "beetle",
           .bsdf = BsdfKind::kLayeredMetallicRoughness,
           .reflectance = {0.2f, 0.5f, 0.3f},
           .alpha = 0.15f,
           .metallic = 0.4f,
           .coat = 0.5f,
           .coat_alpha = 0.2f,
           .sheen = {0.3f, 0.2f, 0.1f},
           .sheen_alpha = 0.4f,
           .specular = 0.8f,
           .specular_color = {1.5f, 1, 0.5f},
           .anisotropy = 0.6f,
           .film = 0.7f,
           .film_thick = 350}};
}

Material RoughGlass(float alpha, float ior) {
  return {.bsdf = BsdfKind::kRoughDielectric,
          .reflectance = {1, 0.9f, 0.5f},
          .alpha = alpha,
          .ior = ior};
}

MaterialRecord RecordOfGlass(const Material& material, const DielectricTable& table) {
  Dielectrics().push_back(table);
  MaterialRecord record = PackMaterial(material, {});
  PutField(record, MaterialField::kDielectricTable, std::uint32_t(Dielectrics().size()));
  return record;
}

const DielectricTable* DielectricsForTests() { return Dielectrics().data(); }

MaterialRecord Keeping(MaterialRecord anisotropic) {
  for (int c = 0; c < 3; ++c) {
    anisotropic.multiscatter[c] =
        ConductorMultiscatter(GetAnisotropicTables(), anisotropic.alpha, anisotropic.ior,
                              anisotropic.eta[c], anisotropic.k[c]);
  }
  return anisotropic;
}

const CoatTable* CoatsForTests() { return Coats().data(); }

const float* MeasuredForTests() {
  static const std::vector<float> table = SyntheticMeasuredTable();
  return table.data();
}

}  // namespace skywave
