// Rows for tests: random numbers with a fixed seed, vectors in double, and bits of columns.
#pragma once

#include <bit>
#include <cmath>
#include <cstdint>
#include <numbers>
#include <random>
#include <vector>

#include "kernels/columns.h"
#include "wavefront/soa.h"

namespace skywave {

inline constexpr double kPi = std::numbers::pi;

struct Vec {
  double x = 0, y = 0, z = 0;
};
inline Vec operator+(Vec a, Vec b) { return {a.x + b.x, a.y + b.y, a.z + b.z}; }
inline Vec operator-(Vec a, Vec b) { return {a.x - b.x, a.y - b.y, a.z - b.z}; }
inline Vec operator-(Vec a) { return {-a.x, -a.y, -a.z}; }
inline Vec operator*(double s, Vec a) { return {s * a.x, s * a.y, s * a.z}; }
inline double Dot(Vec a, Vec b) { return a.x * b.x + a.y * b.y + a.z * b.z; }
inline Vec Cross(Vec a, Vec b) {
  return {a.y * b.z - a.z * b.y, a.z * b.x - a.x * b.z, a.x * b.y - a.y * b.x};
}
inline double Length(Vec a) { return std::sqrt(Dot(a, a)); }
inline Vec Unit(Vec a) { return 1 / Length(a) * a; }
// Returns the lift that LiftOff (kernels/surface/lift-inl.h) documents, in double.
inline double Lift(double extent, Vec a, Vec b) {
  const double longest = std::max(Length(a), Length(b));
  const double slimness = std::min(longest * longest / Length(Cross(a, b)), 256.0);
  return extent * 0x1p-20 + longest * slimness * 0x1p-21;
}

inline double LargestCoordinate(Vec p) {
  return std::max({std::fabs(p.x), std::fabs(p.y), std::fabs(p.z)});
}

// Returns the angle between two vectors, exact for small ones too [rad].
inline double Angle(Vec a, Vec b) { return std::atan2(Length(Cross(a, b)), Dot(a, b)); }

// Independent uniforms, the same on every platform.
class Random {
 public:
  explicit Random(std::uint32_t seed) : engine_(seed) {}
  std::uint32_t Word() { return std::uint32_t(engine_()); }
  float Float() { return float(Word() >> 8) * 0x1p-24f; }  // [0, 1)
  double Between(double low, double high) { return low + (high - low) * Float(); }
  Vec Direction() {
    const double z = Between(-1, 1), phi = Between(0, 2 * kPi), s = std::sqrt(1 - z * z);
    return {s * std::cos(phi), s * std::sin(phi), z};
  }
  // Returns a direction in the hemisphere about a unit vector.
  Vec DirectionAbout(Vec normal) {
    const Vec d = Direction();
    return Dot(d, normal) < 0 ? -d : d;
  }

 private:
  std::mt19937 engine_;
};

inline void Put(Vec v, std::uint32_t row, float* x, float* y, float* z) {
  x[row] = float(v.x), y[row] = float(v.y), z[row] = float(v.z);
}
inline Vec Get(std::uint32_t row, const float* x, const float* y, const float* z) {
  return {x[row], y[row], z[row]};
}

// Returns `rows` pairs of independent uniforms.
inline soa::Table<UniformColumns> RandomUniforms(std::uint32_t rows, std::uint32_t seed) {
  soa::Table<UniformColumns> table(rows);
  Random random(seed);
  for (std::uint32_t i = 0; i < rows; ++i)
    table->u[i] = random.Float(), table->v[i] = random.Float();
  return table;
}

// Returns the bits of rows [0, n) of all columns, column by column.
template <class Columns>
std::vector<std::uint32_t> ColumnBits(Columns columns, std::uint32_t n) {
  std::vector<std::uint32_t> bits;
  Columns::ForEachColumn(columns, [&](auto*& column) {
    for (std::uint32_t i = 0; i < n; ++i) bits.push_back(std::bit_cast<std::uint32_t>(column[i]));
  });
  return bits;
}

// Fills all columns, padding included, with a value that no kernel writes by chance.
template <class Columns>
void FillWithGarbage(Columns columns, std::uint32_t rows) {
  Columns::ForEachColumn(columns, [&](auto*& column) {
    using Value = std::remove_reference_t<decltype(*column)>;
    for (std::uint32_t i = 0; i < PaddedRows(rows); ++i) {
      column[i] = std::bit_cast<Value>(0x7FC5A5A5u);  // a NaN
    }
  });
}

}  // namespace skywave
