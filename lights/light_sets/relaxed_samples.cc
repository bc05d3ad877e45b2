#include "lights/light_sets/relaxed_samples.h"

#include <algorithm>
#include <numeric>
#include <random>
#include <utility>

#include "base/error.h"
#include "lights/light_sets/voronoi.h"

namespace skywave {
namespace {

constexpr int kMostSteps = 30;     // until samples stand still
constexpr double kStill = 1e-3;    // [rad]
constexpr int kStepsOfARound = 3;  // between rounds of new samples

void Relax(const SphereMap& map, int steps, std::vector<Vector3>& samples) {
  for (int step = 0; step < steps; ++step) {
    std::vector<Vector3> moved = LloydStep(map, samples);
    double farthest = 0;
    for (std::size_t i = 0; i < samples.size(); ++i) {
      farthest = std::max(farthest, Length(moved[i] - samples[i]));
    }
    samples = std::move(moved);
    if (farthest < kStill) return;
  }
}

Vector3 Direction(const SphereMap& map, std::size_t texel) {
  return map.TexelCentre(int(texel % std::size_t(map.width)), int(texel / std::size_t(map.width)));
}

double Energy(const SphereMap& map, std::size_t texel) {
  return map.Energy(int(texel % std::size_t(map.width)), int(texel / std::size_t(map.width)));
}

// Returns for every cell the texel where energy times square of the distance to the cell's sample
// is largest; the number of texels for cells in which fewer than two have energy.
std::vector<std::size_t> FarTexels(const SphereMap& map, const CellMap& cells,
                                   const std::vector<Vector3>& samples) {
  std::vector<std::size_t> texel(samples.size(), map.texels());
  std::vector<double> most(samples.size());
  std::vector<int> lit(samples.size());
  for (std::size_t i = 0; i < cells.size(); ++i) {
    const Vector3 apart = Direction(map, i) - samples[cells[i]];
    const double moment = Energy(map, i) * Dot(apart, apart);
    lit[cells[i]] += moment > 0;
    if (moment > most[cells[i]]) most[cells[i]] = moment, texel[cells[i]] = i;
  }
  for (std::size_t cell = 0; cell < lit.size(); ++cell) {
    if (lit[cell] < 2) texel[cell] = map.texels();
  }
  return texel;
}

// Adds samples in the cells of most energy until there are `count`, or until no cell can be
// divided; relaxes between rounds, of which each divides up to half of the cells.
void AddSamples(const SphereMap& map, std::size_t count, std::vector<Vector3>& samples) {
  while (samples.size() < count) {
    const CellMap cells = VoronoiCells(map.width, map.height, samples);
    const std::vector<CellSums> sums = SumCells(map, cells, samples.size());
    const std::vector<std::size_t> far = FarTexels(map, cells, samples);
    std::vector<std::size_t> order(samples.size());
    std::iota(order.begin(), order.end(), std::size_t{0});
    std::stable_sort(order.begin(), order.end(),
                     [&](std::size_t a, std::size_t b) { return sums[a].energy > sums[b].energy; });
    const std::size_t before = samples.size();
    const std::size_t goal = std::min(count, before + std::max(std::size_t{1}, before / 2));
    for (const std::size_t cell : order) {
      if (samples.size() == goal) break;
      if (far[cell] < map.texels()) samples.push_back(Direction(map, far[cell]));
    }
    if (samples.size() == before) break;
    Relax(map, kStepsOfARound, samples);
  }
}

// Returns the samples whose cells have light.
std::vector<Vector3> LitSamples(const SphereMap& map, std::span<const Vector3> samples) {
  const CellMap cells = VoronoiCells(map.width, map.height, samples);
  const std::vector<CellSums> sums = SumCells(map, cells, samples.size());
  std::vector<Vector3> lit;
  for (std::size_t i = 0; i < samples.size(); ++i) {
    if (sums[i].energy > 0) lit.push_back(samples[i]);
  }
  return lit;
}

}  // namespace

std::vector<Vector3> KMeansSamples(const SphereMap& map, int count, std::uint64_t seed) {
  if (count < 1) throw InputError({}, "k-means needs at least one light");
  if (!(map.energy > 0)) return {};
  // One draw in each of `count` equal parts of the energy. In place of a texel that is drawn again
  // stands the next one with energy.
  std::vector<Vector3> samples;
  std::mt19937_64 random(seed);
  std::vector<bool> taken(map.texels());
  double below = 0;
  std::size_t drawn = 0;
  for (int k = 0; k < count; ++k) {
    const double jitter = double(random() >> 11) * 0x1p-53;
    const double wanted = (k + jitter) / count * map.energy;
    while (drawn + 1 < map.texels() && below + Energy(map, drawn) <= wanted) {
      below += Energy(map, drawn++);
    }
    std::size_t texel = drawn, tried = 0;
    while (tried < map.texels() && (taken[texel] || !(Energy(map, texel) > 0))) {
      texel = (texel + 1) % map.texels(), ++tried;
    }
    if (tried == map.texels()) break;
    taken[texel] = true;
    samples.push_back(Direction(map, texel));
  }
  Relax(map, kMostSteps, samples);
  return samples;
}

std::vector<Vector3> FollowingSamples(const SphereMap& map, std::span<const Vector3> before) {
  if (!(map.energy > 0)) return {};
  std::vector<Vector3> samples = LitSamples(map, before);
  AddSamples(map, before.size(), samples);
  Relax(map, kMostSteps, samples);
  return samples;
}

std::vector<Vector3> KolligKellerSamples(const SphereMap& map, int count) {
  if (count < 1) throw InputError({}, "Kollig and Keller's method needs at least one light");
  if (!(map.energy > 0)) return {};
  std::vector<Vector3> samples = LloydStep(map, std::vector<Vector3>{{0, 0, 1}});
  AddSamples(map, std::size_t(count), samples);
  Relax(map, kMostSteps, samples);
  return samples;
}

}  // namespace skywave
