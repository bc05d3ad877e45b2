// Tests the colours of thin films against Airy's formula over all wavelengths.
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>

#include "tests/support/layered_formulas.h"

namespace skywave {
namespace {

// Returns the light that a film reflects, whatever the number of times that it crosses the film:
// Airy's formula with the roots of Schlick's reflectances, whose difference from its mean over all
// phases is integrated over wave numbers with the colour matching functions whose Fourier
// transforms Belcour and Barla 2017 give.
glm::dvec3 IntegratedFilm(double f0, double ior, double nm, double cosine) {
  const auto schlick = [](double at_normal, double c) {
    return at_normal + (1 - at_normal) * std::pow(1 - c, 5);
  };
  const double inner = std::sqrt(1 - (1 - cosine * cosine) / (ior * ior));
  const double below = (1 + std::sqrt(f0)) / (1 - std::sqrt(f0));
  const double bottom = (ior - below) / (ior + below);
  const double r12 = -std::sqrt(schlick(std::pow((ior - 1) / (ior + 1), 2), cosine));
  const double r23 = std::copysign(std::sqrt(schlick(bottom * bottom, inner)), bottom);
  const double path = 2e-9 * ior * nm * inner, both = r12 * r12 * r23 * r23;
  const double steady = r12 * r12 + std::pow(1 - r12 * r12, 2) * r23 * r23 / (1 - both);
  constexpr double kCurves[4][3] = {{5.4856e-13, 1.6810e6, 4.3278e9},
                                    {9.7470e-14, 2.2399e6, 4.5282e9},
                                    {4.4201e-13, 1.7953e6, 9.3046e9},
                                    {5.2481e-13, 2.2084e6, 6.6121e9}};
  double sums[4] = {};
  for (int i = 0; i < 4; ++i) {
    const double deviation = std::sqrt(2 * kCurves[i][2]);
    constexpr int kSteps = 4000;
    for (int k = 0; k < kSteps; ++k) {
      const double z = -6 + 12 * (k + 0.5) / kSteps;
      const double number = kCurves[i][1] + z * deviation;
      const double cross = 2 * r12 * r23 * std::cos(2 * kPi * number * path);
      const double reflected = (r12 * r12 + r23 * r23 + cross) / (1 + both + cross);
      sums[i] += (reflected - steady) * std::exp(-z * z / 2) / std::sqrt(2 * kPi) * 12 / kSteps;
    }
    sums[i] *= kCurves[i][0] * std::sqrt(2 * kPi * kCurves[i][2]) / 1.0685e-7;
  }
  const double x = sums[0] + sums[1], y = sums[2], z = sums[3];
  return steady + glm::dvec3(3.2404542 * x - 1.5371385 * y - 0.4985314 * z,
                             -0.9692660 * x + 1.8760108 * y + 0.0415560 * z,
                             0.0556434 * x - 0.2040259 * y + 1.0572252 * z);
}

// What the formula leaves out are waves that cross the film six times and more.
TEST(ThinFilm, IsTheIntegralOfAirysFormula) {
  double spread = 0;
  for (const double f0 : {0.04, 0.3, 0.9}) {
    for (const double ior : {1.3, 1.8}) {
      for (const double nm : {150.0, 320.0, 550.0, 900.0}) {
        for (const double cosine : {1.0, 0.7, 0.35}) {
          const glm::dvec3 exact = IntegratedFilm(f0, ior, nm, cosine);
          const glm::dvec3 closed = ThinFilmFormula(glm::dvec3(f0), ior, nm, cosine);
          for (int c = 0; c < 3; ++c) {
            const double limited = std::clamp(exact[c], 0.0, 1.0);
            spread = std::max(spread, std::abs(closed[c] - closed[(c + 1) % 3]));
            EXPECT_NEAR(closed[c], limited, f0 > 0.5 ? 0.02 : 0.01)
                << f0 << ", " << ior << ", " << nm << " nm, " << cosine << ", channel " << c;
          }
        }
      }
    }
  }
  EXPECT_GT(spread, 0.2) << "films have colours";
}

// A film that is too thin to be one, or of the index of air, is not there; but for grazing light,
// which Schlick's formula reflects at its top whatever its index. Its waves are at least those of
// reflectances of 1e-5.
TEST(ThinFilm, VanishesWithItsThickness) {
  for (const double f0 : {0.04, 0.5}) {
    EXPECT_NEAR(ThinFilmFormula(glm::dvec3(f0), 1.5, 0, 1).y, f0, 0.01);
    EXPECT_NEAR(ThinFilmFormula(glm::dvec3(f0), 1, 500, 1).y, f0, 0.01);
  }
}

}  // namespace
}  // namespace skywave
