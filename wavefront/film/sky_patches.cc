#include "wavefront/film/sky_patches.h"

#include <algorithm>
#include <cmath>
#include <numbers>

namespace skywave {
namespace {

constexpr std::uint32_t kTregenzaRows[] = {30, 30, 24, 24, 18, 12, 6};

// The rows below the cap, and the patches of one of them.
std::uint32_t RowsOf(SkyDivision division) {
  return std::uint32_t(division) * std::uint32_t(std::size(kTregenzaRows));
}
std::uint32_t PatchesOfRow(SkyDivision division, std::uint32_t row) {
  return std::uint32_t(division) * kTregenzaRows[row / std::uint32_t(division)];
}

}  // namespace

std::uint32_t CountPatches(SkyDivision division) {
  if (division == SkyDivision::kNone) return 0;
  std::uint32_t count = 2;  // the ground and the cap
  for (std::uint32_t row = 0; row < RowsOf(division); ++row) count += PatchesOfRow(division, row);
  return count;
}

std::uint32_t PatchOf(const SkyPatches& sky, float x, float y, float z) {
  if (sky.division == SkyDivision::kNone) return 0;
  const auto along = [&](const std::array<float, 3>& axis) {
    return double(axis[0]) * x + double(axis[1]) * y + double(axis[2]) * z;
  };
  const double up = along(sky.up);
  if (up <= 0) return 0;
  // The cap is half as high as a row.
  const std::uint32_t rows = RowsOf(sky.division);
  const double height = std::numbers::pi / 2 / (rows + 0.5);
  const auto row = std::uint32_t(std::asin(std::min(up, 1.0)) / height);
  std::uint32_t patch = 1;
  for (std::uint32_t below = 0; below < std::min(row, rows); ++below) {
    patch += PatchesOfRow(sky.division, below);
  }
  if (row >= rows) return patch;
  const std::uint32_t count = PatchesOfRow(sky.division, row);
  const double turns = std::atan2(along(sky.east), along(sky.north)) / (2 * std::numbers::pi);
  return patch + std::uint32_t(std::floor((turns + 1) * count + 0.5)) % count;
}

}  // namespace skywave
