// Holds the comparison with noise to pictures whose noise is known.

#include "bench/measure/picture_noise.h"

#include <gtest/gtest.h>

#include <cmath>
#include <random>

namespace skywave {
namespace {

constexpr int kWidth = 200, kHeight = 150;

struct Rendered {
  Image image{kWidth, kHeight};
  PictureNoise noise;
};

// Averages `samples` normal numbers in each channel of each pixel, whose mean is `mean` and whose
// variance grows from pixel to pixel.
Rendered Render(int samples, double mean, unsigned seed) {
  std::mt19937 random(seed);
  std::normal_distribution<double> normal;
  Rendered rendered;
  rendered.noise.samples.assign(rendered.image.rgb.size() / 3, float(samples));
  for (std::size_t i = 0; i < rendered.image.rgb.size(); ++i) {
    const double sigma = 0.1 + double(i) / double(rendered.image.rgb.size());
    double sum = 0, squares = 0;
    for (int s = 0; s < samples; ++s) {
      const double value = sigma * normal(random);
      sum += value, squares += value * value;
    }
    rendered.image.rgb[i] = float(mean + sum / samples);
    rendered.noise.variance.push_back(float((squares - sum * sum / samples) / (samples - 1)));
  }
  return rendered;
}

TEST(PictureNoise, OfPicturesThatDifferByNoiseAlone) {
  for (const int samples : {4, 32}) {
    const Rendered a = Render(samples, 1, 1), b = Render(2 * samples, 1, 2);
    const NoiseComparison c = CompareNoise(a.image, a.noise, b.image, b.noise);
    EXPECT_EQ(c.values, a.image.rgb.size());
    EXPECT_EQ(c.exact_values, 0u);
    // 90 000 values: a standard deviation of 0.0007. The degrees of freedom of two estimates are
    // approximate, the more so the fewer samples there are.
    EXPECT_NEAR(c.exceeding, 0.05, samples == 4 ? 0.006 : 0.003);
    for (int channel = 0; channel < 3; ++channel) {
      EXPECT_LT(std::abs(c.mean_difference[channel]), 2 * c.half_width[channel]);
      // The mean of sigma^2 is 0.1^2 + 0.1 + 1/3, over the samples of either.
      const double variance = (0.01 + 0.1 + 1.0 / 3) * 1.5 / samples;
      EXPECT_NEAR(c.half_width[channel], 1.96 * std::sqrt(variance / (kWidth * kHeight)),
                  0.02 * c.half_width[channel]);
    }
    if (samples == 32) {
      EXPECT_NEAR(c.mean_squared_z, 1.04, 0.02);
    }
  }
}

TEST(PictureNoise, ComparesWithAnExactPicture) {
  const Rendered a = Render(8, 0.5, 3);
  Image exact(kWidth, kHeight);
  for (float& value : exact.rgb) value = 0.5f;
  // Student's distribution is exact here, and the mean of t^2 with 7 degrees of freedom is 7 / 5.
  const NoiseComparison c = CompareNoise(a.image, a.noise, exact, std::nullopt);
  EXPECT_NEAR(c.exceeding, 0.05, 0.003);
  EXPECT_NEAR(c.mean_squared_z, 1.4, 0.05);
}

TEST(PictureNoise, FindsADifferenceThatNoiseDoesNotExplain) {
  const Rendered a = Render(16, 1.01, 4), b = Render(16, 1, 5);
  const NoiseComparison c = CompareNoise(a.image, a.noise, b.image, b.noise);
  for (int channel = 0; channel < 3; ++channel) {
    EXPECT_NEAR(c.mean_difference[channel], 0.01, c.half_width[channel]);
    EXPECT_GT(c.mean_difference[channel], 2 * c.half_width[channel]);
  }
}

TEST(PictureNoise, CountsValuesWithoutVariance) {
  Image image(2, 1), reference(2, 1);
  image.rgb = {1, 1, 1, 1, 2, 1};
  reference.rgb = {1, 1, 1, 1, 1, 1};
  const PictureNoise noise = {{0.5f, 0, 0, 0, 0, 0}, {4, 4}};
  const NoiseComparison c = CompareNoise(image, noise, reference, std::nullopt);
  EXPECT_EQ(c.values, 1u);
  EXPECT_EQ(c.exact_values, 5u);
  EXPECT_EQ(c.exact_that_differ, 1u);
  EXPECT_EQ(c.exceeding, 0);
}

TEST(PictureNoise, IsReadByTheNamesOfItsChannels) {
  std::vector<NamedChannel> layers;
  for (const std::string& name : NoiseChannels()) {
    layers.push_back({name, std::vector<float>(2, float(layers.size()))});
  }
  const PictureNoise noise = NoiseOf(layers);
  EXPECT_EQ(noise.variance, (std::vector<float>{0, 1, 2, 0, 1, 2}));
  EXPECT_EQ(noise.samples, (std::vector<float>{3, 3}));
}

}  // namespace
}  // namespace skywave
