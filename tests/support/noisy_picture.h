// Pictures whose truth and noise are known, with the layers that the denoiser reads.
#pragma once

#include <bit>
#include <cmath>
#include <cstdint>
#include <functional>
#include <random>
#include <stdexcept>
#include <string>
#include <vector>

#include "job/denoise/denoise.h"

namespace skywave {

inline constexpr int kSide = 96;
inline constexpr int kSamples = 16;

// What a pixel shows.
struct Pixel {
  double light = 1, deviation = 0.5;  // mean and standard deviation of a sample
  double albedo = 1, coverage = 1;
};
using Truth = std::function<Pixel(int x, int y)>;

// A picture with its layers, as the film resolves them.
struct Noisy {
  Image image;
  std::vector<NamedChannel> layers;

  std::vector<float>& at(const std::string& name) {
    for (NamedChannel& layer : layers) {
      if (layer.name == name) return layer.values;
    }
    throw std::out_of_range(name);
  }
};

inline double TrueValue(const Pixel& pixel) { return pixel.light * pixel.albedo; }

// Draws the samples of every pixel, the same for all channels, from a normal distribution. One in
// `period` of them is in the second half.
inline Noisy Draw(const Truth& truth, std::uint32_t seed, int width = kSide, int height = kSide,
                  int period = 2) {
  Noisy noisy{.image = Image(width, height), .layers = {}};
  for (const std::string& name : DenoiserChannels()) {
    noisy.layers.push_back({name, std::vector<float>(std::size_t(width) * height, 0)});
  }
  for (int y = 0; y < height; ++y) {
    for (int x = 0; x < width; ++x) {
      // The samples of a pixel are its own, however large the picture is.
      std::mt19937_64 random(seed * 1000003ull + std::uint64_t(y) * 8192 + std::uint64_t(x));
      std::normal_distribution<double> normal;
      const Pixel pixel = truth(x, y);
      double sums[2] = {0, 0}, squares[2] = {0, 0};
      int second = 0;
      for (int i = 0; i < kSamples; ++i) {
        const double value = TrueValue(pixel) + pixel.deviation * pixel.albedo * normal(random);
        const bool is_second = i % period == period - 1;
        second += is_second;
        sums[is_second] += value, squares[is_second] += value * value;
      }
      const auto variance = [](double n, double sum, double square) {
        return (square - sum * sum / n) / (n - 1);
      };
      const std::size_t i = std::size_t(y) * width + x;
      const double all = sums[0] + sums[1];
      noisy.at("samples.V")[i] = kSamples;
      noisy.at("half.N")[i] = float(second);
      noisy.at("coverage.V")[i] = float(pixel.coverage);
      noisy.at("depth.Z")[i] = 4;
      noisy.at("shading-normal.Z")[i] = 1;
      for (int c = 0; c < 3; ++c) {
        const std::string letter(1, "RGB"[c]);
        noisy.image.rgb[3 * i + std::size_t(c)] = float(all / kSamples);
        noisy.at("half." + letter)[i] = float(sums[1] / second);
        noisy.at("variance." + letter)[i] = float(variance(kSamples, all, squares[0] + squares[1]));
        noisy.at("half-variance." + letter)[i] = float(variance(second, sums[1], squares[1]));
        noisy.at("albedo." + letter)[i] = float(pixel.albedo);
      }
    }
  }
  return noisy;
}

inline Denoised Clean(const Noisy& noisy, Denoiser by = Denoiser::kStatistics) {
  return Denoise(by, "noisy.exr", noisy.image, noisy.layers);
}

inline double SquaredError(const Image& image, const Truth& truth) {
  double sum = 0;
  for (int y = 0; y < image.height; ++y) {
    for (int x = 0; x < image.width; ++x) {
      const double error =
          image.rgb[3 * (std::size_t(y) * image.width + x)] - TrueValue(truth(x, y));
      sum += error * error;
    }
  }
  return sum / image.width / image.height;
}

// Returns the share of pixels whose truth is within 1.96 times the estimated error.
inline double Coverage(const Denoised& clean, const Truth& truth) {
  int inside = 0;
  const int width = clean.image.width;
  for (int y = 0; y < clean.image.height; ++y) {
    for (int x = 0; x < width; ++x) {
      const std::size_t i = std::size_t(y) * width + x;
      const double error = std::abs(clean.image.rgb[3 * i] - TrueValue(truth(x, y)));
      inside += error <= 1.96 * clean.error[0].values[i];
    }
  }
  return double(inside) / width / clean.image.height;
}

inline double Sum(const Image& image) {
  double sum = 0;
  for (const float value : image.rgb) sum += value;
  return sum;
}

inline std::vector<std::uint32_t> Bits(const Denoised& clean) {
  std::vector<std::uint32_t> bits;
  for (const float value : clean.image.rgb) bits.push_back(std::bit_cast<std::uint32_t>(value));
  for (const NamedChannel& channel : clean.error) {
    for (const float value : channel.values) bits.push_back(std::bit_cast<std::uint32_t>(value));
  }
  return bits;
}

inline Pixel Flat(int, int) { return {}; }
inline Pixel Steps(int x, int) { return {.light = x < kSide / 2 ? 1.0 : 3.0}; }
inline Pixel Checkered(int x, int y) { return {.albedo = (x / 2 + y / 2) % 2 == 0 ? 0.2 : 0.8}; }
inline Pixel Slope(int x, int y) { return {.light = 1 + 0.01 * x + 0.005 * y}; }

}  // namespace skywave
