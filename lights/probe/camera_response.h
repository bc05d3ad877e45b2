// The response of a camera is found from photographs of one view at several exposures (T 5.1), in
// one of two ways: Debevec and Malik 1997, "Recovering High Dynamic Range Radiance Maps from
// Photographs", or Robertson et al. 2003, "Estimation-Theoretic Approach to Dynamic Range
// Enhancement Using Multiple Exposures".
#pragma once

#include <array>
#include <cstddef>
#include <string>
#include <vector>

#include "base/names.h"
#include "image/image.h"

namespace skywave {

struct Exposure {
  std::string name;  // for messages
  Image image;       // the numbers of the file
  // Codes of a camera with a response that is not known, over 255; false: numbers in proportion to
  // the light.
  bool coded = true;
  double exposure = 1;  // time, times sensitivity and area of the aperture where these differ
};

// Exposures that lie over each other.
struct ExposureStack {
  const std::vector<Exposure>& exposures;
  const std::vector<std::array<int, 2>>& shift;  // of each [pixels]

  // Returns the pixel of an exposure that shows (x, y) of the middle one; null: none does.
  const float* Pixel(std::size_t exposure, int x, int y) const {
    const Image& image = exposures[exposure].image;
    x += shift[exposure][0], y += shift[exposure][1];
    if (x < 0 || y < 0 || x >= image.width || y >= image.height) return nullptr;
    return image.Pixel(x, y);
  }
};

inline constexpr int kCodes = 256;

// Returns the code of a number of a picture, 1 for white.
int CodeOf(float value);

// A number for each code.
using CodeValues = std::array<double, kCodes>;

// ln of the exposure that gives a code, by channel; 0 at code 128.
using Response = std::array<CodeValues, 3>;

enum class ResponseMethod {
  kDebevec,    // least squares of logarithms, and smooth (equation 3)
  kRobertson,  // the most likely one, by turns with the radiance, from that of kDebevec on
};

template <>
inline constexpr auto kEnumNames<ResponseMethod> = std::to_array<Named<ResponseMethod>>(
    {{ResponseMethod::kDebevec, "debevec"}, {ResponseMethod::kRobertson, "robertson"}});

// Returns the response that makes the exposures agree best. At most 40000 pixels take part.
Response FindResponse(const ExposureStack& stack, ResponseMethod method);

// Returns how much each code says about the light, for the mean of the method; 0 for black and
// white.
CodeValues WeightsOfCodes(const CodeValues& response, ResponseMethod method);

}  // namespace skywave
