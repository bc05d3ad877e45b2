#include "lights/light_sets/strata.h"

#include <tbb/parallel_for.h>
#include <tbb/parallel_sort.h>

#include <algorithm>
#include <bit>
#include <cmath>
#include <limits>
#include <numbers>

#include "base/error.h"

namespace skywave {
namespace {

constexpr double kPi = std::numbers::pi;

// Returns texel indices by descending luminance, then ascending index. The order of non-negative
// floats is that of their bits.
std::vector<std::uint64_t> SortedTexels(const SphereMap& map) {
  std::vector<std::uint64_t> keys(map.texels());
  tbb::parallel_for(std::size_t(0), keys.size(), [&](std::size_t i) {
    const std::uint32_t bits = std::bit_cast<std::uint32_t>(std::max(map.luminance[i], 0.0f));
    keys[i] = std::uint64_t(~bits) << 32 | i;
  });
  tbb::parallel_sort(keys.begin(), keys.end());
  for (std::uint64_t& key : keys) key &= 0xFFFFFFFFu;
  return keys;
}

// Returns the strata whose A is sorted[0, count).
Strata Divide(const SphereMap& map, const std::vector<std::uint64_t>& sorted, std::size_t count) {
  Strata strata;
  strata.in_a.resize(map.texels());
  for (std::size_t i = 0; i < count; ++i) strata.in_a[sorted[i]] = 1;
  for (int y = 0; y < map.height; ++y) {
    double energy[2] = {};
    std::size_t texels[2] = {};
    for (int x = 0; x < map.width; ++x) {
      const std::size_t i = std::size_t(y) * map.width + x;
      energy[strata.in_a[i]] += map.luminance[i];
      ++texels[strata.in_a[i]];
    }
    strata.energy_b += energy[0] * map.solid_angle[y];
    strata.energy_a += energy[1] * map.solid_angle[y];
    strata.solid_angle_b += double(texels[0]) * map.solid_angle[y];
    strata.solid_angle_a += double(texels[1]) * map.solid_angle[y];
  }
  strata.texels_a = count;
  strata.texels_b = map.texels() - count;
  if (map.energy > 0) strata.p = strata.energy_a / (strata.energy_a + strata.energy_b);
  strata.threshold =
      count > 0 ? map.luminance[sorted[count - 1]] : std::numeric_limits<float>::infinity();
  return strata;
}

// Returns the length of the shortest prefix over which weight(texel, row) adds up to `target`;
// `noise` forgives the rounding of that sum.
template <class Weight>
std::size_t PrefixOf(const SphereMap& map, const std::vector<std::uint64_t>& sorted, double target,
                     double noise, const Weight& weight) {
  double sum = 0;
  std::size_t count = 0;
  while (count < sorted.size() && sum < target - noise) {
    sum += weight(sorted[count], sorted[count] / map.width);
    ++count;
  }
  return count;
}

}  // namespace

Strata StrataByFraction(const SphereMap& map, double p) {
  if (!(p >= 0 && p <= 1)) throw InputError({}, "the fraction of the energy must be in [0, 1]");
  const std::vector<std::uint64_t> sorted = SortedTexels(map);
  const auto energy = [&](std::size_t texel, std::size_t row) {
    return map.luminance[texel] * map.solid_angle[row];
  };
  return Divide(map, sorted, PrefixOf(map, sorted, p * map.energy, 1e-12 * map.energy, energy));
}

Strata StrataByLights(const SphereMap& map, int lights, double separation) {
  if (lights < 0) throw InputError({}, "the number of lights must not be negative");
  if (!(separation >= 0 && separation <= 2 * kPi)) {
    throw InputError({}, "the separation of lights must be in [0, 360] degrees");
  }
  const std::vector<std::uint64_t> sorted = SortedTexels(map);
  const double cap = 4 * kPi * std::pow(std::sin(separation / 4), 2);  // 2 pi (1 - cos(a / 2))
  const auto area = [&](std::size_t, std::size_t row) { return map.solid_angle[row]; };
  return Divide(map, sorted, PrefixOf(map, sorted, lights * cap, 1e-12 * 4 * kPi, area));
}

namespace {

// Calls f(texels, prefix) for each prefix of the sorted texels.
template <class F>
void ForEachPrefix(const SphereMap& map, const std::vector<std::uint64_t>& sorted, const F& f) {
  const double brightest = map.luminance[sorted.front()], dimmest = map.luminance[sorted.back()];
  StratumPrefix prefix;
  for (std::size_t i = 0; i < sorted.size(); ++i) {
    const double solid_angle = map.solid_angle[sorted[i] / map.width];
    prefix.luminance = map.luminance[sorted[i]];
    prefix.area += solid_angle;
    prefix.energy += prefix.luminance * solid_angle;
    prefix.zeta = (brightest + prefix.luminance) / 2 * prefix.area +
                  (prefix.luminance + dimmest) / 2 * (4 * kPi - prefix.area);
    f(i + 1, prefix);
  }
}

}  // namespace

std::vector<StratumPrefix> PrefixesOf(const SphereMap& map, std::size_t most) {
  const std::vector<std::uint64_t> sorted = SortedTexels(map);
  const double step = std::log(double(sorted.size())) / double(std::max<std::size_t>(most, 2) - 1);
  std::vector<StratumPrefix> prefixes;
  ForEachPrefix(map, sorted, [&](std::size_t texels, const StratumPrefix& prefix) {
    const double due = step * double(prefixes.size());
    if (texels < sorted.size() && std::log(double(texels)) < due - 1e-9) return;
    if (prefixes.size() < most) prefixes.push_back(prefix);
    if (texels == sorted.size()) prefixes.back() = prefix;
  });
  return prefixes;
}

Strata StrataByVariation(const SphereMap& map, double* zeta_minimum) {
  const std::vector<std::uint64_t> sorted = SortedTexels(map);
  const double brightest = map.luminance[sorted.front()], dimmest = map.luminance[sorted.back()];
  if (zeta_minimum) *zeta_minimum = brightest * map.AreaInPixels(4 * kPi);
  if (brightest == dimmest) return Divide(map, sorted, 0);
  double best = std::numeric_limits<double>::infinity();
  std::size_t count = 0;
  ForEachPrefix(map, sorted, [&](std::size_t texels, const StratumPrefix& prefix) {
    if (prefix.zeta < best) best = prefix.zeta, count = texels;
  });
  if (zeta_minimum) *zeta_minimum = map.AreaInPixels(best);
  return Divide(map, sorted, count);
}

Strata DivideMap(const SphereMap& map, const StrataRequest& request) {
  switch (request.kind) {
    case StrataRequest::Kind::kFraction:
      return StrataByFraction(map, request.fraction);
    case StrataRequest::Kind::kLights:
      return StrataByLights(map, request.lights, request.separation);
    case StrataRequest::Kind::kVariation:
      break;
  }
  return StrataByVariation(map);
}

Image StratumImage(const SphereMap& map, const Strata& strata, bool a) {
  Image image(map.width, map.height);
  for (std::size_t i = 0; i < map.texels(); ++i) {
    if ((strata.in_a[i] != 0) == a) {
      std::copy_n(&map.image->rgb[3 * i], 3, &image.rgb[3 * i]);
    }
  }
  return image;
}

}  // namespace skywave
