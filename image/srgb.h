// The transfer curve of sRGB (IEC 61966-2-1).
#pragma once

#include <cmath>

namespace skywave {

// Converts linear light in [0, 1] to the encoded value in [0, 1]. Values outside are clipped; NaN
// becomes 0.
inline double SrgbFromLinear(double linear) {
  if (!(linear > 0)) return 0;
  if (linear >= 1) return 1;
  return linear <= 0.0031308 ? 12.92 * linear : 1.055 * std::pow(linear, 1 / 2.4) - 0.055;
}

// Converts encoded values in [0, 1] back to linear light.
inline double LinearFromSrgb(double encoded) {
  return encoded <= 0.04045 ? encoded / 12.92 : std::pow((encoded + 0.055) / 1.055, 2.4);
}

}  // namespace skywave
