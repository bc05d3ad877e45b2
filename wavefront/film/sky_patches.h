// The patches of a sky dome, by which daylight is kept apart (Tregenza 1987): rows of equal height,
// divided into patches of about the same size, and a cap. Reinhart's division (2001) cuts each side
// of these once more. They are numbered as Radiance does: the ground is 0, then come the rows from
// the horizon up, each from the patch whose middle is in the north on to the east.
#pragma once

#include <array>
#include <cstdint>

#include "base/names.h"

namespace skywave {

enum class SkyDivision : std::uint32_t { kNone, kTregenza, kReinhart };
template <>
inline constexpr auto kEnumNames<SkyDivision> =
    std::to_array<Named<SkyDivision>>({{SkyDivision::kNone, "none"},
                                       {SkyDivision::kTregenza, "tregenza"},
                                       {SkyDivision::kReinhart, "reinhart"}});

// A sky and its place in the world.
struct SkyPatches {
  SkyDivision division = SkyDivision::kNone;
  // World directions, unit.
  std::array<float, 3> east = {1, 0, 0}, north = {0, 1, 0}, up = {0, 0, 1};
};

// Returns the number of patches, the ground among them: 146 or 578; none without a division.
std::uint32_t CountPatches(SkyDivision division);

// Returns the patch that a unit direction of the world is in; 0 without a division.
std::uint32_t PatchOf(const SkyPatches& sky, float x, float y, float z);

}  // namespace skywave
