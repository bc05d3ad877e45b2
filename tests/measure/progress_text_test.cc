// Tests the estimates of the progress and its forms as text.
#include "bench/measure/progress_text.h"

#include <gtest/gtest.h>

#include <cmath>
#include <nlohmann/json.hpp>
#include <random>
#include <regex>

namespace skywave {
namespace {

TEST(ProgressEstimate, OnePictureEndsAtTheSpeedOfItsShare) {
  const ProgressEstimate estimate =
      Estimate({.share = 0.2, .samples = 1000, .seconds = 3, .picture_seconds = 3});
  EXPECT_DOUBLE_EQ(estimate.share, 0.2);
  EXPECT_DOUBLE_EQ(estimate.picture_seconds, 12);
  EXPECT_DOUBLE_EQ(estimate.seconds, 12);
  EXPECT_NEAR(estimate.samples_per_second, 1000 * 0.2 / 3, 1e-9);
}

TEST(ProgressEstimate, NothingIsKnownAtTheStart) {
  const ProgressEstimate estimate = Estimate({.pictures = 3, .share = 0.001, .picture_seconds = 2});
  EXPECT_LT(estimate.picture_seconds, 0);
  EXPECT_LT(estimate.seconds, 0);
}

TEST(ProgressEstimate, SeveralPicturesAreLikeTheFinishedOnes) {
  // Two of five were skipped, one took 10 s, one runs and one is left.
  const ProgressEstimate estimate = Estimate({.pictures_done = 3,
                                              .pictures = 5,
                                              .share = 0.5,
                                              .picture_seconds = 5,
                                              .timed_pictures = 1,
                                              .timed_seconds = 10});
  EXPECT_DOUBLE_EQ(estimate.share, 0.7);
  EXPECT_DOUBLE_EQ(estimate.picture_seconds, 5);
  EXPECT_DOUBLE_EQ(estimate.seconds, 15);
}

// Pictures take 10 s, give or take a third, and their tiles are not equally fast.
TEST(ProgressEstimate, DoesNotJump) {
  std::mt19937 random(7);
  std::uniform_real_distribution<double> factor(0.67, 1.33);
  ProgressState state = {.pictures = 20};
  double last = -1;
  for (; state.pictures_done < state.pictures; ++state.pictures_done) {
    const double seconds = 10 * factor(random), power = factor(random);
    for (int step = 0; step <= 100; ++step) {
      state.share = step / 100.0;
      state.picture_seconds = seconds * std::pow(state.share, power);
      const double left = Estimate(state).seconds;
      if (state.pictures_done > 0) {
        EXPECT_GT(left, -1e-9);
        // A new mean moves what is left of the others; else there is half a picture's time.
        const double others = double(state.pictures - state.pictures_done);
        const double mean = step == 0 ? 6.6 * others / double(state.pictures_done) : 0;
        EXPECT_LT(std::abs(left - last), 5 + mean) << state.pictures_done << " " << state.share;
      }
      last = left;
    }
    ++state.timed_pictures;
    state.timed_seconds += seconds;
  }
  EXPECT_NEAR(last, 0, 1e-9);
}

TEST(ProgressText, DurationsAreShort) {
  EXPECT_EQ(DurationText(0.2), "0 s");
  EXPECT_EQ(DurationText(59.4), "59 s");
  EXPECT_EQ(DurationText(200), "3:20");
  EXPECT_EQ(DurationText(3723), "1:02:03");
}

ProgressState ThirdOfTwenty() {
  return {.what = "grace_0003.exr",
          .pictures_done = 2,
          .pictures = 20,
          .share = 0.5,
          .samples = 2000000,
          .seconds = 25,
          .picture_seconds = 5,
          .timed_pictures = 2,
          .timed_seconds = 20};
}

TEST(ProgressText, BarIsALine) {
  EXPECT_EQ(BarText(ThirdOfTwenty()),
            "[##..................]  12 %  2:55 left  3 of 20: 50 %, 5 s, 0.20 Msamples/s  g");
  EXPECT_EQ(BarText({.share = 0.25, .seconds = 6, .picture_seconds = 6}),
            "[#####...............]  25 %  18 s left");
  EXPECT_EQ(BarText({}), "[....................]   0 %  estimating");
}

TEST(ProgressText, PlainTextHasEveryFigure) {
  EXPECT_EQ(PlainText(ThirdOfTwenty()),
            "12 % rendered, 2:55 left; 3 of 20: 50 %, 5 s left, 0.20 Msamples/s: grace_0003.exr\n");
}

TEST(ProgressText, JsonHasEveryKeyOnOneLine) {
  const std::string text = JsonText(ThirdOfTwenty());
  EXPECT_EQ(text.find('\n'), text.size() - 1);
  const nlohmann::json json = nlohmann::json::parse(text);
  EXPECT_EQ(json, nlohmann::json({{"share", 0.125},
                                  {"pictures_done", 2},
                                  {"pictures", 20},
                                  {"picture", "grace_0003.exr"},
                                  {"picture_share", 0.5},
                                  {"seconds", 25.0},
                                  {"seconds_left", 175.0},
                                  {"picture_seconds_left", 5.0},
                                  {"samples_per_second", 200000.0}}));
  EXPECT_TRUE(nlohmann::json::parse(JsonText({})).at("seconds_left").is_null());
}

TEST(ProgressText, JsonIsValidForAnyName) {
  ProgressState state;
  for (int c = 0; c < 256; ++c) state.what += char(c);
  const std::string text = JsonText(state);
  EXPECT_EQ(text.find('\n'), text.size() - 1);
  for (const char c : text) EXPECT_LT(static_cast<unsigned char>(c), 128);
  EXPECT_TRUE(nlohmann::json::accept(text));
}

// The patterns are those that sessions of Open Job Description look for.
TEST(ProgressText, OpenJobDescriptionReadsItsLines) {
  ProgressState state = ThirdOfTwenty();
  state.what = "two\nlines";
  const std::string text = OpenJdText(state);
  const std::regex lines("openjd_progress: ([0-9]+(\\.[0-9]+)?)\nopenjd_status: ([^\n]+)\n");
  std::smatch match;
  ASSERT_TRUE(std::regex_match(text, match, lines)) << text;
  EXPECT_EQ(match[1], "12.5");
  EXPECT_EQ(match[3], "3 of 20, 2:55 left, 0.20 Msamples/s: two lines");
  EXPECT_EQ(OpenJdFailure("a.pbrt:3: no\nshape"), "openjd_fail: a.pbrt:3: no shape\n");
}

TEST(ProgressText, EveryFormShowsTheEnd) {
  const ProgressState end = {.pictures_done = 20, .pictures = 20};
  EXPECT_EQ(OpenJdText(end), "openjd_progress: 100.0\nopenjd_status: 20 of 20, 0 s left\n");
  EXPECT_EQ(nlohmann::json::parse(JsonText(end)).at("share"), 1);
  EXPECT_TRUE(BarText(end).starts_with("[####################] 100 %")) << BarText(end);
}

}  // namespace
}  // namespace skywave
