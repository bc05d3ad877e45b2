#include "lights/tables/vector_irradiance.h"

#include <tbb/parallel_for.h>

#include <algorithm>
#include <cmath>
#include <numbers>

#include "lights/tables/texels.h"

namespace skywave {
namespace {

using Vector = std::array<double, 3>;     // right, forward, up
using RgbVector = std::array<Vector, 3>;  // of each channel

constexpr std::uint32_t kEntries = kIrradianceNodes * kIrradianceNodes + kIrradianceAxes;

// Returns the normal of an entry, as IrradianceLanes finds it.
Vector NormalOf(std::uint32_t entry) {
  if (entry >= kEntries - kIrradianceAxes) {
    const std::uint32_t axis = entry - (kEntries - kIrradianceAxes);
    Vector normal = {0, 0, 0};
    normal[axis / 2] = axis % 2 == 0 ? 1 : -1;
    return normal;
  }
  const std::uint32_t column = entry % kIrradianceNodes, row = entry / kIrradianceNodes;
  constexpr double kHalf = 0.5 * (kIrradianceNodes - 1);
  double x = column / kHalf - 1, y = row / kHalf - 1;
  const double z = 1 - std::abs(x) - std::abs(y);
  if (z < 0) {
    const double folded = std::copysign(1 - std::abs(y), x);
    y = std::copysign(1 - std::abs(x), y);
    x = folded;
  }
  const double length = std::sqrt(x * x + y * y + z * z);
  return {x / length, y / length, z / length};
}

// One row of the map, as integrals over the azimuth p from 0 to the left border of each texel:
// radiance times sin p, cos p and 1, for each channel. A direction at the angle t from up has the
// coordinates (sin t sin p, sin t cos p, cos t), and p is 2 pi u - pi.
class RowSums {
 public:
  struct Border {
    double sine, cosine, column;  // of an azimuth; its place among the texels
  };

  void Fill(const float* rgb, std::uint32_t width, const std::vector<Border>& borders) {
    rgb_ = rgb, width_ = width, borders_ = borders.data();
    step_ = 2 * std::numbers::pi / width;
    sums_.resize(width + 1);
    sums_[0] = {};
    for (std::uint32_t i = 0; i < width; ++i) {
      sums_[i + 1] = sums_[i];
      AddPart(i, borders[i + 1], step_, sums_[i + 1]);
    }
  }

  // Returns the integral from the left end of the row to a border that may lie inside a texel.
  RgbVector To(const Border& border) const {
    const std::uint32_t i = std::min(std::uint32_t(border.column), width_ - 1);
    RgbVector sum = sums_[i];
    AddPart(i, border, (border.column - i) * step_, sum);
    return sum;
  }
  const RgbVector& all() const { return sums_[width_]; }

 private:
  // Adds texel i from its left border to `to`, `angle` farther.
  void AddPart(std::uint32_t i, const Border& to, double angle, RgbVector& sum) const {
    const double of_sine = borders_[i].cosine - to.cosine, of_cosine = to.sine - borders_[i].sine;
    for (std::size_t c = 0; c < 3; ++c) {
      const double radiance = rgb_[std::size_t(i) * 3 + c];
      sum[c][0] += radiance * of_sine;
      sum[c][1] += radiance * of_cosine;
      sum[c][2] += radiance * angle;
    }
  }

  const float* rgb_ = nullptr;
  std::uint32_t width_ = 0;
  double step_ = 0;
  const Border* borders_ = nullptr;
  std::vector<RgbVector> sums_;
};

// An angle from up.
struct Polar {
  double sine, cosine;
  explicit Polar(double theta) : sine(std::sin(theta)), cosine(std::cos(theta)) {}
};

// Adds `sums` at an angle from up, of weight d theta.
void AddAt(const RgbVector& sums, const Polar& at, double weight, RgbVector& total) {
  const double across = weight * at.sine * at.sine, up = weight * at.sine * at.cosine;
  for (std::size_t c = 0; c < 3; ++c) {
    total[c][0] += across * sums[c][0];
    total[c][1] += across * sums[c][1];
    total[c][2] += up * sums[c][2];
  }
}

// An entry's normal, apart into the sine of its angle from up and its azimuth, and its horizon.
struct NodeNormal {
  double across, up, sine, cosine, azimuth, horizon;
  explicit NodeNormal(std::uint32_t entry)
      : horizon(entry < kEntries - kIrradianceAxes ? kHorizonSine : 0) {
    const Vector n = NormalOf(entry);
    across = std::hypot(n[0], n[1]), up = n[2];
    sine = across > 0 ? n[0] / across : 0, cosine = across > 0 ? n[1] / across : 1;
    azimuth = std::atan2(n[0], n[1]);
  }
  // Returns the cosine of half the range of azimuths that are above the horizon at an angle from
  // up: 1 or more where none is, -1 or less where all are.
  double HalfRange(const Polar& at) const {
    const double over = horizon - up * at.cosine, under = across * at.sine;
    if (under > 0) return over / under;
    return over < 0 ? -2 : 2;
  }
};

// Adds the azimuths above the horizon of the node at one angle from up.
void AddCut(const RowSums& row, const NodeNormal& node, const Polar& at, double weight,
            std::uint32_t width, RgbVector& total) {
  const double half = node.HalfRange(at);
  if (half >= 1) return;
  if (half <= -1) return AddAt(row.all(), at, weight, total);
  const double range = std::acos(half), half_sine = std::sqrt(1 - half * half);
  // The place of an azimuth among the texels, from 0 to the width.
  const auto border = [&](double side) -> RowSums::Border {
    double turn = (node.azimuth + side * range) / (2 * std::numbers::pi) + 0.5;
    turn -= std::floor(turn);
    return {.sine = node.sine * half + side * node.cosine * half_sine,
            .cosine = node.cosine * half - side * node.sine * half_sine,
            .column = turn * width};
  };
  const RowSums::Border from = border(-1), to = border(1);
  RgbVector between = row.To(to);
  const RgbVector before = row.To(from);
  for (std::size_t c = 0; c < 3; ++c) {
    for (std::size_t k = 0; k < 3; ++k) {
      between[c][k] -= before[c][k];
      if (from.column > to.column) between[c][k] += row.all()[c][k];
    }
  }
  AddAt(between, at, weight, total);
}

// A band of a row: its borders and two Gaussian points between them.
struct Band {
  double top, height;
  Polar first, last, low, high;
  Band(double from, double to)
      : top(from), height(to - from), first(from), last(to), low(Gauss(-1)), high(Gauss(1)) {}
  Polar Gauss(double side) const {
    return Polar(top + height * (0.5 + side / (2 * std::sqrt(3.0))));
  }
};

// Adds a band of a row: by its two points where the horizon cuts it like a straight line, by more
// where it is tangent.
void AddBand(const RowSums& row, const NodeNormal& node, const Band& band, std::uint32_t width,
             RgbVector& total) {
  const double first = node.HalfRange(band.first), last = node.HalfRange(band.last);
  if (first >= 1 && last >= 1) return;
  const bool whole = first <= -1 && last <= -1;
  const bool tangent = std::abs(first) >= 1 || std::abs(last) >= 1;
  if (whole || !tangent) {
    AddCut(row, node, band.low, 0.5 * band.height, width, total);
    AddCut(row, node, band.high, 0.5 * band.height, width, total);
    return;
  }
  constexpr int kParts = 16;
  const double step = band.height / kParts;
  for (int part = 0; part < kParts; ++part) {
    const Band finer(band.top + step * part, band.top + step * (part + 1));
    AddCut(row, node, finer.low, 0.5 * step, width, total);
    AddCut(row, node, finer.high, 0.5 * step, width, total);
  }
}

}  // namespace

VectorIrradiance::VectorIrradiance(const EnvironmentMap& map)
    : map_from_world_(map.map_from_world) {
  const Image held = Texels(map).Held();
  const auto width = std::uint32_t(held.width), height = std::uint32_t(held.height);
  std::vector<RowSums::Border> borders(width + 1);
  for (std::uint32_t i = 0; i <= width; ++i) {
    const double azimuth = 2 * std::numbers::pi * i / width - std::numbers::pi;
    borders[i] = {.sine = std::sin(azimuth), .cosine = std::cos(azimuth), .column = double(i)};
  }
  std::vector<RgbVector> totals(kEntries);
  // The horizon is nearly straight over the height of a band.
  constexpr std::uint32_t kMostBands = 256;
  const std::uint32_t bands = std::max(1u, kMostBands / height);
  const double step = std::numbers::pi / (double(height) * bands);
  std::vector<Band> all_bands;
  for (std::uint32_t i = 0; i < height * bands; ++i) {
    all_bands.emplace_back(step * i, step * (i + 1));
  }
  // An entry adds up the rows in their order, whatever the number of threads.
  constexpr std::uint32_t kRows = 16;
  std::vector<RowSums> rows(kRows);
  for (std::uint32_t first = 0; first < height; first += kRows) {
    const std::uint32_t count = std::min(kRows, height - first);
    tbb::parallel_for(0u, count, [&](std::uint32_t i) {
      rows[i].Fill(held.Pixel(0, int(first + i)), width, borders);
    });
    tbb::parallel_for(0u, kEntries, [&](std::uint32_t entry) {
      const NodeNormal node(entry);
      for (std::uint32_t i = 0; i < count * bands; ++i) {
        AddBand(rows[i / bands], node, all_bands[first * bands + i], width, totals[entry]);
      }
    });
  }
  nodes_.reserve(totals.size() * kIrradianceWords);
  for (const RgbVector& total : totals) {
    for (const Vector& channel : total) {
      for (const double value : channel) nodes_.push_back(float(value));
    }
  }
}

IrradianceView VectorIrradiance::view() const {
  IrradianceView view = {.nodes = nodes_.data(), .map_from_world = {}};
  std::copy(map_from_world_.begin(), map_from_world_.end(), view.map_from_world);
  return view;
}

}  // namespace skywave
