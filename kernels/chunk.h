// A chunk holds a few rows of a record on the stack, for stages that pass them from one kernel to
// the next.
#pragma once

#include <type_traits>

#include "kernels/columns.h"

namespace skywave {

// Every column of the record has room for kRows rows and their padding. Nothing is initialised.
template <class Columns, std::uint32_t kRows>
class Chunk {
 public:
  Chunk() {
    float* next = block_;
    Columns::ForEachColumn(columns_, [&next](auto*& column) {
      static_assert(sizeof *column == sizeof(float));
      column = reinterpret_cast<std::remove_reference_t<decltype(column)>>(next);
      next += kStride;
    });
  }
  Chunk(const Chunk&) = delete;
  Chunk& operator=(const Chunk&) = delete;

  operator const Columns&() const { return columns_; }
  const Columns* operator->() const { return &columns_; }

 private:
  static constexpr std::size_t kStride = PaddedRows(kRows);
  static constexpr std::size_t kColumns = sizeof(Columns) / sizeof(void*);
  Columns columns_;
  alignas(kColumnAlignment) float block_[kStride * kColumns];
};

}  // namespace skywave
