// Prints the relative bias of directional lights of a map (lights/light_sets/light_bias.h) by who
// places them and by their number: the root mean square over 16 patterns, the least and the most.
//
//   light_bias MAP
#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <cstdint>

#include "base/error.h"
#include "image/image.h"
#include "lights/light_sets/light_bias.h"
#include "lights/light_sets/light_builder.h"

using namespace skywave;

namespace {

constexpr int kPatterns = 16;

void Print(const SphereMap& map, const LightBias& bias, LightOptions options) {
  double squares = 0, least = 1e9, most = 0;
  for (int seed = 1; seed <= kPatterns; ++seed) {
    options.seed = std::uint64_t(seed);
    const double value = bias.Of(BuildLights(map, options).lights);
    squares += value * value / kPatterns;
    least = std::min(least, value), most = std::max(most, value);
  }
  fmt::print("{:>5} {:<13} {:.4f} ({:.4f} to {:.4f})\n", options.lights, ToString(options.source),
             std::sqrt(squares), least, most);
}

}  // namespace

int main(int argc, char** argv) {
  if (argc != 2) {
    fmt::print(stderr, "usage: light_bias MAP\n");
    return kExitUsage;
  }
  const Image image = ReadImage(argv[1]);
  const SphereMap map = MakeSphereMap(image);
  const LightBias bias(map);
  for (const int lights : {16, 64, 256, 1024}) {
    for (const auto& source : kEnumNames<LightSource>) {
      Print(map, bias, {.source = source.value, .lights = lights});
    }
  }
}
