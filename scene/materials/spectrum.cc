#include "scene/materials/spectrum.h"

#include <fmt/format.h>

#include <algorithm>
#include <charconv>
#include <cmath>

#include "base/error.h"
#include "image/primaries.h"

namespace skywave {
namespace {

constexpr int kFirstNanometre = 360, kLastNanometre = 830;

// The colour matching functions of the CIE 1931 standard observer, every 5 nm from kFirstNanometre
// to kLastNanometre (CIE 15:2004, table T.4).
constexpr int kObserverStep = 5;
constexpr double kObserver[][3] = {{0.0001299, 3.917e-06, 0.0006061},
                                   {0.0002321, 6.965e-06, 0.001086},
                                   {0.0004149, 1.239e-05, 0.001946},
                                   {0.0007416, 2.202e-05, 0.003486},
                                   {0.001368, 3.9e-05, 0.00645},
                                   {0.002236, 6.4e-05, 0.01055},
                                   {0.004243, 0.00012, 0.02005},
                                   {0.00765, 0.000217, 0.03621},
                                   {0.01431, 0.000396, 0.06785},
                                   {0.02319, 0.00064, 0.1102},
                                   {0.04351, 0.00121, 0.2074},
                                   {0.07763, 0.00218, 0.3713},
                                   {0.13438, 0.004, 0.6456},
                                   {0.21477, 0.0073, 1.03905},
                                   {0.2839, 0.0116, 1.3856},
                                   {0.3285, 0.01684, 1.62296},
                                   {0.34828, 0.023, 1.74706},
                                   {0.34806, 0.0298, 1.7826},
                                   {0.3362, 0.038, 1.77211},
                                   {0.3187, 0.048, 1.7441},
                                   {0.2908, 0.06, 1.6692},
                                   {0.2511, 0.0739, 1.5281},
                                   {0.19536, 0.09098, 1.28764},
                                   {0.1421, 0.1126, 1.0419},
                                   {0.09564, 0.13902, 0.81295},
                                   {0.05795, 0.1693, 0.6162},
                                   {0.03201, 0.20802, 0.46518},
                                   {0.0147, 0.2586, 0.3533},
                                   {0.0049, 0.323, 0.272},
                                   {0.0024, 0.4073, 0.2123},
                                   {0.0093, 0.503, 0.1582},
                                   {0.0291, 0.6082, 0.1117},
                                   {0.06327, 0.71, 0.07825},
                                   {0.1096, 0.7932, 0.05725},
                                   {0.1655, 0.862, 0.04216},
                                   {0.22575, 0.91485, 0.02984},
                                   {0.2904, 0.954, 0.0203},
                                   {0.3597, 0.9803, 0.0134},
                                   {0.43345, 0.99495, 0.00875},
                                   {0.51205, 1, 0.00575},
                                   {0.5945, 0.995, 0.0039},
                                   {0.6784, 0.9786, 0.00275},
                                   {0.7621, 0.952, 0.0021},
                                   {0.8425, 0.9154, 0.0018},
                                   {0.9163, 0.87, 0.00165},
                                   {0.9786, 0.8163, 0.0014},
                                   {1.0263, 0.757, 0.0011},
                                   {1.0567, 0.6949, 0.001},
                                   {1.0622, 0.631, 0.0008},
                                   {1.0456, 0.5668, 0.0006},
                                   {1.0026, 0.503, 0.00034},
                                   {0.9384, 0.4412, 0.00024},
                                   {0.85445, 0.381, 0.00019},
                                   {0.7514, 0.321, 0.0001},
                                   {0.6424, 0.265, 5e-05},
                                   {0.5419, 0.217, 3e-05},
                                   {0.4479, 0.175, 2e-05},
                                   {0.3608, 0.1382, 1e-05},
                                   {0.2835, 0.107, 0},
                                   {0.2187, 0.0816, 0},
                                   {0.1649, 0.061, 0},
                                   {0.1212, 0.04458, 0},
                                   {0.0874, 0.032, 0},
                                   {0.0636, 0.0232, 0},
                                   {0.04677, 0.017, 0},
                                   {0.0329, 0.01192, 0},
                                   {0.0227, 0.00821, 0},
                                   {0.01584, 0.005723, 0},
                                   {0.0113592, 0.004102, 0},
                                   {0.008111, 0.002929, 0},
                                   {0.00579, 0.002091, 0},
                                   {0.004109, 0.001484, 0},
                                   {0.002899, 0.001047, 0},
                                   {0.002049, 0.00074, 0},
                                   {0.00144, 0.00052, 0},
                                   {0.0009999, 0.0003611, 0},
                                   {0.0006901, 0.0002492, 0},
                                   {0.000476, 0.0001719, 0},
                                   {0.0003323, 0.00012, 0},
                                   {0.0002348, 8.48e-05, 0},
                                   {0.0001662, 6e-05, 0},
                                   {0.0001174, 4.24e-05, 0},
                                   {8.308e-05, 3e-05, 0},
                                   {5.871e-05, 2.12e-05, 0},
                                   {4.151e-05, 1.499e-05, 0},
                                   {2.935e-05, 1.06e-05, 0},
                                   {2.067e-05, 7.466e-06, 0},
                                   {1.456e-05, 5.258e-06, 0},
                                   {1.025e-05, 3.703e-06, 0},
                                   {7.221e-06, 2.608e-06, 0},
                                   {5.086e-06, 1.837e-06, 0},
                                   {3.582e-06, 1.293e-06, 0},
                                   {2.523e-06, 9.109e-07, 0},
                                   {1.777e-06, 6.415e-07, 0},
                                   {1.251e-06, 4.518e-07, 0}};

// Returns them linearly between their places.
glm::dvec3 Observer(int nm) {
  const int from_first = nm - kFirstNanometre;
  const auto low = std::min(std::size_t(from_first / kObserverStep), std::size(kObserver) - 2);
  const double share = double(from_first) / kObserverStep - double(low);
  const double* const a = kObserver[low];
  const double* const b = kObserver[low + 1];
  return {std::lerp(a[0], b[0], share), std::lerp(a[1], b[1], share), std::lerp(a[2], b[2], share)};
}

// Returns the XYZ of `value`(wavelength), where Y = 1 for the constant 1.
template <class Value>
glm::dvec3 Integrate(const Value& value) {
  glm::dvec3 sum(0);
  double white = 0;
  for (int nm = kFirstNanometre; nm <= kLastNanometre; ++nm) {
    const glm::dvec3 observer = Observer(nm);
    sum += observer * value(double(nm));
    white += observer.y;
  }
  return sum / white;
}

// Daylight D65, every 10 nm from kFirstNanometre to kLastNanometre, and linear in between (CIE
// 15:2004, table T.1).
constexpr double kDaylight[] = {
    46.6383, 52.0891, 49.9755, 54.6482, 82.7549, 91.486,  93.4318, 86.6823, 104.865, 117.008,
    117.812, 114.861, 115.923, 108.811, 109.354, 107.802, 104.79,  107.689, 104.405, 104.046,
    100,     96.3342, 95.788,  88.6856, 90.0062, 89.5991, 87.6987, 83.2886, 83.6992, 80.0268,
    80.2146, 82.2778, 78.2842, 69.7213, 71.6091, 74.349,  61.604,  69.8856, 75.087,  63.5927,
    46.4182, 66.8054, 63.3828, 64.304,  59.4519, 51.959,  57.4406, 60.3125};
double Daylight(double nm) {
  const double at = (nm - kFirstNanometre) / 10;
  const auto below = std::min(std::size_t(at), std::size(kDaylight) - 2);
  return kDaylight[below] + (kDaylight[below + 1] - kDaylight[below]) * (at - double(below));
}

glm::dvec3 Xyz(SpectrumPairs spectrum) {
  return Integrate([&](double nm) { return SpectrumValueAt(spectrum, nm); });
}

// Returns the radiance relative to its highest value at any wavelength, which Wien's displacement
// law places.
double Planck(double nm, double kelvin) {
  constexpr double kSecondConstant = 1.438776877e7;  // h c / k [nm K]
  constexpr double kWien = 2.897771955e6;            // [nm K]
  const auto radiance = [&](double at) {
    return 1 / (std::pow(at / 1000, 5) * std::expm1(kSecondConstant / (at * kelvin)));
  };
  return radiance(nm) / radiance(kWien / kelvin);
}

glm::vec3 InGamut(const glm::vec3& rgb) { return glm::max(rgb, glm::vec3(0)); }

struct NamedSpace {
  std::string_view name;
  RgbPrimaries primaries;
};
const NamedSpace kRgbSpaces[] = {
    {"srgb", kRec709},
    {"dci-p3", {{0.68, 0.32}, {0.265, 0.69}, {0.15, 0.06}, kWhiteD65}},
    {"rec2020", {{0.708, 0.292}, {0.17, 0.797}, {0.131, 0.046}, kWhiteD65}},
    {"aces2065-1", {{0.7347, 0.2653}, {0, 1}, {0.0001, -0.077}, {0.32168, 0.33767}}}};

struct Illuminant {
  std::string_view name;
  float x, y;
};
constexpr Illuminant kIlluminants[] = {
    {"stdillum-A", 0.44757f, 0.40745f},   {"stdillum-D50", 0.34567f, 0.35850f},
    {"stdillum-D65", 0.31272f, 0.32903f}, {"illum-acesD60", 0.32168f, 0.33767f},
    {"stdillum-F1", 0.31310f, 0.33727f},  {"stdillum-F2", 0.37208f, 0.37529f},
    {"stdillum-F3", 0.40910f, 0.39430f},  {"stdillum-F4", 0.44018f, 0.40329f},
    {"stdillum-F5", 0.31379f, 0.34531f},  {"stdillum-F6", 0.37790f, 0.38835f},
    {"stdillum-F7", 0.31292f, 0.32933f},  {"stdillum-F8", 0.34588f, 0.35875f},
    {"stdillum-F9", 0.37417f, 0.37281f},  {"stdillum-F10", 0.34609f, 0.35986f},
    {"stdillum-F11", 0.38052f, 0.37713f}, {"stdillum-F12", 0.43695f, 0.40441f},
};

}  // namespace

double SpectrumValueAt(SpectrumPairs spectrum, double nm) {
  const auto above = std::find_if(spectrum.begin(), spectrum.end(),
                                  [&](const glm::vec2& pair) { return pair.x >= nm; });
  if (above == spectrum.end()) return spectrum.back().y;
  if (above == spectrum.begin()) return above->y;
  const glm::dvec2 high = *above, low = *(above - 1);
  return low.y + (high.y - low.y) * (nm - low.x) / (high.x - low.x);
}

glm::vec3 RgbFromXyz(const glm::vec3& c) {
  return {3.2406f * c.x - 1.5372f * c.y - 0.4986f * c.z,
          -0.9689f * c.x + 1.8758f * c.y + 0.0415f * c.z,
          0.0557f * c.x - 0.2040f * c.y + 1.0570f * c.z};
}

glm::vec3 RgbOfReflectance(SpectrumPairs spectrum) {
  const auto [low, high] =
      std::minmax_element(spectrum.begin(), spectrum.end(),
                          [](const glm::vec2& a, const glm::vec2& b) { return a.y < b.y; });
  if (low->y == high->y) return glm::vec3(low->y);
  const glm::dvec3 lit =
      Integrate([&](double nm) { return Daylight(nm) * SpectrumValueAt(spectrum, nm); });
  return InGamut(RgbFromXyz(lit) / RgbFromXyz(Integrate(Daylight)));
}

glm::vec3 RgbOfEmission(SpectrumPairs spectrum) { return InGamut(RgbFromXyz(Xyz(spectrum))); }

glm::vec3 RgbOfUnitEmission(SpectrumPairs spectrum) {
  const glm::dvec3 xyz = Xyz(spectrum);
  return xyz.y > 0 ? InGamut(RgbFromXyz(xyz / xyz.y)) : glm::vec3(0);
}

glm::vec3 RgbOfBlackbody(float kelvin) {
  const glm::dvec3 xyz = Integrate([&](double nm) { return Planck(nm, kelvin); });
  return InGamut(RgbFromXyz(xyz / xyz.y));
}

glm::vec3 RgbOfBlackbodyPeak(float kelvin) {
  return InGamut(RgbFromXyz(Integrate([&](double nm) { return Planck(nm, kelvin); })));
}

std::optional<glm::vec3> RgbOfIlluminant(std::string_view name) {
  for (const Illuminant& i : kIlluminants) {
    if (i.name == name) return InGamut(RgbFromXyz({i.x / i.y, 1, (1 - i.x - i.y) / i.y}));
  }
  return std::nullopt;
}

std::optional<RgbConversion> FindRgbSpace(std::string_view name) {
  for (const auto& [known, space] : kRgbSpaces) {
    if (known != name) continue;
    const glm::dmat3 rgb_from_xyz = glm::inverse(XyzFromRgb(kRec709));
    const glm::dmat3 xyz_from_rgb = XyzFromRgb(space);
    return RgbConversion{glm::mat3(rgb_from_xyz * xyz_from_rgb),
                         glm::mat3(rgb_from_xyz * AdaptToD65(space.white) * xyz_from_rgb)};
  }
  return std::nullopt;
}

std::vector<glm::vec2> ParseSpectrumFile(const std::string& text, const std::string& path) {
  constexpr std::string_view kSpace = " \t\r,";
  std::vector<float> numbers;
  std::size_t line = 0;
  for (std::size_t begin = 0; begin < text.size();) {
    ++line;
    const std::size_t end = std::min(text.find('\n', begin), text.size());
    std::string_view rest(text.data() + begin, end - begin);
    rest = rest.substr(0, rest.find('#'));
    begin = end + 1;
    const auto fail = [&](const std::string& reason) {
      throw InputError(InputPosition::Line(path, line), reason);
    };
    while (true) {
      rest.remove_prefix(std::min(rest.find_first_not_of(kSpace), rest.size()));
      if (rest.empty()) break;
      const std::string_view word = rest.substr(0, rest.find_first_of(kSpace));
      float number = 0;
      const auto [stop, error] = std::from_chars(word.data(), word.data() + word.size(), number);
      if (error != std::errc() || stop != word.data() + word.size() || !std::isfinite(number)) {
        fail(fmt::format("'{}' is not a finite number of a spectrum", word.substr(0, 40)));
      }
      const std::size_t n = numbers.size();
      if (n >= 2 && n % 2 == 0 && !(number > numbers[n - 2])) {
        fail(fmt::format("the wavelength {} does not ascend", number));
      }
      numbers.push_back(number);
      rest.remove_prefix(word.size());
    }
  }
  if (numbers.empty() || numbers.size() % 2 != 0) {
    throw InputError(InputPosition::File(path), "is not a list of wavelengths and values");
  }
  std::vector<glm::vec2> pairs(numbers.size() / 2);
  for (std::size_t i = 0; i < pairs.size(); ++i) pairs[i] = {numbers[2 * i], numbers[2 * i + 1]};
  return pairs;
}

}  // namespace skywave
