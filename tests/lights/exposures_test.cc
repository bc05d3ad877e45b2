// Tests radiance from photographs: brackets of a known picture through a known response give it
// back, moved ones are moved over each other, and what cannot be said is counted or refused.
#include "lights/probe/exposures.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <functional>
#include <random>

#include "base/error.h"
#include "base/names.h"

namespace skywave {
namespace {

constexpr int kWidth = 120, kHeight = 60;

// Radiance over 5 decades, in tiles that differ, so that edges lie everywhere, with a gradient in
// each: of a few radiances alone no response can be known between their codes.
Image Scene() {
  Image image(kWidth, kHeight);
  std::mt19937 random(9);
  std::uniform_real_distribution<float> decade(-3, 2);
  std::vector<float> tiles(15 * 8);
  for (float& tile : tiles) tile = decade(random);
  tiles[0] = -3, tiles[1] = 2;
  for (int y = 0; y < kHeight; ++y) {
    for (int x = 0; x < kWidth; ++x) {
      const float within = 0.04f * float(x % 8) + 0.005f * float(y % 8);
      const float value = std::pow(10.0f, tiles[std::size_t(y / 8 * 15 + x / 8)] + within);
      float* pixel = image.Pixel(x, y);
      pixel[0] = value, pixel[1] = 0.7f * value, pixel[2] = 0.4f * value;
    }
  }
  return image;
}

// A response with a toe and a shoulder, as films and cameras have: the code in [0, 1] of an
// exposure.
double Film(double exposure) {
  const double scaled = std::pow(exposure / 0.5, 0.65);
  return scaled / (1 + scaled) * (1 + 0.15 * scaled / (1 + scaled)) / 1.15 * 1.25;
}

// Returns a photograph; `noise` is its deviation in codes, and it shows `scene` moved by (dx, dy).
Exposure Photograph(const Image& scene, double time, double noise, unsigned seed, int dx = 0,
                    int dy = 0) {
  std::mt19937 random(seed);
  std::normal_distribution<double> normal(0, 1);
  Image image(scene.width, scene.height);
  for (int y = 0; y < scene.height; ++y) {
    for (int x = 0; x < scene.width; ++x) {
      const float* from = scene.Pixel(std::clamp(x - dx, 0, scene.width - 1),
                                      std::clamp(y - dy, 0, scene.height - 1));
      for (int c = 0; c < 3; ++c) {
        const double code = std::round(255 * Film(from[c] * time) + noise * normal(random));
        image.Pixel(x, y)[c] = float(std::clamp(code, 0.0, 255.0) / 255);
      }
    }
  }
  return {.name = "photograph", .image = std::move(image), .coded = true, .exposure = time};
}

std::vector<Exposure> Brackets(const Image& scene, double noise) {
  std::vector<Exposure> exposures;
  unsigned seed = 1;
  for (double time = 256; time > 1e-4; time /= 4) {
    exposures.push_back(Photograph(scene, time, noise, seed++));
  }
  return exposures;
}

// Returns the ratios of the values of channel c in tiles to those of the scene, over the median.
std::vector<double> Ratios(const Image& image, const Image& scene, int c) {
  std::vector<double> ratios;
  for (int y = 0; y + 8 <= kHeight - 4; y += 8) {
    for (int x = 0; x + 8 <= kWidth; x += 8) {
      double sum = 0;
      for (int i = 0; i < 64; ++i) {
        sum += image.Pixel(x + i % 8, y + i / 8)[c] / double(scene.Pixel(x + i % 8, y + i / 8)[c]);
      }
      ratios.push_back(sum / 64);
    }
  }
  std::vector<double> sorted = ratios;
  std::nth_element(sorted.begin(), sorted.begin() + std::ptrdiff_t(sorted.size() / 2),
                   sorted.end());
  const double median = sorted[sorted.size() / 2];
  for (double& ratio : ratios) ratio /= median;
  return ratios;
}

TEST(Exposures, BracketsGiveTheSceneBackOverFiveDecades) {
  const Image scene = Scene();
  for (const ResponseMethod method : {ResponseMethod::kDebevec, ResponseMethod::kRobertson}) {
    const AssembledExposures made = AssembleExposures(Brackets(scene, 0.5), true, method);
    for (const auto& shift : made.shift) EXPECT_EQ(shift, (std::array<int, 2>{0, 0}));
    for (int c = 0; c < 3; ++c) {
      for (const double ratio : Ratios(made.image, scene, c)) {
        EXPECT_NEAR(ratio, 1, 0.02) << ToString(method);
      }
    }
  }
}

// The response is that of the film, up to its scale.
TEST(Exposures, TheResponseIsThatOfTheFilm) {
  const auto response_by = [](ResponseMethod method) {
    return *AssembleExposures(Brackets(Scene(), 0), true, method).response;
  };
  const auto exposure_of = [](double code) {
    double low = 1e-8, high = 1e4;
    for (int i = 0; i < 200; ++i) {
      const double middle = std::sqrt(low * high);
      (Film(middle) < code / 255 ? low : high) = middle;
    }
    return std::log(low);
  };
  for (const ResponseMethod method : {ResponseMethod::kDebevec, ResponseMethod::kRobertson}) {
    for (const CodeValues& g : response_by(method)) {
      EXPECT_NEAR(g[128], 0, 1e-6);
      for (int code = 20; code <= 235; code += 5) {
        EXPECT_NEAR(g[std::size_t(code)], exposure_of(code) - exposure_of(128), 0.03)
            << ToString(method) << " " << code;
      }
    }
  }
}

// x = sum(w t I) / sum(w t^2), with the bell of the paper for w.
TEST(Exposures, TheMeanOfRobertsonWeighsByTheSquareOfTheExposure) {
  const std::vector<Exposure> exposures = Brackets(Scene(), 2);
  const AssembledExposures made = AssembleExposures(exposures, false, ResponseMethod::kRobertson);
  const CodeValues& g = (*made.response)[0];
  for (const int x : {3, 40, 77, 110}) {
    double above = 0, below = 0;
    for (const Exposure& exposure : exposures) {
      const int code = CodeOf(exposure.image.Pixel(x, 20)[0]);
      if (code == 0 || code == 255) continue;
      const double bell = std::exp(-4 * std::pow((code - 127.5) / 127.5, 2)), t = exposure.exposure;
      above += bell * t * std::exp(g[std::size_t(code)]), below += bell * t * t;
    }
    EXPECT_NEAR(made.image.Pixel(x, 20)[0], above / below, 1e-5 * above / below);
  }
}

TEST(Exposures, NumbersInProportionToTheLightNeedNoResponse) {
  const Image scene = Scene();
  std::vector<Exposure> exposures;
  for (const double time : {1.0, 0.01, 1e-4}) {
    Image image = scene;
    for (float& value : image.rgb) value = std::min(1.0f, float(value * time));
    exposures.push_back({.name = "linear", .image = image, .coded = false, .exposure = time});
  }
  const AssembledExposures made = AssembleExposures(exposures, false);
  EXPECT_FALSE(made.response);
  for (std::size_t i = 0; i < scene.rgb.size(); ++i) {
    EXPECT_NEAR(made.image.rgb[i], scene.rgb[i], 1e-4f * scene.rgb[i]);
  }
  EXPECT_EQ(made.white, 0u);
}

TEST(Exposures, PhotographsFromTheHandAreMovedOverEachOther) {
  const Image scene = Scene();
  std::vector<Exposure> exposures = {Photograph(scene, 1, 0.5, 1, 5, -3),
                                     Photograph(scene, 0.25, 0.5, 2, 0, 0),
                                     Photograph(scene, 1 / 16.0, 0.5, 3, -4, 2)};
  const AssembledExposures made = AssembleExposures(exposures, true);
  EXPECT_EQ(made.shift[0], (std::array<int, 2>{5, -3}));
  EXPECT_EQ(made.shift[1], (std::array<int, 2>{0, 0}));
  EXPECT_EQ(made.shift[2], (std::array<int, 2>{-4, 2}));
  // Where the longest exposure shows the middle of the range, all of them show the same place.
  int middle = 0;
  const double unit = made.image.Pixel(60, 30)[1] / scene.Pixel(60, 30)[1];
  for (int y = 8; y < kHeight - 8; ++y) {
    for (int x = 8; x < kWidth - 8; ++x) {
      if (scene.Pixel(x, y)[1] < 0.3f || scene.Pixel(x, y)[1] > 3) continue;
      ++middle;
      EXPECT_NEAR(made.image.Pixel(x, y)[1] / scene.Pixel(x, y)[1] / unit, 1, 0.15);
    }
  }
  EXPECT_GT(middle, 300);
}

TEST(Exposures, WhatNoExposureShowsIsCounted) {
  Image scene(kWidth, kHeight);
  for (int y = 0; y < kHeight; ++y) {
    for (int x = 0; x < kWidth; ++x) {
      for (int c = 0; c < 3; ++c) scene.Pixel(x, y)[c] = std::exp2(float(x) / 20 - 3);
    }
  }
  for (int c = 0; c < 3; ++c) scene.Pixel(3, 3)[c] = 1e7f, scene.Pixel(5, 5)[c] = 0;
  const AssembledExposures made =
      AssembleExposures({Photograph(scene, 1, 0, 1), Photograph(scene, 0.5, 0, 2)}, false);
  EXPECT_EQ(made.white, 3u);
  EXPECT_EQ(made.black, 3u);
  EXPECT_GT(made.image.Pixel(3, 3)[0], made.image.Pixel(kWidth - 1, 0)[0]);
  EXPECT_LT(made.image.Pixel(5, 5)[0], made.image.Pixel(0, 0)[0]);
}

TEST(Exposures, WhatDoesNotGoTogetherIsRefused) {
  const Image scene = Scene();
  const Exposure one = Photograph(scene, 1, 0, 1), quarter = Photograph(scene, 0.25, 0, 2);
  const auto refused = [](std::vector<Exposure> exposures, const char* why) {
    try {
      AssembleExposures(std::move(exposures), false);
      ADD_FAILURE() << why;
    } catch (const InputError& error) {
      EXPECT_NE(std::string(error.what()).find(why), std::string::npos) << error.what();
    }
  };
  refused({one}, "two exposures");
  refused({one, one}, "has the exposure of all others");
  Exposure none = quarter;
  none.exposure = 0;
  refused({one, none}, "has no exposure above 0");
  Exposure small = quarter;
  small.image = Image(4, 4), small.name = "small.png";
  refused({one, small}, "small.png: is 4x4, and photograph is 120x60");
  Exposure linear = quarter;
  linear.coded = false;
  refused({one, linear}, "has radiance, and photograph has codes");
  Exposure swapped = quarter;
  swapped.exposure = 4;
  refused({one, swapped}, "codes do not grow");
}

}  // namespace
}  // namespace skywave
