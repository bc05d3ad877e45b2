#include "kernels/borrowed.h"

#ifdef SKYWAVE_CHECKS

#include <algorithm>
#include <array>
#include <cstddef>
#include <cstdio>
#include <cstdlib>
#include <cstring>

namespace skywave {
namespace {

// A view holds this column.
struct HeldColumn {
  const std::byte* begin;
  const std::byte* end;
  const char* name;
};

// The views of a thread hold these columns. They are an array, because rendering allocates nothing.
struct HeldColumns {
  std::array<HeldColumn, 128> columns;
  std::size_t count = 0;
};
thread_local HeldColumns held;

void EndHold(const void* column) {
  HeldColumn* const end = held.columns.data() + held.count;
  HeldColumn* const found = std::find_if(
      held.columns.data(), end, [&](const HeldColumn& other) { return other.begin == column; });
  if (found == end) {
    std::fprintf(stderr, "a column is released that no view of this thread holds\n");
    std::abort();
  }
  *found = end[-1];
  --held.count;
}

}  // namespace

void HoldColumn(const void* column, std::uint32_t rows, const char* name) {
  if (rows == 0) return;
  const auto* const begin = static_cast<const std::byte*>(column);
  const auto* const end = begin + rows * sizeof(float);
  for (std::size_t i = 0; i < held.count; ++i) {
    const HeldColumn& other = held.columns[i];
    if (end <= other.begin || other.end <= begin) continue;
    std::fprintf(stderr, "a column of %s is borrowed twice: %s holds it\n", name, other.name);
    std::abort();
  }
  if (held.count == held.columns.size()) {
    std::fprintf(stderr, "there is no place to note that %s holds a column\n", name);
    std::abort();
  }
  held.columns[held.count++] = {begin, end, name};
}

void ReleaseColumn(float* column, std::uint32_t rows) {
  EndHold(column);
  // Bytes are copied because a signalling NaN may become a quiet one as a float.
  for (std::uint32_t i = 0; i < rows; ++i) std::memcpy(column + i, &kPoisonedFloat, sizeof(float));
}

void ReleaseColumn(std::uint32_t* column, std::uint32_t rows) {
  EndHold(column);
  for (std::uint32_t i = 0; i < rows; ++i) column[i] = PoisonedWord(i);
}

}  // namespace skywave

#endif  // SKYWAVE_CHECKS
