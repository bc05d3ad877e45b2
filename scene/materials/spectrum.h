// Scene files give some quantities by wavelength; these functions make linear Rec. 709 colours of
// them.
//
// The observer is that of the CIE of 1931 for 2 degrees, tabulated every 5 nm (CIE 15:2004) and
// integrated from 360 to 830 nm in steps of 1 nm. Colours outside of Rec. 709 are clamped at 0.
#pragma once

#include <glm/glm.hpp>
#include <optional>
#include <span>
#include <string>
#include <string_view>
#include <vector>

namespace skywave {

// Pairs (wavelength [nm], value), with ascending wavelengths. The spectrum is linear in between and
// constant beyond both ends.
using SpectrumPairs = std::span<const glm::vec2>;

// Returns the value at a wavelength [nm]; there is at least one pair.
double SpectrumValueAt(SpectrumPairs spectrum, double nm);

// Converts CIE XYZ to linear Rec. 709 (IEC 61966-2-1).
glm::vec3 RgbFromXyz(const glm::vec3& xyz);

// Returns the colour of a reflectance, transmittance or index of refraction under daylight (D65),
// the light that white stands for: each channel is the mean over its share of the observer, so that
// a constant spectrum is exactly that grey.
glm::vec3 RgbOfReflectance(SpectrumPairs spectrum);

// Returns the colour of light, without adaptation to a white: the luminance of the constant 1 is 1.
glm::vec3 RgbOfEmission(SpectrumPairs spectrum);
// Returns the same with luminance 1; that of darkness is black.
glm::vec3 RgbOfUnitEmission(SpectrumPairs spectrum);

// Returns the colour of a black body [K], by Planck's law. The first has luminance 1; for the
// second one the brightest wavelength has 1 (as in pbrt-v3).
glm::vec3 RgbOfBlackbody(float kelvin);
glm::vec3 RgbOfBlackbodyPeak(float kelvin);

// Returns a standard illuminant by pbrt-v4's name (stdillum-A, -D50, -D65, -F1 to -F12,
// illum-acesD60). It has luminance 1 and its chromaticity (CIE 15:2004, tables T.3 and T.5;
// ACES TB-2014-004).
std::optional<glm::vec3> RgbOfIlluminant(std::string_view name);

// Conversions of linear RGB of another space to linear Rec. 709, which may give negative values.
// The colour of light keeps its chromaticity; that of a reflectance is adapted, so that white stays
// white (Bradford's method, Lam 1985).
struct RgbConversion {
  glm::mat3 light, reflectance;
};
// Returns that of a space by pbrt-v4's name (srgb, dci-p3, rec2020, aces2065-1), or nothing.
std::optional<RgbConversion> FindRgbSpace(std::string_view name);

// Parses a file of pairs like pbrt's .spd, with white space between numbers and # comments. Throws
// InputError with the line on anything else and on wavelengths that do not ascend.
std::vector<glm::vec2> ParseSpectrumFile(const std::string& text, const std::string& path);

}  // namespace skywave
