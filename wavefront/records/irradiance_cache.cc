#include "wavefront/records/irradiance_cache.h"

#include <algorithm>
#include <bit>
#include <cmath>
#include <limits>
#include <numbers>
#include <utility>

#include "kernels/columns.h"

namespace skywave {
namespace {

constexpr float kTurn = 2 * std::numbers::pi_v<float>;

float Dot(const Triple& a, const Triple& b) { return a[0] * b[0] + a[1] * b[1] + a[2] * b[2]; }
Triple Cross(const Triple& a, const Triple& b) {
  return {a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]};
}
Triple Minus(const Triple& a, const Triple& b) { return {a[0] - b[0], a[1] - b[1], a[2] - b[2]}; }
void AddScaled(const Triple& a, float scale, Triple& sum) {
  for (std::size_t i = 0; i < 3; ++i) sum[i] += scale * a[i];
}
float Luminance(const Triple& rgb) {
  return kLuminance[0] * rgb[0] + kLuminance[1] * rgb[1] + kLuminance[2] * rgb[2];
}

// Returns the direction across the normal at `turns` of the azimuth.
Triple Across(const Axes& axes, float turns) {
  Triple direction = {};
  // Rounding to float hides in which last bit libraries differ.
  const double azimuth = 2 * std::numbers::pi * double(turns);
  AddScaled(axes.x, float(std::cos(azimuth)), direction);
  AddScaled(axes.y, float(std::sin(azimuth)), direction);
  return direction;
}

// Returns the squared sine of the angle to the normal at which a ring begins.
float SquaredSine(const HemisphereGrid& grid, std::uint32_t ring) {
  return float(ring) / float(grid.rings);
}

}  // namespace

HemisphereGrid GridOf(std::uint32_t rays) {
  const auto rings = std::max(1u, std::uint32_t(std::lround(std::sqrt(double(rays) / M_PI))));
  return {.rings = rings, .sectors = std::max(1u, (rays + rings / 2) / rings)};
}

Axes AxesAround(const Triple& n) {
  // Duff et al. 2017.
  const float sign = std::copysign(1.0f, n[2]), a = -1 / (sign + n[2]), b = n[0] * n[1] * a;
  return {.x = {1 + sign * n[0] * n[0] * a, sign * b, -sign * n[0]},
          .y = {b, sign + n[1] * n[1] * a, -n[1]},
          .z = n};
}

Triple DirectionInCell(const HemisphereGrid& grid, std::uint32_t cell, float u, float v,
                       const Axes& axes) {
  const float sine2 = (float(cell / grid.sectors) + u) / float(grid.rings);
  const Triple across = Across(axes, (float(cell % grid.sectors) + v) / float(grid.sectors));
  Triple direction = {};
  AddScaled(across, std::sqrt(sine2), direction);
  AddScaled(axes.z, std::sqrt(std::max(0.0f, 1 - sine2)), direction);
  return direction;
}

MeasuredIrradiance MeasureIrradiance(const HemisphereGrid& grid, const Axes& axes,
                                     std::span<const HemisphereSample> samples,
                                     std::span<const Triple> directions) {
  MeasuredIrradiance result = {};
  IrradianceRecord& record = result.record;
  record.normal = axes.z;
  const float weight = std::numbers::pi_v<float> / float(grid.count());
  const auto at = [&](std::uint32_t ring, std::uint32_t sector) {
    return ring * grid.sectors + sector;
  };
  const auto nearer = [&](std::uint32_t a, std::uint32_t b) {
    return 1 / std::min(samples[a].distance, samples[b].distance);
  };
  float inverse_distances = 0;
  for (std::uint32_t sector = 0; sector < grid.sectors; ++sector) {
    // The boundary to the sector before, the middle of the sector, and the direction in which the
    // azimuth grows there.
    const auto begin = float(sector) / float(grid.sectors);
    const Triple outwards = Across(axes, begin + 0.5f / float(grid.sectors));
    const Triple onwards = Across(axes, begin + 0.25f);
    const std::uint32_t before = (sector + grid.sectors - 1) % grid.sectors;
    for (std::uint32_t ring = 0; ring < grid.rings; ++ring) {
      const std::uint32_t cell = at(ring, sector), beside = at(ring, before);
      const HemisphereSample& sample = samples[cell];
      inverse_distances += 1 / sample.distance;
      // A turn about an axis moves directions along axis x direction, and the cosine with them;
      // samples already have the cosine as their density.
      const Triple& direction = directions[cell];
      const float cosine = std::max(Dot(direction, axes.z), 1e-3f);
      const Triple turned = Cross(axes.z, direction);
      const float inner2 = SquaredSine(grid, ring), outer2 = SquaredSine(grid, ring + 1);
      const float side = (std::sqrt(outer2) - std::sqrt(inner2)) * nearer(cell, beside);
      for (std::size_t c = 0; c < 3; ++c) {
        record.irradiance[c] += weight * sample.radiance[c];
        AddScaled(turned, weight * sample.radiance[c] / cosine, record.turn[c]);
        AddScaled(onwards, side * (sample.radiance[c] - samples[beside].radiance[c]),
                  record.move[c]);
        if (ring == 0) continue;
        const std::uint32_t inside = at(ring - 1, sector);
        const float wall =
            kTurn / float(grid.sectors) * (1 - inner2) * std::sqrt(inner2) * nearer(cell, inside);
        AddScaled(outwards, wall * (sample.radiance[c] - samples[inside].radiance[c]),
                  record.move[c]);
      }
    }
  }
  result.distance = inverse_distances > 0 ? float(grid.count()) / inverse_distances
                                          : std::numeric_limits<float>::infinity();
  Triple change = {};
  for (std::size_t c = 0; c < 3; ++c) AddScaled(record.move[c], kLuminance[c], change);
  const float slope = std::sqrt(Dot(change, change));
  if (slope > 0) result.distance = std::min(result.distance, Luminance(record.irradiance) / slope);
  return result;
}

IrradianceCache::IrradianceCache(std::vector<IrradianceRecord> records, float accuracy)
    : records_(std::move(records)), accuracy_(accuracy) {
  std::vector<std::pair<Cell, std::uint32_t>> entries;
  for (std::uint32_t i = 0; i < records_.size(); ++i) {
    const IrradianceRecord& r = records_[i];
    int exponent = 0;
    std::frexp(2 * r.radius, &exponent);
    Triple low = r.position, high = r.position;
    for (std::size_t axis = 0; axis < 3; ++axis) low[axis] -= r.radius, high[axis] += r.radius;
    const Cell first = CellOf(exponent, low), last = CellOf(exponent, high);
    for (std::int32_t x = first.x; x <= last.x; ++x) {
      for (std::int32_t y = first.y; y <= last.y; ++y) {
        for (std::int32_t z = first.z; z <= last.z; ++z)
          entries.push_back({{exponent, x, y, z}, i});
      }
    }
  }
  std::sort(entries.begin(), entries.end());
  slots_.resize(std::bit_ceil(2 * entries.size() + 1));
  for (std::size_t i = 0; i < entries.size();) {
    const Cell& cell = entries[i].first;
    if (exponents_.empty() || exponents_.back() != cell.exponent) {
      exponents_.push_back(cell.exponent);
    }
    Slot slot = {.cell = cell, .begin = std::uint32_t(i)};
    for (; i < entries.size() && entries[i].first == cell; ++i) {
      members_.push_back(entries[i].second);
    }
    slot.end = std::uint32_t(i);
    slots_[SlotOf(cell)] = slot;
  }
}

IrradianceCache::Cell IrradianceCache::CellOf(std::int32_t exponent, const Triple& position) {
  const auto index = [&](float x) {
    constexpr double kMost = 1 << 30;
    return std::int32_t(std::clamp(std::floor(std::ldexp(double(x), -exponent)), -kMost, kMost));
  };
  return {exponent, index(position[0]), index(position[1]), index(position[2])};
}

// Returns the slot of a cell, or the free one where it would be.
std::size_t IrradianceCache::SlotOf(const Cell& cell) const {
  std::uint64_t hash = 0;
  for (const std::int32_t part : {cell.exponent, cell.x, cell.y, cell.z}) {
    hash = (hash ^ std::uint32_t(part)) * 0x9E3779B97F4A7C15u;
    hash ^= hash >> 29;
  }
  const std::size_t mask = slots_.size() - 1;
  std::size_t slot = hash & mask;
  while (slots_[slot].begin != slots_[slot].end && slots_[slot].cell != cell) {
    slot = (slot + 1) & mask;
  }
  return slot;
}

bool IrradianceCache::Interpolate(const Triple& position, const Triple& normal,
                                  Triple& irradiance) const {
  // Surfaces behind a record see what it does not (Ward et al. 1988).
  constexpr float kBehind = 0.05f;
  Triple sum = {};
  float weights = 0;
  for (const std::int32_t exponent : exponents_) {
    const Slot& slot = slots_[SlotOf(CellOf(exponent, position))];
    for (std::uint32_t i = slot.begin; i < slot.end; ++i) {
      const IrradianceRecord& r = records_[members_[i]];
      const Triple offset = Minus(position, r.position);
      const float distance = std::sqrt(Dot(offset, offset));
      const float bend = std::sqrt(std::max(0.0f, 1 - Dot(normal, r.normal)));
      const float error = distance / r.radius + bend / accuracy_;
      if (!(error < 1)) continue;
      if (Dot(offset, normal) + Dot(offset, r.normal) < -2 * kBehind * r.radius) continue;
      // It falls to 0 where the record ceases to count.
      const float weight = 1 / std::max(error, 1e-3f) - 1;
      const Triple turn = Cross(r.normal, normal);
      for (std::size_t c = 0; c < 3; ++c) {
        const float here = r.irradiance[c] + Dot(turn, r.turn[c]) + Dot(offset, r.move[c]);
        sum[c] += weight * std::max(0.0f, here);
      }
      weights += weight;
    }
  }
  if (!(weights > 0)) return false;
  for (std::size_t c = 0; c < 3; ++c) irradiance[c] = sum[c] / weights;
  return true;
}

std::size_t IrradianceCache::bytes() const {
  return records_.size() * sizeof(IrradianceRecord) + members_.size() * sizeof(std::uint32_t) +
         slots_.size() * sizeof(Slot);
}

}  // namespace skywave
