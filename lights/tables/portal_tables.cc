#include "lights/tables/portal_tables.h"

#include <tbb/blocked_range.h>
#include <tbb/parallel_for.h>

#include <algorithm>
#include <atomic>
#include <cmath>
#include <numbers>

#include "lights/maps/environment_map.h"

namespace skywave {
namespace {

constexpr double kHalfTurn = std::numbers::pi;  // [rad]

// The axes of a portal in the world.
glm::dmat3 WorldFromPortal(const Portal& portal) {
  const glm::dvec3 x = glm::normalize(glm::dvec3(portal.side_x));
  const glm::dvec3 z = glm::normalize(glm::cross(x, glm::dvec3(portal.side_y)));
  return {x, glm::cross(z, x), z};
}

// Makes the rectified map of one orientation.
class Rectifier {
 public:
  Rectifier(const Texels& map, const glm::dmat3& map_from_portal, std::uint32_t texels)
      : map_(map), map_from_portal_(map_from_portal), texels_(texels), step_(kHalfTurn / texels) {
    // Points are no farther apart than half a texel of the map near its equator.
    const double finest = kHalfTurn / map.height();
    points_ = std::clamp(int(std::ceil(2 * step_ / finest)), 2, 4);
    const auto tangent_at = [&](double point) {
      return std::tan(std::clamp(point * (step_ / points_) - kHalfTurn / 2, -kHalfTurn / 2 + 1e-9,
                                 kHalfTurn / 2 - 1e-9));
    };
    for (std::uint32_t i = 0; i <= points_ * texels; ++i) tangents_.push_back(tangent_at(i));
    for (std::uint32_t i = 0; i < texels; ++i) middles_.push_back(tangent_at((i + 0.5) * points_));
  }

  // Returns energy [luminance * sr] of all texels, row-major.
  std::vector<double> Energies() const {
    std::vector<double> energies(std::size_t(texels_) * texels_);
    constexpr std::uint32_t kRows = 16;
    tbb::parallel_for(tbb::blocked_range<std::uint32_t>(0, texels_, kRows), [&](const auto& rows) {
      FillRows(rows.begin(), rows.end(), energies.data());
    });
    const std::vector<double> narrow = NarrowTexels();
    for (std::size_t i = 0; i < energies.size(); ++i) {
      energies[i] = std::max(energies[i], narrow[i]);
    }
    return energies;
  }

 private:
  // Writes the energies of rows of texels. Each texel has a grid of points, of which the outer ones
  // lie on its border and are those of its neighbours as well.
  void FillRows(std::uint32_t first, std::uint32_t last, double* energies) const {
    std::vector<std::vector<double>> lines(std::size_t(points_) + 1);  // of points
    lines.back() = LineOfPoints(first * std::uint32_t(points_));
    for (std::uint32_t row = first; row < last; ++row) {
      lines.front().swap(lines.back());
      for (int j = 1; j <= points_; ++j) {
        lines[std::size_t(j)] = LineOfPoints(row * std::uint32_t(points_) + std::uint32_t(j));
      }
      FillRow(row, lines, &energies[std::size_t(row) * texels_]);
    }
  }

  // Returns the luminance at the points of one line from border to border.
  std::vector<double> LineOfPoints(std::uint32_t line) const {
    std::vector<double> luminance;
    luminance.reserve(tangents_.size());
    for (const double tangent : tangents_) {
      const glm::dvec3 local = glm::normalize(glm::dvec3(tangent, tangents_[line], 1));
      luminance.push_back(LuminanceAt(map_from_portal_ * local));
    }
    return luminance;
  }

  // Writes the energies of a row of texels from its lines of points. Half of the energy of a texel
  // is that of its brightest point everywhere, so that light which reaches into a texel is drawn
  // with a density of half its own at least.
  void FillRow(std::uint32_t row, const std::vector<std::vector<double>>& lines,
               double* energies) const {
    for (std::uint32_t column = 0; column < texels_; ++column) {
      double sum = 0, weights = 0, most = 0;
      for (int j = 0; j <= points_; ++j) {
        for (int i = 0; i <= points_; ++i) {
          const double weight = (i % points_ == 0 ? 0.5 : 1) * (j % points_ == 0 ? 0.5 : 1);
          const double value = lines[std::size_t(j)][std::size_t(column) * points_ + i];
          sum += weight * value, weights += weight, most = std::max(most, value);
        }
      }
      const glm::dvec3 local = glm::normalize(glm::dvec3(middles_[column], middles_[row], 1));
      const double solid_angle =
          step_ * step_ * (1 - local.x * local.x) * (1 - local.y * local.y) / local.z;
      energies[column] = 0.5 * (sum / weights + most) * solid_angle;
    }
  }

  double LuminanceAt(const glm::dvec3& m) const {
    const double u = 0.5 + std::atan2(m.x, m.y) / (2 * kHalfTurn);
    const double v = std::acos(std::clamp(m.z, -1.0, 1.0)) / kHalfTurn;
    return map_.Luminance(std::min(std::uint32_t(u * map_.width()), map_.width() - 1),
                          std::min(std::uint32_t(v * map_.height()), map_.height() - 1));
  }

  // Returns the energies of the texels of the map between which the points could fall, where the
  // middles of these texels lie. Sums over threads are of whole numbers, so their order does not
  // matter.
  std::vector<double> NarrowTexels() const {
    const double unit = map_.unit() * 0x1p-20;
    std::vector<std::atomic<std::uint64_t>> sums(std::size_t(texels_) * texels_);
    const double spacing = step_ / points_;
    const std::uint32_t width = map_.width(), height = map_.height();
    tbb::parallel_for(0u, height, [&](std::uint32_t row) {
      const double theta = kHalfTurn * (row + 0.5) / height, sine = std::sin(theta);
      if (std::min(2 * kHalfTurn / width * sine, kHalfTurn / height) > 1.4 * spacing) return;
      const double solid_angle = RowSolidAngle(int(width), int(height), int(row));
      for (std::uint32_t column = 0; column < width; ++column) {
        const double luminance = map_.Luminance(column, row);
        if (luminance <= 0) continue;
        const double turn = 2 * kHalfTurn * ((column + 0.5) / width - 0.5);
        const glm::dvec3 m(sine * std::sin(turn), sine * std::cos(turn), std::cos(theta));
        const glm::dvec3 local = glm::transpose(map_from_portal_) * m;
        if (local.z <= 0) continue;
        const auto place = [&](double across) {
          const double texel = (std::atan2(across, local.z) + kHalfTurn / 2) / step_;
          return std::min(std::size_t(std::max(texel, 0.0)), std::size_t(texels_ - 1));
        };
        sums[place(local.y) * texels_ + place(local.x)].fetch_add(
            std::uint64_t(luminance * solid_angle / unit), std::memory_order_relaxed);
      }
    });
    std::vector<double> energies(sums.size());
    std::transform(sums.begin(), sums.end(), energies.begin(),
                   [&](const auto& sum) { return double(sum.load()) * unit; });
    return energies;
  }

  const Texels& map_;
  glm::dmat3 map_from_portal_;
  std::uint32_t texels_;
  double step_;                             // of a texel [rad]
  int points_;                              // of a texel along either axis
  std::vector<double> tangents_, middles_;  // of the points' and the texels' places on an axis
};

double EnergyOf(const Texels& map) {
  double energy = 0;
  for (std::uint32_t row = 0; row < map.height(); ++row) {
    double sum = 0;
    for (std::uint32_t column = 0; column < map.width(); ++column) {
      sum += map.Luminance(column, row);
    }
    energy += sum * RowSolidAngle(int(map.width()), int(map.height()), int(row));
  }
  return energy;
}

// Appends the sums of `energies` in whole units. Returns the energy of a unit; 0 for a black half.
double AppendSums(const std::vector<double>& energies, std::uint32_t texels,
                  std::vector<std::uint32_t>& sums) {
  double total = 0;
  for (const double energy : energies) total += energy;
  // Every texel gets one unit more than its energy asks for.
  const double most = 0x1p31 - 1 - double(energies.size());
  const double unit = total / most;
  const std::size_t begin = sums.size(), stride = texels + 1;
  sums.resize(begin + stride * stride);
  for (std::uint32_t row = 0; row < texels; ++row) {
    std::uint32_t of_row = 0;
    std::uint32_t* const below = &sums[begin + (row + 1) * stride];
    const std::uint32_t* const above = below - stride;
    for (std::uint32_t column = 0; column < texels; ++column) {
      const double energy = energies[std::size_t(row) * texels + column];
      of_row += 1 + (unit > 0 ? std::uint32_t(energy / unit) : 0);
      below[column + 1] = above[column + 1] + of_row;
    }
  }
  return unit;
}

// Appends the sums over single columns of the rectified map whose sums begin at `begin`.
void AppendColumns(const std::vector<std::uint32_t>& sums, std::size_t begin, std::uint32_t texels,
                   std::vector<std::uint32_t>& columns) {
  const std::size_t stride = texels + 1;
  columns.resize(begin + stride * stride);
  tbb::parallel_for(0u, texels, [&](std::uint32_t column) {
    for (std::size_t row = 0; row <= texels; ++row) {
      const std::uint32_t* const sum = &sums[begin + row * stride + column];
      columns[begin + column * stride + row] = sum[1] - sum[0];
    }
  });
}

bool SameAxes(const glm::dmat3& a, const glm::dmat3& b) {
  double difference = 0;
  for (int i = 0; i < 3; ++i) difference = std::max(difference, glm::length(a[i] - b[i]));
  return difference < 1e-6;
}

}  // namespace

PortalTables::PortalTables(const Texels& map, std::span<const Portal> portals, std::uint32_t texels)
    : texels_(texels) {
  glm::dmat3 world_from_map;  // its columns are the rows of map_from_world
  for (int i = 0; i < 9; ++i) world_from_map[i / 3][i % 3] = map.view().map_from_world[i];
  struct Made {
    glm::dmat3 axes;
    std::uint32_t sums;
    double unit;
  };
  std::vector<Made> made;
  const double energy = EnergyOf(map);
  for (const Portal& portal : portals) {
    const glm::dmat3 axes = WorldFromPortal(portal);
    auto known = std::find_if(made.begin(), made.end(),
                              [&](const Made& other) { return SameAxes(other.axes, axes); });
    if (known == made.end()) {
      const Rectifier rectifier(map, glm::transpose(world_from_map) * axes, texels);
      const auto begin = std::uint32_t(sums_.size());
      const double unit = AppendSums(rectifier.Energies(), texels, sums_);
      AppendColumns(sums_, begin, texels, columns_);
      known = made.insert(made.end(), {axes, begin, energy > 0 ? unit / energy : 0});
    }
    PortalRecord record = {};
    for (int i = 0; i < 3; ++i) {
      record.corner[i] = portal.corner[i];
      record.x[i] = float(known->axes[0][i]);
      record.y[i] = float(known->axes[1][i]);
      record.z[i] = float(known->axes[2][i]);
    }
    record.size_x = glm::length(portal.side_x);
    record.size_y = glm::length(portal.side_y);
    record.unit = float(known->unit);
    record.sums = known->sums;
    records_.push_back(record);
  }
}

PortalsView PortalTables::view() const {
  return {.portals = records_.data(),
          .count = std::uint32_t(records_.size()),
          .sums = sums_.data(),
          .columns = columns_.data(),
          .texels = texels_};
}

}  // namespace skywave
