// A structure-of-arrays table is one aligned block of memory behind a struct of column pointers.
#pragma once

#include <algorithm>
#include <cstddef>
#include <cstdint>
#include <cstdlib>
#include <memory>
#include <new>
#include <type_traits>

#include "base/large_memory.h"
#include "kernels/columns.h"

namespace skywave::soa {

// These count the columns that the visitor of a record reaches, and the bytes of one row over all
// of them.
template <class Columns>
consteval std::size_t CountColumns() {
  std::size_t count = 0;
  Columns columns{};
  Columns::ForEachColumn(columns, [&](auto*&) { ++count; });
  return count;
}
template <class Columns>
consteval std::size_t BytesPerRow() {
  std::size_t bytes = 0;
  Columns columns{};
  Columns::ForEachColumn(
      columns, [&](auto*& column) { bytes += sizeof(std::remove_reference_t<decltype(*column)>); });
  return bytes;
}

// The memory of a table is first written here or later.
enum class Touch {
  kHere,  // by the thread that constructs it, with zeros: the worker that will use it
  kLater  // by many threads, with their values, which are indeterminate until then
};

// Owns the memory of a record's columns, which it allocates once.
template <class Columns>
class Table {
  static_assert(CountColumns<Columns>() * sizeof(void*) == sizeof(Columns),
                "a column is missing in ForEachColumn");

 public:
  Table() = default;
  explicit Table(std::uint32_t rows, Touch touch = Touch::kHere) : rows_(rows) {
    const std::size_t padded = PaddedRows(rows);
    std::size_t bytes = 0;
    Columns::ForEachColumn(columns_, [&](auto*& column) { bytes += Room(column, padded); });
    block_.reset(static_cast<std::byte*>(std::aligned_alloc(kColumnAlignment, bytes)));
    if (!block_) throw std::bad_alloc();
    AdviseHugePages(block_.get(), bytes);
    std::byte* next = block_.get();
    if (touch == Touch::kHere) std::fill_n(next, bytes, std::byte{0});
    Columns::ForEachColumn(columns_, [&](auto*& column) {
      column = reinterpret_cast<std::remove_reference_t<decltype(column)>>(next);
      next += Room(column, padded);
    });
  }

  // Returns the rows that the table can hold, padding not counted.
  std::uint32_t rows() const { return rows_; }
  const Columns& columns() const { return columns_; }
  operator const Columns&() const { return columns_; }
  const Columns* operator->() const { return &columns_; }

 private:
  // Returns the bytes of a column; only its type matters.
  template <class T>
  static constexpr std::size_t Room(const T*, std::size_t padded) {
    return (padded * sizeof(T) + kColumnAlignment - 1) / kColumnAlignment * kColumnAlignment;
  }
  struct Free {
    void operator()(std::byte* block) const { std::free(block); }
  };
  std::uint32_t rows_ = 0;
  Columns columns_{};
  std::unique_ptr<std::byte, Free> block_;
};

}  // namespace skywave::soa
