// Spectra as linear Rec. 709 colours: what scene files give by wavelength.
//
// The observer is CIE 1931 2 degrees in the analytic fit of Wyman, Sloan and Shirley, "Simple
// Analytic Approximations to the CIE XYZ Color Matching Functions" (JCGT 2013, multi-lobe),
// integrated from 360 to 830 nm in steps of 1 nm. Colours outside of Rec. 709 are clamped at 0.
#pragma once

#include <glm/glm.hpp>
#include <optional>
#include <span>
#include <string>
#include <string_view>
#include <vector>

namespace skywave {

// (wavelength [nm], value), wavelengths ascending; straight in between, constant beyond both ends.
using SpectrumPairs = std::span<const glm::vec2>;

// CIE XYZ to linear Rec. 709 (IEC 61966-2-1).
glm::vec3 RgbFromXyz(const glm::vec3& xyz);

// Of a reflectance, transmittance or index of refraction: each channel is the mean over its share
// of the observer, so that a constant spectrum is exactly that grey.
glm::vec3 RgbOfReflectance(SpectrumPairs spectrum);

// Of light, without adaptation to a white: luminance 1 for the constant 1.
glm::vec3 RgbOfEmission(SpectrumPairs spectrum);

// Of a black body [K], by Planck's law: of luminance 1, or such that the brightest wavelength has 1
// (as in pbrt-v3).
glm::vec3 RgbOfBlackbody(float kelvin);
glm::vec3 RgbOfBlackbodyPeak(float kelvin);

// A standard illuminant by pbrt-v4's name (stdillum-A, -D50, -D65, -F1 to -F12, illum-acesD60), of
// luminance 1, from its chromaticity (CIE 15:2004, tables T.3 and T.5; ACES TB-2014-004).
std::optional<glm::vec3> RgbOfIlluminant(std::string_view name);

// Reads a file of pairs, as pbrt's .spd: white space between numbers, # comments. Throws InputError
// with the line on anything else and on wavelengths that do not ascend.
std::vector<glm::vec2> ParseSpectrumFile(const std::string& text, const std::string& path);

}  // namespace skywave
