// The table gives the lane order that moves the set lanes of an 8-bit mask to the front: row m
// lists the positions of the one bits of m, in order. Vectors of four lanes use the first sixteen
// rows.
#pragma once

#include <cstdint>

namespace skywave {

struct CompressTable {
  alignas(64) std::uint32_t lanes[256][8];
  constexpr const std::uint32_t* operator[](std::uint8_t mask) const { return lanes[mask]; }
};

constexpr CompressTable MakeCompressTable() {
  CompressTable table{};
  for (int mask = 0; mask < 256; ++mask) {
    int next = 0;
    for (std::uint32_t lane = 0; lane < 8; ++lane) {
      if (mask >> lane & 1) table.lanes[mask][next++] = lane;
    }
  }
  return table;
}

inline constexpr CompressTable kCompressTable = MakeCompressTable();

}  // namespace skywave
