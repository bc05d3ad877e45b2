#include "lights/light_sets/structured.h"

#include <algorithm>
#include <cmath>
#include <numeric>

#include "base/error.h"

namespace skywave {
namespace {

constexpr double kEnergyNoise = 1e-12;  // of the whole map: what is left of a sum of its texels

// Texels that are connected, as trees (union by lower index).
class Connected {
 public:
  explicit Connected(std::size_t texels) : parent_(texels) {
    std::iota(parent_.begin(), parent_.end(), 0u);
  }
  std::uint32_t Root(std::uint32_t i) {
    while (parent_[i] != i) i = parent_[i] = parent_[parent_[i]];
    return i;
  }
  void Join(std::uint32_t a, std::uint32_t b) {
    a = Root(a), b = Root(b);
    parent_[std::max(a, b)] = std::min(a, b);
  }

 private:
  std::vector<std::uint32_t> parent_;
};

// Returns the number of thresholds above the lowest that the luminance of every texel reaches.
std::vector<std::uint8_t> Levels(const SphereMap& map, int levels) {
  double area = 0, mean = 0, square = 0;
  for (int y = 0; y < map.height; ++y) {
    for (int x = 0; x < map.width; ++x) {
      const double luminance =
          map.luminance[std::size_t(y) * std::size_t(map.width) + std::size_t(x)];
      area += map.solid_angle[std::size_t(y)];
      mean += luminance * map.solid_angle[std::size_t(y)];
      square += luminance * luminance * map.solid_angle[std::size_t(y)];
    }
  }
  mean /= area;
  const double deviation = std::sqrt(std::max(0.0, square / area - mean * mean));
  std::vector<std::uint8_t> level(map.texels());
  if (!(deviation > 1e-6 * mean)) return level;
  std::transform(map.luminance.begin(), map.luminance.end(), level.begin(), [&](float luminance) {
    return std::uint8_t(std::min(double(levels - 1), std::floor(luminance / deviation)));
  });
  return level;
}

// A connected part of the texels that reach a threshold, without those of the next one: these have
// parts of their own, whose texels come to it if they get no cell.
struct Part {
  std::vector<std::uint32_t> texels;
  std::uint32_t below = kNoCell;  // the part of the next lower threshold that it lies in
  double energy = 0, solid_angle = 0;

  void Add(const Part& other) {
    texels.insert(texels.end(), other.texels.begin(), other.texels.end());
    energy += other.energy, solid_angle += other.solid_angle;
  }
};

// Returns the parts from the highest threshold to the lowest, those of one in the order of their
// first texels.
std::vector<Part> PartsOf(const SphereMap& map, const std::vector<std::uint8_t>& level,
                          int levels) {
  const auto width = std::uint32_t(map.width), texels = std::uint32_t(level.size());
  Connected connected(texels);
  std::vector<Part> parts;
  // The part of each texel, of the threshold before and of this one.
  std::vector<std::uint32_t> above(texels, kNoCell), part_of_root(texels), here(texels);
  for (int at = levels - 1; at >= 0; --at) {
    for (std::uint32_t i = 0; i < texels; ++i) {
      if (level[i] != at) continue;
      const std::uint32_t x = i % width, row = i - x;
      const auto join = [&](std::uint32_t neighbour) {
        if (level[neighbour] >= at) connected.Join(i, neighbour);
      };
      join(row + (x + 1) % width), join(row + (x + width - 1) % width);
      if (row >= width) join(i - width);
      if (i + width < texels) join(i + width);
    }
    std::fill(part_of_root.begin(), part_of_root.end(), kNoCell);
    for (std::uint32_t i = 0; i < texels; ++i) {
      if (level[i] < at) continue;
      std::uint32_t& part = part_of_root[connected.Root(i)];
      if (part == kNoCell) {
        part = std::uint32_t(parts.size());
        parts.emplace_back();
      }
      here[i] = part;
      if (above[i] != kNoCell) {
        parts[above[i]].below = part;
      } else {
        parts[part].texels.push_back(i);
        parts[part].energy += map.Energy(int(i % width), int(i / width));
        parts[part].solid_angle += map.solid_angle[i / width];
      }
    }
    for (std::uint32_t i = 0; i < texels; ++i) above[i] = level[i] < at ? kNoCell : here[i];
  }
  return parts;
}

struct StrataCutter {
  const SphereMap& map;
  PlacedCells placed;

  Vector3 Direction(std::uint32_t texel) const {
    return map.TexelCentre(int(texel % std::uint32_t(map.width)),
                           int(texel / std::uint32_t(map.width)));
  }
  double Energy(std::uint32_t texel) const {
    return map.Energy(int(texel % std::uint32_t(map.width)), int(texel / std::uint32_t(map.width)));
  }
  double Importance(const Part& part, const StructuredParameters& parameters) const {
    return part.energy * std::pow(std::min(part.solid_angle, parameters.widest), parameters.power);
  }

  // Returns the texel of most light if there are no samples to stay away from.
  std::size_t FirstTexel(const std::vector<Vector3>& direction,
                         const std::vector<double>& energy) const {
    Vector3 moment;
    for (std::size_t i = 0; i < direction.size(); ++i) moment += energy[i] * direction[i];
    std::size_t best = 0;
    double nearest = -1e300;
    for (std::size_t i = 0; i < direction.size(); ++i) {
      const double along = Dot(moment, direction[i]);
      if (energy[i] > 0 && along > nearest) nearest = along, best = i;
    }
    return best;
  }

  // Cuts a part into at most `count` cells.
  void Cut(const Part& part, int count) {
    const std::size_t texels = part.texels.size();
    std::vector<Vector3> direction(texels);
    std::vector<double> energy(texels);
    for (std::size_t i = 0; i < texels; ++i) {
      direction[i] = Direction(part.texels[i]), energy[i] = Energy(part.texels[i]);
    }
    // Cosine of the angle to the nearest sample of all parts, and of this one.
    constexpr double kFar = -2;
    std::vector<double> any(texels, kFar), own(texels, kFar);
    for (const Vector3& sample : placed.samples) {
      for (std::size_t i = 0; i < texels; ++i) {
        any[i] = std::max(any[i], Dot(sample, direction[i]));
      }
    }
    std::vector<bool> taken(texels);
    for (int k = 0; k < count; ++k) {
      std::size_t farthest = texels;
      if (placed.samples.empty()) {
        farthest = FirstTexel(direction, energy);
      } else {
        for (std::size_t i = 0; i < texels; ++i) {
          if (taken[i] || !(energy[i] > 0)) continue;
          if (farthest == texels || any[i] < any[farthest]) farthest = i;
        }
      }
      if (farthest == texels) return;  // every texel with energy is a sample
      taken[farthest] = true;
      const Vector3 sample = direction[farthest];
      const auto cell = std::uint32_t(placed.samples.size());
      placed.samples.push_back(sample);
      for (std::size_t i = 0; i < texels; ++i) {
        const double cosine = i == farthest ? 2 : Dot(sample, direction[i]);
        any[i] = std::max(any[i], cosine);
        if (cosine <= own[i]) continue;
        own[i] = cosine;
        placed.cell_of_texel[part.texels[i]] = cell;
      }
    }
  }
};

}  // namespace

PlacedCells StructuredCells(const SphereMap& map, int count,
                            const StructuredParameters& parameters) {
  if (count < 1) throw InputError({}, "structured importance sampling needs at least one light");
  StrataCutter cutter = {map, {CellMap(map.texels(), kNoCell), {}}};
  if (!(map.energy > 0)) return std::move(cutter.placed);
  const std::vector<std::uint8_t> level = Levels(map, parameters.levels);

  std::vector<Part> parts = PartsOf(map, level, parameters.levels);
  double importance_left = 0, energy_left = map.energy;
  for (const Part& part : parts) importance_left += cutter.Importance(part, parameters);
  int samples_left = count;
  for (const Part& part : parts) {
    const double importance = cutter.Importance(part, parameters);
    const bool last = energy_left - part.energy <= kEnergyNoise * map.energy;
    const double share = importance_left > 0 ? std::min(1.0, importance / importance_left) : 1;
    const int samples =
        last ? samples_left : std::min(int(std::lround(samples_left * share)), samples_left - 1);
    importance_left = std::max(0.0, importance_left - importance);
    const auto before = cutter.placed.samples.size();
    if (part.energy > 0) cutter.Cut(part, samples);
    const auto placed = int(cutter.placed.samples.size() - before);
    samples_left -= placed;
    if (placed > 0) {
      energy_left -= part.energy;
    } else if (part.below != kNoCell) {
      parts[part.below].Add(part);
    }
  }
  return std::move(cutter.placed);
}

}  // namespace skywave
