#include "scene/materials/spectrum.h"

#include <fmt/format.h>

#include <algorithm>
#include <charconv>
#include <cmath>

#include "base/error.h"

namespace skywave {
namespace {

constexpr int kFirstNanometre = 360, kLastNanometre = 830;

// A Gaussian with a width for each side.
double Lobe(double x, double centre, double left, double right) {
  const double t = (x - centre) / (x < centre ? left : right);
  return std::exp(-0.5 * t * t);
}

// Returns the colour matching functions, by the equations of the multi-lobe fit.
glm::dvec3 Observer(double nm) {
  return {1.056 * Lobe(nm, 599.8, 37.9, 31.0) + 0.362 * Lobe(nm, 442.0, 16.0, 26.7) -
              0.065 * Lobe(nm, 501.1, 20.4, 26.2),
          0.821 * Lobe(nm, 568.8, 46.9, 40.5) + 0.286 * Lobe(nm, 530.9, 16.3, 31.1),
          1.217 * Lobe(nm, 437.0, 11.8, 36.0) + 0.681 * Lobe(nm, 459.0, 26.0, 13.8)};
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
        fail(fmt::format("'{}' is no finite number of a spectrum", word.substr(0, 40)));
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
    throw InputError(InputPosition::File(path), "is no list of wavelengths and values");
  }
  std::vector<glm::vec2> pairs(numbers.size() / 2);
  for (std::size_t i = 0; i < pairs.size(); ++i) pairs[i] = {numbers[2 * i], numbers[2 * i + 1]};
  return pairs;
}

}  // namespace skywave
