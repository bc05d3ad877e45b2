// Facets, their masking and their Fresnel reflectance by the papers, in double.
#pragma once

#include <cmath>

#include "tests/support/shading_rows.h"

namespace skywave {

inline double Square(double x) { return x * x; }

template <class Rgb>
double LuminanceOf(const Rgb& rgb) {
  return double(kLuminance[0]) * rgb[0] + double(kLuminance[1]) * rgb[1] +
         double(kLuminance[2]) * rgb[2];
}

inline double Power5(double x) { return Square(Square(x)) * x; }

inline Vec HalfOf(Vec wo, Vec wi) { return Unit(wo + wi); }

inline double RealFresnel(double cosine, double ratio) {  // `ratio`: near index over far index
  const double sine2 = ratio * ratio * (1 - cosine * cosine);
  return sine2 >= 1 ? 1 : FresnelReflectance(cosine, 1 / ratio);
}

inline double GgxDensity(Vec h, double x, double y) {
  return 1 / (kPi * x * y * Square(Square(h.x / x) + Square(h.y / y) + h.z * h.z));
}
inline double GgxLambda(Vec w, double x, double y) {
  return 0.5 * (std::sqrt(1 + (Square(x * w.x) + Square(y * w.y)) / (w.z * w.z)) - 1);
}
inline double BeckmannDensity(Vec h, double x, double y) {
  const double slope2 = (Square(h.x / x) + Square(h.y / y)) / (h.z * h.z);
  return std::exp(-slope2) / (kPi * x * y * Square(h.z * h.z));
}
inline double BeckmannLambda(Vec w, double x, double y) {
  const double across = std::hypot(x * w.x, y * w.y);
  if (across < 1e-12) return 0;
  const double a = std::fabs(w.z) / across;
  return std::exp(-a * a) / (2 * a * std::sqrt(kPi)) - 0.5 * std::erfc(a);
}

}  // namespace skywave
