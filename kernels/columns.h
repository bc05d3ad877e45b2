// The records that flow between stages, each declared once: a struct of column pointers, one comment
// a column (meaning, unit or space, writer), one visitor. wavefront/soa.h owns the memory; kernels
// and stages take these structs as they are.
//
// Every column is aligned to kColumnAlignment and has room for PaddedRows(rows) values: kernels run
// over whole vectors and may write anything into the padding behind the last row.
#pragma once

#include <cstddef>
#include <cstdint>

namespace skywave {

inline constexpr std::size_t kColumnAlignment = 64;  // [bytes], one cache line
inline constexpr std::uint32_t kPadRows = 16;        // widest vector of 32-bit lanes

// Room for `rows` rows and a store of a whole vector that begins at any of them.
constexpr std::uint32_t PaddedRows(std::uint32_t rows) {
  return (rows + kPadRows - 1) / kPadRows * kPadRows + kPadRows;
}

// The queues: one a BSDF. Kinds before kFirstDeltaBsdf take light samples; the others are delta
// distributions, which no light sample can meet.
enum class BsdfKind : std::uint32_t { kLambert, kConductor, kMirror, kDielectric };
inline constexpr std::uint32_t kBsdfKinds = 4;
inline constexpr std::uint32_t kFirstDeltaBsdf = 2;

}  // namespace skywave
