// Tests sums of pictures against the same sums, written out.
#include "image/weighted_sums.h"

#include <gtest/gtest.h>

#include <cmath>

namespace skywave {
namespace {

using Factors = std::vector<std::array<float, 3>>;

Image Ramp(int width, int height, float start) {
  Image image(width, height);
  for (std::size_t i = 0; i < image.rgb.size(); ++i) image.rgb[i] = start + 0.37f * float(i);
  return image;
}

// The last pixels of lines of every length are added too.
TEST(WeightedSums, AreThoseOfEachRowOfFactors) {
  for (int width = 1; width <= 9; ++width) {
    const std::vector<Image> images = {Ramp(width, 3, 0.1f), Ramp(width, 3, -2), Ramp(width, 3, 5)};
    const std::vector<Factors> rows = {{{1, 2, 3}, {0.5f, 0, -1}, {0, 0.3f, 1}},
                                       {{1, 1, 1}, {1, 1, 1}, {1, 1, 1}}};
    const std::vector<Image> sums = WeightedSums(images, rows);
    ASSERT_EQ(sums.size(), rows.size());
    for (std::size_t row = 0; row < rows.size(); ++row) {
      ASSERT_EQ(sums[row].rgb.size(), images[0].rgb.size());
      for (std::size_t i = 0; i < images[0].rgb.size(); ++i) {
        double expected = 0;
        for (std::size_t image = 0; image < images.size(); ++image) {
          expected += double(rows[row][image][i % 3]) * double(images[image].rgb[i]);
        }
        EXPECT_EQ(sums[row].rgb[i], float(expected)) << width << " " << row << " " << i;
      }
    }
  }
}

// A sum in float would lose the small one.
TEST(WeightedSums, AreMadeInDouble) {
  std::vector<Image> images(3, Image(4, 1));
  for (std::size_t i = 0; i < 12; ++i) {
    images[0].rgb[i] = 1e8f, images[1].rgb[i] = 1, images[2].rgb[i] = -1e8f;
  }
  const Factors ones(3, {1, 1, 1});
  const std::vector<Image> sums = WeightedSums(images, {&ones, 1});
  for (const float sum : sums.front().rgb) EXPECT_EQ(sum, 1);
}

}  // namespace
}  // namespace skywave
