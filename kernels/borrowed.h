// Columns that lie idle are lent under another name and type for a scope.
//
// A stage that needs a column for a moment takes one of a table that is idle then, so that a wave
// stays within the cache. A view says what the column means meanwhile and which stage holds it. In
// builds with SKYWAVE_CHECKS the program aborts if two views of a thread hold the same memory, and
// a view that ends fills its columns with poison, so that later reads of them are detected. In
// other builds a view is its pointers and nothing else.
#pragma once

#include <cstdint>
#include <utility>

namespace skywave {

#ifdef SKYWAVE_CHECKS
// A poisoned float is a signalling NaN with these bits.
inline constexpr std::uint32_t kPoisonedFloat = 0x7FADBEEFu;
// Returns a poisoned word. It depends on the row, so a picture that is made of such words differs
// between sizes of waves.
constexpr std::uint32_t PoisonedWord(std::uint32_t row) { return 0xDEAD0000u | (row & 0xFFFFu); }

// Holds the first `rows` values of a column for a view of the calling thread; aborts, with both
// names, if another view holds any of them. The name must outlive the view.
void HoldColumn(const void* column, std::uint32_t rows, const char* name);
// Ends the hold of a column and poisons its values.
void ReleaseColumn(float* column, std::uint32_t rows);
void ReleaseColumn(std::uint32_t* column, std::uint32_t rows);
#endif

// The base of all views holds a record of columns for as long as the object lives. Views are moved
// and never copied, and end on the thread where they began.
template <class Columns>
class Borrowed {
 public:
  // Holds nothing: every pointer is null.
  Borrowed() = default;
  operator const Columns&() const { return columns_; }
  const Columns* operator->() const { return &columns_; }

#ifdef SKYWAVE_CHECKS
  // Holds the first `rows` values of each of `columns`.
  Borrowed(const Columns& columns, std::uint32_t rows, const char* name)
      : columns_(columns), rows_(rows) {
    Columns::ForEachColumn(columns_, [&](auto*& column) { HoldColumn(column, rows, name); });
  }
  Borrowed(Borrowed&& other) noexcept
      : columns_(std::exchange(other.columns_, {})), rows_(std::exchange(other.rows_, 0)) {}
  ~Borrowed() {
    if (rows_ == 0) return;
    Columns::ForEachColumn(columns_, [&](auto*& column) { ReleaseColumn(column, rows_); });
  }
#else
  Borrowed(const Columns& columns, std::uint32_t, const char*) : columns_(columns) {}
  Borrowed(Borrowed&&) noexcept = default;
#endif

 private:
  Columns columns_{};
#ifdef SKYWAVE_CHECKS
  std::uint32_t rows_ = 0;
#endif
};

}  // namespace skywave
