#include "image/weighted_sums.h"

#include <tbb/parallel_for.h>

#include <algorithm>
#include <cstddef>

namespace skywave {
namespace {

// Adds numbers times factors that repeat, which are unrolled to whole vectors of the machine.
void AddTimes(const std::array<float, 3>& factor, std::span<const float> numbers, double* sums) {
  constexpr std::size_t kPeriod = 12;
  std::array<double, kPeriod> factors;
  for (std::size_t i = 0; i < kPeriod; ++i) factors[i] = double(factor[i % 3]);
  std::size_t begin = 0;
  for (; begin + kPeriod <= numbers.size(); begin += kPeriod) {
    for (std::size_t i = 0; i < kPeriod; ++i) {
      sums[begin + i] += factors[i] * double(numbers[begin + i]);
    }
  }
  for (std::size_t i = 0; begin + i < numbers.size(); ++i) {
    sums[begin + i] += factors[i] * double(numbers[begin + i]);
  }
}

}  // namespace

std::vector<Image> WeightedSums(std::span<const Image> images,
                                std::span<const std::vector<std::array<float, 3>>> rows) {
  std::vector<Image> sums(rows.size(), Image(images[0].width, images[0].height));
  const std::size_t line = 3 * std::size_t(images[0].width);
  tbb::parallel_for(std::size_t{0}, std::size_t(images[0].height), [&](std::size_t y) {
    std::vector<double> of_line(rows.size() * line);
    for (std::size_t i = 0; i < images.size(); ++i) {
      const std::span<const float> numbers = std::span(images[i].rgb).subspan(y * line, line);
      for (std::size_t row = 0; row < rows.size(); ++row) {
        AddTimes(rows[row][i], numbers, &of_line[row * line]);
      }
    }
    for (std::size_t row = 0; row < rows.size(); ++row) {
      std::transform(&of_line[row * line], &of_line[row * line] + line, &sums[row].rgb[y * line],
                     [](double sum) { return float(sum); });
    }
  });
  return sums;
}

}  // namespace skywave
