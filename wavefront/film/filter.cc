#include "wavefront/film/filter.h"

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <glm/gtc/constants.hpp>

#include "kernels/camera.h"

namespace skywave {
namespace {

// Returns the cubic of Mitchell and Netravali 1988 with B = C = 1/3, of radius 2.
double Mitchell(double x) {
  const double t = std::fabs(x);
  if (t > 2) return 0;
  return t < 1 ? ((7 * t - 12) * t * t + 16.0 / 3) / 6
               : (((-7.0 / 3 * t + 12) * t - 20) * t + 32.0 / 3) / 6;
}

double Sinc(double x) {
  const double t = glm::pi<double>() * x;
  return std::fabs(t) < 1e-6 ? 1 : std::sin(t) / t;
}

// Returns the weight at `x` radii, |x| <= 1, of a filter of a radius [pixels], not normalised.
double FilterWeight(PixelFilter filter, double radius, double x) {
  switch (filter) {
    case PixelFilter::kBox:
      return 1;
    case PixelFilter::kTriangle:
      return 1 - std::fabs(x);
    case PixelFilter::kGaussian: {
      // The standard deviation is a third of the radius; the curve is lowered to reach 0 at the
      // rim.
      const auto gauss = [](double t) { return std::exp(-0.5 * 9 * t * t); };
      return gauss(x) - gauss(1);
    }
    case PixelFilter::kBlackmanHarris: {
      // This is the four-term window (Harris 1978).
      const double t = glm::pi<double>() * (x + 1);
      return 0.35875 - 0.48829 * std::cos(t) + 0.14128 * std::cos(2 * t) -
             0.01168 * std::cos(3 * t);
    }
    case PixelFilter::kMitchell:
      return Mitchell(2 * x);
    case PixelFilter::kSinc:
      // The window is pbrt's, of tau 3.
      return Sinc(x * radius) * Sinc(x * radius / 3);
  }
  return 0;
}

}  // namespace

float DefaultFilterRadius(PixelFilter filter) {
  switch (filter) {
    case PixelFilter::kBox:
      return 0.5f;
    case PixelFilter::kTriangle:
      return 1.0f;
    case PixelFilter::kGaussian:
      return 1.5f;
    case PixelFilter::kBlackmanHarris:
      return 1.5f;
    case PixelFilter::kMitchell:
      return 2.0f;
    case PixelFilter::kSinc:
      return 4.0f;
  }
  return 0.5f;
}

std::vector<float> FilterOffsets(PixelFilter filter, float radius) {
  constexpr int kSteps = 1 << 14;
  std::vector<double> cumulative(kSteps + 1, 0.0);
  for (int i = 0; i < kSteps; ++i) {
    cumulative[i + 1] =
        cumulative[i] + std::fabs(FilterWeight(filter, radius, 2 * (i + 0.5) / kSteps - 1));
  }
  std::vector<float> offsets(kFilterCells + 1);
  int step = 0;
  for (std::uint32_t cell = 0; cell <= kFilterCells; ++cell) {
    const double target = cumulative[kSteps] * cell / kFilterCells;
    while (step < kSteps - 1 && cumulative[step + 1] < target) ++step;
    const double width = cumulative[step + 1] - cumulative[step];
    const double inside = width > 0 ? (target - cumulative[step]) / width : 0;
    offsets[cell] = float(radius * (2 * (step + inside) / kSteps - 1));
  }
  return offsets;
}

std::vector<float> FilterFactors(PixelFilter filter, float radius,
                                 const std::vector<float>& offsets) {
  if (!HasSigns(filter)) return {};
  constexpr int kSteps = 64;
  std::vector<double> integrals(kFilterCells);
  double whole = 0;
  for (std::uint32_t cell = 0; cell < kFilterCells; ++cell) {
    const double width = (double(offsets[cell + 1]) - offsets[cell]) / kSteps;
    for (int i = 0; i < kSteps; ++i) {
      const double at = offsets[cell] + (i + 0.5) * width;
      integrals[cell] += FilterWeight(filter, radius, at / radius) * width;
    }
    whole += integrals[cell];
  }
  std::vector<float> factors(kFilterCells);
  for (std::uint32_t cell = 0; cell < kFilterCells; ++cell) {
    factors[cell] = float(kFilterCells * integrals[cell] / whole);
  }
  return factors;
}

std::vector<float> FilterDensities(const std::vector<float>& offsets, float radius) {
  // The cumulative distribution is linear between the offsets.
  std::size_t k = 0;
  const auto cumulative = [&](double t) {
    while (k < kFilterCells && offsets[k + 1] < t) ++k;
    if (k == kFilterCells) return 1.0;
    const double width = double(offsets[k + 1]) - offsets[k];
    const double inside = width > 0 ? std::clamp((t - offsets[k]) / width, 0.0, 1.0) : 1;
    return (double(k) + inside) / kFilterCells;
  };
  std::vector<float> densities(kFilterCells);
  const double cell = 2 * double(radius) / kFilterCells;
  double below = 0;
  for (std::size_t i = 0; i < kFilterCells; ++i) {
    const bool last = i + 1 == kFilterCells;
    const double up_to = last ? 1 : cumulative(double(i + 1) * cell - radius);
    densities[i] = float((up_to - below) / cell);
    below = up_to;
  }
  return densities;
}

}  // namespace skywave
