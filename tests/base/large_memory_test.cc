// Tests what tables of megabytes ask of the system: zeros, huge pages, and pages
// given back without their neighbours.
#include "base/large_memory.h"

#include <gtest/gtest.h>
#include <sys/mman.h>
#include <unistd.h>

#include <algorithm>
#include <cstdint>
#include <cstdio>
#include <fstream>
#include <string>
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

// Returns whether the mapping that holds an address asks for huge pages (VmFlags, proc(5)).
bool AsksForHugePages(const void* memory) {
  const auto address = reinterpret_cast<std::uintptr_t>(memory);
  std::ifstream maps("/proc/self/smaps");
  bool inside = false;
  for (std::string line; std::getline(maps, line);) {
    unsigned long long begin = 0, end = 0;
    if (std::sscanf(line.c_str(), "%llx-%llx ", &begin, &end) == 2) {
      inside = begin <= address && address < end;
    }
    if (inside && line.starts_with("VmFlags:")) return (line + " ").find(" hg ") != line.npos;
  }
  return false;
}

TEST(LargeMemory, ALargeBlockAsksForHugePages) {
  std::string modes;
  std::getline(std::ifstream("/sys/kernel/mm/transparent_hugepage/enabled"), modes);
  if (modes.empty()) GTEST_SKIP() << "the system has no transparent huge pages";
  if (modes.find("[never]") != modes.npos)
    GTEST_SKIP() << "transparent huge pages are switched off";
  // Memory of malloc may have been advised before.
  void* const memory =
      mmap(nullptr, kMegabytes, PROT_READ | PROT_WRITE, MAP_PRIVATE | MAP_ANONYMOUS, -1, 0);
  ASSERT_NE(memory, MAP_FAILED);
  const auto* const middle = static_cast<const std::byte*>(memory) + kMegabytes / 2;
  EXPECT_FALSE(AsksForHugePages(middle));
  AdviseHugePages(memory, kMegabytes);
  EXPECT_TRUE(AsksForHugePages(middle));
  munmap(memory, kMegabytes);
  std::vector<std::uint8_t> values;
  ResizeLarge(values, kMegabytes);
  EXPECT_TRUE(AsksForHugePages(values.data() + kMegabytes / 2));
}

// An advice about the page that a block shares with its neighbour would take the neighbour's bytes.
TEST(LargeMemory, OnlyWholePagesOfABlockAreReleased) {
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

TEST(LargeMemory, ABlockWithoutAWholePageKeepsItsValues) {
  const auto page = std::size_t(sysconf(_SC_PAGESIZE));
  std::vector<std::uint8_t> values(kMegabytes, 1);
  GivePagesBack(values.data() + 1, page / 2);
  EXPECT_EQ(std::count(values.begin(), values.end(), 1), std::ptrdiff_t(kMegabytes));
}

}  // namespace
}  // namespace skywave
