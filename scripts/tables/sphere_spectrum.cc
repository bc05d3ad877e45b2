// Prints the mean power spectrum on the sphere of samples of a constant map, by who places them.
// The columns are degrees of spherical harmonics; white noise has 1 everywhere.
//
//   sphere_spectrum [SAMPLES]
#include <fmt/format.h>

#include <cmath>
#include <cstdlib>
#include <numbers>
#include <random>
#include <string>
#include <vector>

#include "lights/light_sets/light_builder.h"
#include "lights/light_sets/penrose.h"
#include "lights/light_sets/polyomino.h"
#include "lights/light_sets/sphere_spectrum.h"
#include "lights/tables/max_pyramid.h"

using namespace skywave;

namespace {

constexpr int kPatterns = 8;

std::vector<Vector3> MakePattern(const std::string& method, const SphereMap& map, int count,
                                 int index) {
  const auto seed = std::uint64_t(index + 1);
  if (method == "penrose") {
    return Directions(PenroseSamples(ImportancePyramid(map), count, {.seed = seed}));
  }
  if (method == "polyomino") return Directions(PolyominoSamples(map, count, seed));
  std::vector<Vector3> directions;
  if (method == "variance-cut") {
    for (const DirectionalLight& light :
         BuildLights(map, {.source = LightSource::kVarianceCut, .lights = count}).lights) {
      directions.push_back(light.direction);
    }
    return directions;
  }
  std::mt19937_64 random(seed);
  std::uniform_real_distribution<double> uniform;
  for (int i = 0; i < count; ++i) {
    const double up = 2 * uniform(random) - 1, turn = 2 * std::numbers::pi * uniform(random);
    const double across = std::sqrt(1 - up * up);
    directions.push_back({across * std::sin(turn), across * std::cos(turn), up});
  }
  return directions;
}

}  // namespace

int main(int argc, char** argv) {
  const int count = argc > 1 ? std::max(std::atoi(argv[1]), 1) : 1000;
  Image white(512, 256);
  std::fill(white.rgb.begin(), white.rgb.end(), 1.0f);
  const SphereMap map = MakeSphereMap(white);
  const double principal = 1.07 * std::sqrt(std::numbers::pi * count);
  constexpr int kColumns = 12;
  const int width = std::max(int(principal / 5), 1), degrees = kColumns * width;
  fmt::print("{:<13}", "degrees to");
  for (int i = 1; i <= kColumns; ++i) fmt::print("{:>7}", i * width);
  fmt::print("   (principal: {:.0f})\n", principal);
  for (const char* method : {"random", "variance-cut", "penrose", "polyomino"}) {
    std::vector<double> power(kColumns);
    double largest = 0;
    for (int index = 0; index < kPatterns; ++index) {
      const std::vector<double> of_degree =
          SpherePower(MakePattern(method, map, count + count * index / kPatterns, index), degrees);
      for (int l = 1; l <= degrees; ++l) {
        power[std::size_t((l - 1) / width)] += of_degree[std::size_t(l)] / width / kPatterns;
        largest = std::max(largest, of_degree[std::size_t(l)]);
      }
    }
    fmt::print("{:<13}", method);
    for (const double value : power) fmt::print("{:>7.3f}", value);
    fmt::print("   largest {:.2f}\n", largest);
  }
}
