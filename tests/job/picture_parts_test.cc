// Tests which parts of a picture are left without others.
#include <gtest/gtest.h>

#include <cstdint>
#include <random>
#include <vector>

#include "job/merge_films.h"

namespace skywave {
namespace {

TEST(PictureParts, MissingBoxesMatchACountOfSamples) {
  constexpr int kSide = 6;
  std::mt19937 random(3);
  const auto box = [&] {
    const auto range = [&](int& first, int& count) {
      first = int(random() % kSide);
      count = int(1 + random() % unsigned(kSide - first));
    };
    int x, y, first, width, height, count;
    range(x, width), range(y, height), range(first, count);
    return PicturePart{{x, y, width, height}, {std::uint32_t(first), std::uint32_t(first + count)}};
  };
  const auto add = [](std::vector<int>& voxels, const PicturePart& part, int value) {
    for (std::uint32_t s = part.samples.first; s < part.samples.end; ++s) {
      for (int y = part.window.y; y < part.window.y + part.window.height; ++y) {
        for (int x = part.window.x; x < part.window.x + part.window.width; ++x) {
          int& voxel = voxels[std::size_t((int(s) * kSide + y) * kSide + x)];
          voxel = value < 0 ? 0 : voxel + value;
        }
      }
    }
  };
  for (int i = 0; i < 300; ++i) {
    std::vector<PicturePart> parts = {box()};
    std::vector<int> expected(kSide * kSide * kSide);
    add(expected, parts[0], 1);
    for (int holes = 0; holes < 4; ++holes) {
      const PicturePart hole = box();
      parts = Without(parts, hole);
      add(expected, hole, -1);
      std::vector<int> left(expected.size());
      for (const PicturePart& part : parts) add(left, part, 1);
      ASSERT_EQ(left, expected) << "box " << i;
    }
  }
}

}  // namespace
}  // namespace skywave
