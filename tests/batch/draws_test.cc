// Tests what [random] of a job file draws: its distributions, and that a value depends on the seed,
// the number of its draw and its option alone.
#include "job/batch/draws.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdio>
#include <cstdlib>
#include <filesystem>
#include <map>
#include <numbers>
#include <string>
#include <vector>

#include "base/error.h"
#include "job/batch/plan.h"
#include "tests/support/statistics.h"
#include "tests/support/temporary_folder.h"

namespace skywave {
namespace {

constexpr std::size_t kDraws = 20000;
const double kLevel = SidakLevel(40);

// Returns values of an option that is drawn from `text`.
std::vector<std::string> Drawn(const std::string& text, std::uint64_t seed = 5,
                               const std::string& name = "x") {
  const JobValue file = ParseJobFile("job.toml", name + " = " + text);
  const Distribution distribution =
      ReadDistribution("job.toml", file.table.front(),
                       [](const JobValue& value) { return std::vector{value.text}; });
  std::vector<std::string> values;
  for (std::size_t i = 0; i < kDraws; ++i) {
    DrawNumbers numbers(seed, i, name);
    values.push_back(distribution(numbers));
  }
  return values;
}

std::vector<double> Numbers(const std::vector<std::string>& texts) {
  std::vector<double> numbers;
  for (const std::string& text : texts) numbers.push_back(std::strtod(text.c_str(), nullptr));
  return numbers;
}

std::vector<std::array<double, 3>> Points(const std::vector<std::string>& texts) {
  std::vector<std::array<double, 3>> points;
  for (const std::string& text : texts) {
    std::array<double, 3> point = {};
    EXPECT_EQ(std::sscanf(text.c_str(), "%lf,%lf,%lf", &point[0], &point[1], &point[2]), 3);
    points.push_back(point);
  }
  return points;
}

// Tests that values have the distribution whose function is `cumulative`.
template <class F>
void ExpectDistribution(const std::vector<double>& values, const F& cumulative) {
  std::vector<float> uniform;
  for (const double value : values) uniform.push_back(float(cumulative(value)));
  EXPECT_TRUE(IsUniform(uniform, kLevel));
}

TEST(Draws, OfNumbersAreUniformInTheirScale) {
  ExpectDistribution(Numbers(Drawn("{ from = -30, to = 90 }")),
                     [](double x) { return (x + 30) / 120; });
  ExpectDistribution(Numbers(Drawn("{ from = 5, to = 2 }")), [](double x) { return (5 - x) / 3; });
  ExpectDistribution(Numbers(Drawn("{ from = 0.01, to = 100, scale = \"log\" }")),
                     [](double x) { return std::log(x / 0.01) / std::log(1e4); });
}

TEST(Draws, OfWholeNumbersHaveBothEnds) {
  std::vector<double> counts(4), expected(4, double(kDraws) / 4);
  for (const double value : Numbers(Drawn("{ from = -1, to = 2, whole = true }"))) {
    ASSERT_EQ(value, std::floor(value));
    ++counts.at(std::size_t(value + 1));
  }
  EXPECT_TRUE(MatchesExpected(counts, expected, kLevel));
}

TEST(Draws, OfANormalDistributionAreNormal) {
  ExpectDistribution(Numbers(Drawn("{ mean = 3, deviation = 0.5 }")),
                     [](double x) { return 0.5 * std::erfc((3 - x) / 0.5 / std::numbers::sqrt2); });
}

TEST(Draws, OfPointsAreUniformInTheirBox) {
  const auto points = Points(Drawn("{ from = [0, -1, 4], to = [2, 1, 4] }"));
  for (const std::size_t axis : {0, 1}) {
    std::vector<double> values;
    for (const auto& point : points) values.push_back(point[axis]);
    ExpectDistribution(values, [&](double x) { return (x + double(axis)) / 2; });
  }
  std::vector<double> differences;  // modulo 1, uniform if both are independent
  for (const auto& point : points) {
    ASSERT_EQ(point[2], 4);
    const double difference = point[0] / 2 - (point[1] + 1) / 2;
    differences.push_back(difference - std::floor(difference));
  }
  ExpectDistribution(differences, [](double x) { return x; });
}

// Directions are uniform by solid angle: so are the heights on a unit sphere.
TEST(Draws, AroundAPointAreUniformOnTheSphere) {
  for (const std::string up : {"x", "y", "z"}) {
    SCOPED_TRACE(up);
    const std::size_t axis = std::size_t(up[0] - 'x');
    std::vector<double> heights, distances, turns;
    for (const auto& point : Points(Drawn("{ around = [1, 2, 3], distance = { from = 4, to = 6 }, "
                                          "elevation = { from = 30, to = 90 }, up = \"" +
                                          up + "\" }"))) {
      const double v[3] = {point[0] - 1, point[1] - 2, point[2] - 3};
      const double distance = std::hypot(v[0], v[1], v[2]);
      distances.push_back(distance), heights.push_back(v[axis] / distance);
      turns.push_back(std::atan2(v[(axis + 1) % 3], v[(axis + 2) % 3]));
    }
    ExpectDistribution(distances, [](double x) { return (x - 4) / 2; });
    ExpectDistribution(heights, [](double x) { return (x - 0.5) / 0.5; });
    ExpectDistribution(turns, [](double x) { return x / (2 * std::numbers::pi) + 0.5; });
  }
  // Angles that are given are those of the points.
  for (const auto& point :
       Points(Drawn("{ around = [0, 0, 0], distance = 2, elevation = 30, azimuth = 90 }"))) {
    ASSERT_NEAR(point[0], 0, 1e-8);
    ASSERT_NEAR(point[1], 1, 1e-8);
    ASSERT_NEAR(std::abs(point[2]) + std::abs(point[0]), std::sqrt(3), 1e-8);
  }
}

TEST(Draws, OfValuesHaveTheirWeights) {
  const auto count = [](const std::vector<std::string>& values) {
    std::vector<double> counts(3);
    for (const std::string& value : values) ++counts.at(std::size_t(std::stoi(value)));
    return counts;
  };
  const double n = kDraws;
  EXPECT_TRUE(MatchesExpected(count(Drawn("[0, 1, 2]")), std::vector{n / 3, n / 3, n / 3}, kLevel));
  EXPECT_TRUE(MatchesExpected(count(Drawn("{ of = [0, 1, 2], weights = [1, 0, 3] }")),
                              std::vector{n / 4, 0.0, 3 * n / 4}, kLevel));
}

TEST(Draws, OfTextsFillEachPlace) {
  const auto points = Points(
      Drawn("{ text = \"{a},{b},{a}\", a = { from = 0, to = 1 }, b = { from = 2, to = 3 } }"));
  std::vector<double> a, b;
  for (const auto& point : points) {
    ASSERT_EQ(point[0], point[2]);
    a.push_back(point[0]), b.push_back(point[1]);
  }
  ExpectDistribution(a, [](double x) { return x; });
  ExpectDistribution(b, [](double x) { return x - 2; });
}

TEST(Draws, OfOtherSeedsAndOptionsAreOthers) {
  const std::string text = "{ from = 0, to = 1 }";
  const std::vector<std::string> values = Drawn(text);
  EXPECT_EQ(Drawn(text), values);
  for (const auto& others : {Drawn(text, 6), Drawn(text, 5, "y")}) {
    const std::vector<double> a = Numbers(values), b = Numbers(others);
    std::vector<double> differences;  // modulo 1, uniform if both are independent
    for (std::size_t i = 0; i < kDraws; ++i) {
      differences.push_back(a[i] - b[i] + (a[i] < b[i] ? 1 : 0));
    }
    ExpectDistribution(differences, [](double x) { return x; });
  }
}

class RandomPlan : public testing::Test {
 protected:
  BatchPlan Read(const std::string& random) const {
    return ReadBatchPlan(
        folder_.Write("job.toml", "[base]\nscene = \"spheres\"\n" + random +
                                      "[output]\npath = \"{random:03}_{env}_{env-rotate}.exr\"\n"));
  }
  TemporaryFolder folder_;
};

TEST_F(RandomPlan, DrawsThePicturesOfASeed) {
  for (const char* const map : {"a.hdr", "b.hdr", "c.exr"}) folder_.Write(map, "");
  const std::string draw =
      "[random.draw]\nenv = { of = [\"*.hdr\", \"c.exr\"], weights = [1, 3] }\n"
      "env-rotate = { from = 0, to = 360 }\n";
  const BatchPlan few = Read("[random]\npictures = 10\nseed = 3\n" + draw),
                  many = Read("[random]\npictures = 400\nseed = 3\n" + draw),
                  others = Read("[random]\npictures = 10\nseed = 4\n" + draw);
  ASSERT_EQ(few.pictures.size(), 10u);
  ASSERT_EQ(many.pictures.size(), 400u);
  std::map<std::string, double> maps;
  for (std::size_t i = 0; i < 400; ++i) {
    const BatchPicture& picture = many.pictures[i];
    ASSERT_EQ(picture.axes.size(), 3u);
    EXPECT_EQ(picture.axes[0].label, std::to_string(i));
    const JobRequest job = RequestOf(many.path, picture.options).job;
    EXPECT_EQ(job.environment.rotation_degrees, std::stof(picture.axes[2].label));
    EXPECT_EQ(std::filesystem::path(job.environment.path).stem(), picture.axes[1].label);
    ++maps[picture.axes[1].label];
    if (i >= 10) continue;
    EXPECT_EQ(few.pictures[i].output, picture.output);
    EXPECT_NE(others.pictures[i].output, picture.output);
  }
  EXPECT_TRUE(MatchesExpected(std::vector{maps["a"], maps["b"], maps["c"]},
                              std::vector{50.0, 50.0, 300.0}, kLevel));
  ASSERT_EQ(few.dimensions.size(), 1u);
  EXPECT_EQ(few.dimensions[0].name, "random");
  EXPECT_EQ(few.dimensions[0].labels[7], "7");
}

TEST_F(RandomPlan, RefusesWhatItCannotDraw) {
  const struct {
    std::string draw;
    std::size_t line;
    std::string word;
  } cases[] = {
      {"[random]\npictures = 3\n", 3, "random.draw"},
      {"[random]\nseed = 3\n[random.draw]\nseed = [1]\n", 3, "pictures"},
      {"[random]\npictures = 3\ncount = 1\n", 5, "count"},
      {"[random]\npictures = 1.5\n", 4, "whole number"},
      {"[random]\npictures = 3\n[random.draw]\nenv-rotat = [1]\n", 6, "env-rotate"},
      {"[random]\npictures = 3\n[random.draw]\nspp = [0]\n", 6, "spp"},
      {"[random]\npictures = 3\n[random.draw]\nspp = 4\n", 6, "[base]"},
      {"[random]\npictures = 3\n[random.draw]\nscene = [\"spheres\"]\n", 6, "already"},
      {"[random]\npictures = 3\n[random.draw]\nspp = { from = 1 }\n", 6, "'to'"},
      {"[random]\npictures = 3\n[random.draw]\nspp = []\n", 6, "nothing to choose"},
      {"[random]\npictures = 3\n[random.draw]\nspp = { of = [1, 2], weights = [1] }\n", 6,
       "2 values and 1 weights"},
      {"[random]\npictures = 3\n[random.draw]\nspp = { of = [1], weights = [0] }\n", 6,
       "all weights"},
      {"[random]\npictures = 3\n[random.draw]\nenv-rotate = { from = -1, to = 1, scale = "
       "\"log\" }\n",
       6, "above 0"},
      {"[random]\npictures = 3\n[random.draw]\neye = { around = [1, 2], distance = 1 }\n", 6,
       "three numbers"},
      {"[random]\npictures = 3\n[random.draw]\nmaterial = { text = \"a={b}\" }\n", 6, "{b}"},
      {"[random]\npictures = 3\n[random.draw]\nenv = \"*.exr\"\n", 6, "no file is like"}};
  for (const auto& [draw, line, word] : cases) {
    SCOPED_TRACE(draw);
    try {
      Read(draw);
      ADD_FAILURE() << "not refused";
    } catch (const InputError& error) {
      EXPECT_EQ(error.place(), ToString(InputPosition::Line(folder_.Path("job.toml"), line)))
          << error.what();
      EXPECT_NE(std::string(error.what()).find(word), std::string::npos) << error.what();
    }
  }
}

}  // namespace
}  // namespace skywave
