// Tests what tables of megabytes ask of the system: zeros, and pages given back without their
// neighbours.
#include "base/large_memory.h"

#include <gtest/gtest.h>
#include <unistd.h>

#include <algorithm>
#include <cstdint>
#include <vector>

namespace skywave {
namespace {

constexpr std::size_t kMegabytes = std::size_t{5} << 20;  // more than one huge page

TEST(LargeMemory, ALargeVectorHoldsZeros) {
  for (const std::size_t count : {std::size_t{0}, std::size_t{7}, kMegabytes}) {
    std::vector<std::uint8_t> values;
    ResizeLarge(values, count);
    EXPECT_EQ(values.size(), count);
    EXPECT_EQ(std::count(values.begin(), values.end(), 0), std::ptrdiff_t(count));
  }
}

// An advice about the page that a block shares with its neighbour would take the neighbour's bytes.
TEST(LargeMemory, OnlyWholePagesOfABlockAreGivenBack) {
  const auto page = std::size_t(sysconf(_SC_PAGESIZE));
  std::vector<std::uint8_t> values(kMegabytes, 1);
  const std::size_t first = 3 * page + 5, bytes = 8 * page;
  GivePagesBack(values.data() + first, bytes);
  const auto forgotten = std::count(values.begin(), values.end(), 0);
  EXPECT_EQ(forgotten % std::ptrdiff_t(page), 0);
  EXPECT_GE(forgotten, std::ptrdiff_t(7 * page));
  EXPECT_LE(forgotten, std::ptrdiff_t(bytes));
  const auto block = values.begin() + std::ptrdiff_t(first);
  EXPECT_EQ(std::count(block, block + std::ptrdiff_t(bytes), 0), forgotten);
}

TEST(LargeMemory, ABlockWithoutAWholePageStays) {
  const auto page = std::size_t(sysconf(_SC_PAGESIZE));
  std::vector<std::uint8_t> values(kMegabytes, 1);
  GivePagesBack(values.data() + 1, page / 2);
  EXPECT_EQ(std::count(values.begin(), values.end(), 1), std::ptrdiff_t(kMegabytes));
}

}  // namespace
}  // namespace skywave
