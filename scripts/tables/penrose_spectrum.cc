// Draws a Penrose sample pattern of a constant map and the mean power spectrum of many such
// patterns as a PNG, side by side, and prints the radial mean of the power: white noise has 1
// everywhere, blue noise almost nothing below half the principal frequency, sqrt(density).
//
//   penrose_spectrum FILE.png
#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <complex>
#include <numbers>

#include "image/image.h"
#include "lights/light_sets/penrose.h"
#include "lights/tables/max_pyramid.h"

using namespace skywave;

namespace {

constexpr int kSide = 256;      // side of each picture [pixels]; kSide / 2 is the highest frequency
constexpr int kSamples = 2000;  // about, per pattern
constexpr int kPatterns = 32;
using Complex = std::complex<float>;

// Adds the periodogram of one pattern, under a Hann window, divided by that of white noise.
void AddPeriodogram(const PenroseSet& set, std::vector<double>& power) {
  const int half = kSide / 2;
  std::vector<Complex> amplitude(std::size_t(kSide) * kSide);
  double norm = 0;
  for (const PenroseSample& s : set.samples) {
    const double window =
        std::pow(std::sin(std::numbers::pi * s.u) * std::sin(std::numbers::pi * s.v), 2);
    norm += window * window;
    Complex across[kSide];
    for (int k = -half; k < half; ++k) {
      across[k + half] = Complex(std::polar(1.0, 2 * std::numbers::pi * k * s.u));
    }
    for (int ky = -half; ky < half; ++ky) {
      const Complex down(std::polar(window, 2 * std::numbers::pi * ky * s.v));
      Complex* row = &amplitude[std::size_t(ky + half) * kSide];
      for (int kx = 0; kx < kSide; ++kx) row[kx] += down * across[kx];
    }
  }
  for (std::size_t i = 0; i < power.size(); ++i)
    power[i] += std::norm(amplitude[i]) / norm / kPatterns;
}

}  // namespace

int main(int argc, char** argv) {
  if (argc != 2) {
    fmt::print(stderr, "usage: penrose_spectrum FILE.png\n");
    return 64;
  }
  const MaxPyramid plane = MakeMaxPyramid(64, 64, std::vector<float>(64 * 64, 1.0f));
  std::vector<double> power(std::size_t(kSide) * kSide);
  PenroseSet shown;
  for (int pattern = 0; pattern < kPatterns; ++pattern) {
    // Sizes differ, so that the tiling is cut by the square at other phases of its self-similarity.
    shown = PenroseSamples(plane, kSamples + 40 * pattern, {.seed = std::uint64_t(pattern + 1)});
    AddPeriodogram(shown, power);
  }

  std::vector<std::uint8_t> rgb(std::size_t(2 * kSide) * kSide * 3, 255);
  const auto set = [&](int x, int y, double grey) {
    std::fill_n(&rgb[(std::size_t(y) * 2 * kSide + x) * 3], 3,
                std::uint8_t(std::clamp(grey, 0.0, 1.0) * 255));
  };
  for (const PenroseSample& s : shown.samples) set(int(s.u * kSide), int(s.v * kSide), 0);
  for (int y = 0; y < kSide; ++y) {
    for (int x = 0; x < kSide; ++x) set(kSide + x, y, power[std::size_t(y) * kSide + x] / 2);
  }
  WritePng(argv[1], 2 * kSide, kSide, rgb);

  fmt::print("cycles a side   power (white noise: 1; principal frequency: {:.0f})\n",
             std::sqrt(kSamples));
  for (int ring = 4; ring < kSide / 2; ring += 8) {
    double sum = 0;
    int count = 0;
    for (int y = 0; y < kSide; ++y) {
      for (int x = 0; x < kSide; ++x) {
        const double f = std::hypot(x - kSide / 2, y - kSide / 2);
        if (f < ring || f >= ring + 8) continue;
        sum += power[std::size_t(y) * kSide + x];
        ++count;
      }
    }
    fmt::print("{:>5} to {:<5}  {:.3f}\n", ring, ring + 8, sum / count);
  }
}
