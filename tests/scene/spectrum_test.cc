// Compares spectra as colours with published chromaticities and the defining identities.
#include "scene/materials/spectrum.h"

#include <gtest/gtest.h>

#include <cmath>

#include "base/error.h"

namespace skywave {
namespace {

glm::vec2 Chromaticity(const glm::vec3& rgb) {
  // Converts Rec. 709 to XYZ (IEC 61966-2-1).
  const glm::vec3 xyz(0.4124f * rgb.r + 0.3576f * rgb.g + 0.1805f * rgb.b,
                      0.2126f * rgb.r + 0.7152f * rgb.g + 0.0722f * rgb.b,
                      0.0193f * rgb.r + 0.1192f * rgb.g + 0.9505f * rgb.b);
  return glm::vec2(xyz) / (xyz.x + xyz.y + xyz.z);
}

float Luminance709(const glm::vec3& rgb) {
  return 0.2126f * rgb.r + 0.7152f * rgb.g + 0.0722f * rgb.b;
}

TEST(Spectrum, BlackBodiesLieOnThePlanckianLocus) {
  // The values are from Wyszecki and Stiles, "Color Science", table 1(3.11).
  const struct {
    float kelvin, x, y;
  } bodies[] = {{2856, 0.4476f, 0.4074f},
                {4000, 0.3805f, 0.3768f},
                {6504, 0.3135f, 0.3237f},
                {10000, 0.2807f, 0.2884f}};
  for (const auto& body : bodies) {
    const glm::vec3 rgb = RgbOfBlackbody(body.kelvin);
    EXPECT_NEAR(Chromaticity(rgb).x, body.x, 3e-4) << body.kelvin;
    EXPECT_NEAR(Chromaticity(rgb).y, body.y, 3e-4) << body.kelvin;
    EXPECT_NEAR(Luminance709(rgb), 1, 1e-3) << body.kelvin;
    // The other scale gives the same colour, with no wavelength above 1.
    const glm::vec3 peak = RgbOfBlackbodyPeak(body.kelvin);
    EXPECT_NEAR(peak.r / rgb.r, peak.g / rgb.g, 1e-4);
    EXPECT_LT(Luminance709(peak), 1);
  }
  // With a peak in the visible range, the spectrum is nearly as bright as a constant 1.
  EXPECT_GT(Luminance709(RgbOfBlackbodyPeak(5200)), 0.97);
}

// Figures of the observer's table for every nanometre, as pbrt-v4 has it; little blue is left of a
// dim fire.
TEST(Spectrum, BlackBodiesHaveTheirColour) {
  const struct {
    float kelvin;
    glm::vec3 rgb;
  } bodies[] = {{2000, {2.51998f, 0.64713f, 0.02049f}},
                {3000, {1.77072f, 0.84444f, 0.27214f}},
                {4500, {1.30075f, 0.94572f, 0.65278f}},
                {10000, {0.87180f, 0.99468f, 1.43076f}}};
  for (const auto& body : bodies) {
    const glm::vec3 rgb = RgbOfBlackbody(body.kelvin);
    for (int c = 0; c < 3; ++c) EXPECT_NEAR(rgb[c], body.rgb[c], 5e-4) << body.kelvin;
  }
}

TEST(Spectrum, ConstantsAreGreyReflectancesAndEqualEnergyLights) {
  const glm::vec2 constant[] = {{400, 0.3f}, {500, 0.3f}, {700, 0.3f}};
  EXPECT_EQ(RgbOfReflectance(constant), glm::vec3(0.3f));
  const glm::vec3 light = RgbOfEmission(constant);
  EXPECT_NEAR(Luminance709(light), 0.3, 1e-3);
  EXPECT_NEAR(Chromaticity(light).x, 1 / 3., 0.002);
  EXPECT_NEAR(Chromaticity(light).y, 1 / 3., 0.002);
}

TEST(Spectrum, ReflectancesAreLinearAndMonotone) {
  const glm::vec2 red[] = {{590, 0}, {610, 1}}, rest[] = {{590, 1}, {610, 0}};
  const glm::vec3 a = RgbOfReflectance(red), b = RgbOfReflectance(rest);
  EXPECT_GT(a.r, 0.6f);
  EXPECT_LT(a.g, 0.2f);
  EXPECT_LT(a.b, 0.05f);
  EXPECT_GT(b.b, 0.9f);
  // If nothing is clamped, complements add up to white.
  const glm::vec2 warm[] = {{450, 0.3f}, {650, 0.6f}}, cold[] = {{450, 0.7f}, {650, 0.4f}};
  for (int c = 0; c < 3; ++c) {
    EXPECT_NEAR(RgbOfReflectance(warm)[c] + RgbOfReflectance(cold)[c], 1, 1e-5) << c;
  }
  // Spectra are linear between samples and constant beyond them.
  const glm::vec2 two[] = {{400, 0.2f}, {700, 0.8f}},
                  three[] = {{100, 0.2f}, {400, 0.2f}, {550, 0.5f}, {700, 0.8f}, {900, 0.8f}};
  for (int c = 0; c < 3; ++c) {
    EXPECT_NEAR(RgbOfReflectance(two)[c], RgbOfReflectance(three)[c], 1e-5) << c;
  }
}

// Figures of pbrt-v4: a sphere of that reflectance under an even sky of rgb [1 1 1].
TEST(Spectrum, ReflectancesAreThoseUnderDaylight) {
  const glm::vec2 peak[] = {{400, 0.2f}, {500, 0.6f}, {700, 0.3f}},
                  ramp[] = {{400, 0.1f}, {550, 0.4f}, {700, 0.8f}},
                  valley[] = {{400, 0.8f}, {500, 0.3f}, {560, 0.1f}, {620, 0.6f}, {700, 0.9f}};
  const std::pair<SpectrumPairs, glm::vec3> cases[] = {{peak, {0.3693f, 0.5572f, 0.4020f}},
                                                       {ramp, {0.6375f, 0.3887f, 0.1799f}},
                                                       {valley, {0.5883f, 0.1621f, 0.5641f}}};
  for (const auto& [spectrum, rgb] : cases) {
    const glm::vec3 color = RgbOfReflectance(spectrum);
    for (int c = 0; c < 3; ++c) EXPECT_NEAR(color[c], rgb[c], 0.003) << c;
  }
}

TEST(Spectrum, IlluminantsHaveTheirWhite) {
  const glm::vec3 d65 = RgbOfIlluminant("stdillum-D65").value();
  for (int c = 0; c < 3; ++c) EXPECT_NEAR(d65[c], 1, 2e-3) << c;
  const glm::vec3 a = RgbOfIlluminant("stdillum-A").value(), body = RgbOfBlackbody(2856);
  for (int c = 0; c < 3; ++c) EXPECT_NEAR(a[c], body[c], 0.03) << c;
  EXPECT_FALSE(RgbOfIlluminant("stdillum-D66"));
}

// The published chromaticities of the CIE's illuminants and of the white of ACES are found again
// from the colour.
TEST(Spectrum, IlluminantsHaveTheirChromaticity) {
  const struct {
    const char* name;
    double x, y;
  } list[] = {{"stdillum-A", 0.44758, 0.40745},   {"stdillum-D50", 0.34567, 0.35851},
              {"stdillum-D65", 0.31272, 0.32903}, {"illum-acesD60", 0.32168, 0.33767},
              {"stdillum-F1", 0.3131, 0.3371},    {"stdillum-F2", 0.3721, 0.3751},
              {"stdillum-F3", 0.4091, 0.3941},    {"stdillum-F4", 0.4402, 0.4031},
              {"stdillum-F5", 0.3138, 0.3452},    {"stdillum-F6", 0.3779, 0.3882},
              {"stdillum-F7", 0.3129, 0.3292},    {"stdillum-F8", 0.3458, 0.3586},
              {"stdillum-F9", 0.3741, 0.3727},    {"stdillum-F10", 0.34609, 0.35986},
              {"stdillum-F11", 0.3805, 0.3769},   {"stdillum-F12", 0.4370, 0.4042}};
  for (const auto& known : list) {
    const glm::dvec3 rgb(RgbOfIlluminant(known.name).value());
    // IEC 61966-2-1, from linear Rec. 709 to XYZ.
    const double x = 0.4124 * rgb.x + 0.3576 * rgb.y + 0.1805 * rgb.z;
    const double y = 0.2126 * rgb.x + 0.7152 * rgb.y + 0.0722 * rgb.z;
    const double z = 0.0193 * rgb.x + 0.1192 * rgb.y + 0.9505 * rgb.z;
    EXPECT_NEAR(x / (x + y + z), known.x, 5e-4) << known.name;
    EXPECT_NEAR(y / (x + y + z), known.y, 5e-4) << known.name;
  }
}

// Published matrices: ITU-R BT.2087 for Rec. 2020, P3-D65 as in SMPTE EG 432-1, and those of the
// Academy's ACES-dev for AP0, by Bradford's adaptation.
TEST(Spectrum, RgbSpacesAreConverted) {
  const struct {
    const char* name;
    double rows[3][3];
  } spaces[] = {
      {"srgb", {{1, 0, 0}, {0, 1, 0}, {0, 0, 1}}},
      {"rec2020",
       {{1.6605, -0.5876, -0.0728}, {-0.1246, 1.1329, -0.0083}, {-0.0182, -0.1006, 1.1187}}},
      {"dci-p3", {{1.2249, -0.2249, 0}, {-0.0420, 1.0420, 0}, {-0.0196, -0.0786, 1.0979}}},
      {"aces2065-1",
       {{2.5217, -1.1341, -0.3876}, {-0.2765, 1.3727, -0.0962}, {-0.0154, -0.1530, 1.1683}}}};
  for (const auto& space : spaces) {
    const RgbConversion conversion = FindRgbSpace(space.name).value();
    for (int row = 0; row < 3; ++row) {
      for (int c = 0; c < 3; ++c) {
        EXPECT_NEAR(conversion.reflectance[c][row], space.rows[row][c], 5e-4) << space.name;
      }
    }
    // White light keeps its own white.
    const glm::vec3 white = conversion.light * glm::vec3(1);
    const bool warm = std::string_view(space.name) == "aces2065-1";
    EXPECT_NEAR(Chromaticity(white).x, warm ? 0.32168 : 0.3127, 3e-4) << space.name;
    EXPECT_NEAR(Chromaticity(white).y, warm ? 0.33767 : 0.3290, 3e-4) << space.name;
    EXPECT_NEAR(Luminance709(white), 1, 1e-3) << space.name;
  }
  EXPECT_FALSE(FindRgbSpace("rec709"));
}

TEST(Spectrum, FilesAreReadOrRefusedAtTheirLine) {
  const auto pairs = ParseSpectrumFile("# nm value\n400 .1\r\n500\t.2 # mid\n\n600, 3e-1", "a.spd");
  ASSERT_EQ(pairs.size(), 3u);
  EXPECT_EQ(pairs[2], glm::vec2(600, 0.3f));
  const struct {
    const char *text, *message;
  } bad[] = {{"400 1\n300 2", "a.spd:2: the wavelength 300"},
             {"400 x", "a.spd:1: 'x'"},
             {"400 nan", "a.spd:1: 'nan'"},
             {"400", "a.spd: is not a list"},
             {"", "a.spd: is not a list"}};
  for (const auto& file : bad) {
    try {
      ParseSpectrumFile(file.text, "a.spd");
      ADD_FAILURE() << file.text;
    } catch (const InputError& error) {
      EXPECT_TRUE(std::string(error.what()).starts_with(file.message)) << error.what();
    }
  }
}

}  // namespace
}  // namespace skywave
