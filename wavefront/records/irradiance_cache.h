// The irradiance cache (Ward, Rubinstein and Clear 1988) holds indirect irradiance at a few points
// of diffuse surfaces and interpolates it between them, by gradients (Ward and Heckbert 1992).
#pragma once

#include <array>
#include <cstdint>
#include <span>
#include <vector>

namespace skywave {

// Options of the irradiance cache.
struct IrradianceCacheOptions {
  float accuracy = 0.2f;     // largest error of a record that counts (Ward's a)
  std::uint32_t rays = 256;  // of a record
};

// Three floats, or one for each channel.
using Triple = std::array<float, 3>;

// Irradiance at a point of a surface, all but direct light.
struct IrradianceRecord {
  Triple position, normal;     // world space; unit
  float radius;                // distance at which it ceases to count
  Triple irradiance;           // [radiance * sr]
  std::array<Triple, 3> turn;  // rotation gradient of each channel [radiance * sr / rad]
  std::array<Triple, 3> move;  // translation gradient of each channel [radiance * sr / length]
};

// Finds records in a hash grid: a record is in all cells that its radius reaches, at most eight,
// whose side is the smallest power of two above its diameter. What is found, and the order in which
// it is added, are a function of records and query alone.
class IrradianceCache {
 public:
  // Records differ in normal by up to about `accuracy` radians where they count.
  IrradianceCache(std::vector<IrradianceRecord> records, float accuracy);

  // Writes the irradiance at a point of a surface with that normal. Returns false if no record
  // counts there.
  bool Interpolate(const Triple& position, const Triple& normal, Triple& irradiance) const;

  std::span<const IrradianceRecord> records() const { return records_; }
  std::size_t bytes() const;

 private:
  struct Cell {
    std::int32_t exponent, x, y, z;  // side: 2^exponent
    friend auto operator<=>(const Cell&, const Cell&) = default;
  };
  struct Slot {
    Cell cell;
    std::uint32_t begin = 0, end = 0;  // of members_; empty: the slot is free
  };
  static Cell CellOf(std::int32_t exponent, const Triple& position);
  std::size_t SlotOf(const Cell& cell) const;

  std::vector<IrradianceRecord> records_;
  float accuracy_;
  std::vector<std::int32_t> exponents_;  // those of all cells, ascending
  std::vector<std::uint32_t> members_;   // records, cell by cell, ascending
  std::vector<Slot> slots_;              // a power of two of them, half of them free at least
};

// A ray of a hemisphere has found this.
struct HemisphereSample {
  Triple radiance;
  float distance;  // of the next surface; infinite: there is none
};

// The rays of a hemisphere are stratified: `rings` of equal weight by the cosine, from the normal
// outwards, of `sectors` each.
struct HemisphereGrid {
  std::uint32_t rings, sectors;
  std::uint32_t count() const { return rings * sectors; }
};
// Returns a grid of about `rays` rays whose cells are about square (Ward and Heckbert 1992).
HemisphereGrid GridOf(std::uint32_t rays);

struct Axes {
  Triple x, y, z;
};
// Returns unit vectors across the normal, which is the third axis.
Axes AxesAround(const Triple& normal);

// Returns the direction of place (u, v) in [0, 1)^2 of a cell, ring by ring.
Triple DirectionInCell(const HemisphereGrid& grid, std::uint32_t cell, float u, float v,
                       const Axes& axes);

struct MeasuredIrradiance {
  IrradianceRecord record;
  float distance;  // may be infinite
};
// Returns the record of a point, without position and radius, and the harmonic mean distance of
// what it sees, no more than the distance at which its own gradient would change it entirely
// (Krivanek et al. 2005).
MeasuredIrradiance MeasureIrradiance(const HemisphereGrid& grid, const Axes& axes,
                                     std::span<const HemisphereSample> samples,
                                     std::span<const Triple> directions);

}  // namespace skywave
