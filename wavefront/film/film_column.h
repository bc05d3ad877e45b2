// The sums of a film lie in columns, which know how those of two films become one.
#pragma once

#include <algorithm>
#include <cstddef>
#include <cstdint>
#include <utility>
#include <vector>

#include "kernels/accumulate.h"
#include "wavefront/film/film_area.h"

namespace skywave {

// How many samples the pixels of a film hold: all as many, or each its own number.
class SampleCounts {
 public:
  SampleCounts(std::uint64_t all) : all_(all) {}  // NOLINT: a number is meant where it stands
  SampleCounts(std::vector<std::uint32_t> by_pixel) : by_pixel_(std::move(by_pixel)) {}  // NOLINT
  std::uint64_t operator[](std::size_t pixel) const {
    return by_pixel_.empty() ? all_ : by_pixel_[pixel];
  }
  // Returns those of a window of a film that is so wide [pixels].
  SampleCounts Cut(const CropWindow& window, int width) const;

 private:
  std::uint64_t all_ = 0;
  std::vector<std::uint32_t> by_pixel_;  // of the film, row by row
};

// A column has `per_pixel` values of each pixel, row by row, in each of `planes` planes that follow
// each other. Those of the sample nearest to a pixel's centre are not summed: the sample with the
// smaller key wins. A column that starts filled is not zeros at first, so its memory is in use from
// the beginning on (wavefront/film/film_memory.h). Those of a matte are added by AddToMatte. Sums
// may have signs where those of the film have none.
struct FilmColumn {
  std::size_t per_pixel = 1, planes = 1;
  bool of_nearest = false, starts_filled = false, of_matte = false;
  bool has_signs = false;
};

// Calls f(to, from, n) for each row of n pixels of the window `from` of a film, which begins at
// pixel `from` there and at pixel `to` of another film.
template <class F>
void ForEachRun(const CropWindow& from, int from_width, int to_x, int to_y, int to_width, F f) {
  for (int y = 0; y < from.height; ++y) {
    f(std::size_t(to_y + y) * std::size_t(to_width) + std::size_t(to_x),
      std::size_t(from.y + y) * std::size_t(from_width) + std::size_t(from.x),
      std::size_t(from.width));
  }
}

inline SampleCounts SampleCounts::Cut(const CropWindow& window, int width) const {
  if (by_pixel_.empty()) return all_;
  std::vector<std::uint32_t> cut(std::size_t(window.width) * std::size_t(window.height));
  ForEachRun(window, width, 0, 0, window.width,
             [&](std::size_t to, std::size_t from, std::size_t n) {
               std::copy_n(&by_pixel_[from], n, &cut[to]);
             });
  return cut;
}

// Returns the value of a sum, which may be a signed number in two's complement.
inline double SumValue(std::uint64_t sum, bool has_signs) {
  return has_signs ? double(std::int64_t(sum)) : double(sum);
}

// Adds what another film holds; order does not matter.
inline std::uint64_t Combined(std::uint64_t a, std::uint64_t b) { return SaturatingSum(a, b); }
inline Uint128 Combined(Uint128 a, Uint128 b) { return SaturatingSum(a, b); }
inline std::int64_t Combined(std::int64_t a, std::int64_t b) { return a + b; }
inline std::uint32_t Combined(std::uint32_t a, std::uint32_t b) { return a + b; }

// The same for a film whose sums have signs; squares and counts have none.
inline std::uint64_t CombinedSigned(std::uint64_t a, std::uint64_t b) { return a + b; }
template <class T>
T CombinedSigned(T a, T b) {
  return Combined(a, b);
}

}  // namespace skywave
