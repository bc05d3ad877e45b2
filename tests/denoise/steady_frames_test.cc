// Frames of animations whose truth, motion and noise are known: what is left of their noise has to
// flicker less where they show the same, and nothing may trail behind what moves.
#include "job/denoise/frames.h"

#include <gtest/gtest.h>
#include <tbb/global_control.h>

#include <cmath>
#include <cstddef>
#include <cstdint>
#include <functional>
#include <string>
#include <vector>

#include "base/error.h"
#include "tests/support/noisy_picture.h"

namespace skywave {
namespace {

constexpr int kFrames = 7;

// Frames, each with noise of its own.
std::vector<Noisy> DrawFrames(const std::function<Truth(int frame)>& truth, std::uint32_t seed) {
  std::vector<Noisy> frames;
  for (int i = 0; i < kFrames; ++i) frames.push_back(Draw(truth(i), seed + std::uint32_t(i)));
  return frames;
}

// Gives a frame flow by what is seen in a pixel: pixels to the right from frame to frame.
void AddFlow(const std::function<float(int x, int y)>& speed, Noisy& noisy) {
  std::vector<float> right, left;
  for (int i = 0; i < kSide * kSide; ++i) {
    right.push_back(speed(i % kSide, i / kSide)), left.push_back(-right.back());
  }
  const std::vector<float> none(right.size(), 0), known(right.size(), 1);
  for (const auto& [layer, x] : {std::pair("flow", right), {"flow-back", left}}) {
    const std::string name = layer;
    noisy.layers.push_back({name + ".X", x});
    noisy.layers.push_back({name + ".Y", none});
    noisy.layers.push_back({name + ".A", known});
  }
}

CleanFrame CleanOf(const Noisy& noisy, const std::string& name = "frame.exr") {
  return CleanFrameOf(name, noisy.image, noisy.layers);
}

// Returns frame `here` of `frames`, steadied by those `around` it.
Denoised SteadyOf(const std::vector<Noisy>& frames, std::size_t here, std::size_t around = 2) {
  std::vector<CleanFrame> clean;
  for (std::size_t i = here - around; i <= here + around; ++i) clean.push_back(CleanOf(frames[i]));
  std::vector<const CleanFrame*> window;
  for (const CleanFrame& frame : clean) window.push_back(&frame);
  return Steady(window, around);
}

// Returns the mean over pixels of the variance of their values over pictures.
double Flicker(const std::vector<Image>& images) {
  const double n = double(images.size());
  double variance = 0;
  for (std::size_t i = 0; i < images[0].rgb.size(); i += 3) {
    double sum = 0, square = 0;
    for (const Image& image : images) {
      sum += double(image.rgb[i]), square += double(image.rgb[i]) * double(image.rgb[i]);
    }
    variance += (square - sum * sum / n) / (n - 1);
  }
  return variance / double(images[0].rgb.size() / 3);
}

double MeanOfColumns(const Image& image, int begin, int end) {
  double sum = 0;
  for (int y = 0; y < kSide; ++y) {
    for (int x = begin; x < end; ++x) sum += double(image.rgb[3 * std::size_t(y * kSide + x)]);
  }
  return sum / (kSide * (end - begin));
}

TEST(SteadyFrames, AFrameAloneIsWhatItWas) {
  const Noisy noisy = Draw(Slope, 1);
  const CleanFrame frame = CleanOf(noisy);
  const CleanFrame* const window[] = {&frame};
  EXPECT_EQ(Steady(window, 0).image.rgb, Clean(noisy).image.rgb);
}

// The means of disjoint windows of five frames would vary by a fifth of what frames do, if all of
// them counted alike.
TEST(SteadyFrames, StillSurfacesFlickerByAThirdAtMost) {
  for (const Truth& truth : {Truth(Flat), Truth(Slope), Truth(Checkered)}) {
    std::vector<Image> alone, steady;
    for (std::uint32_t i = 0; i < 6; ++i) {
      const std::vector<Noisy> frames = DrawFrames([&](int) { return truth; }, 100 * i);
      alone.push_back(Clean(frames[2]).image);
      steady.push_back(SteadyOf(frames, 2).image);
    }
    EXPECT_LT(Flicker(steady), Flicker(alone) / 3);
  }
}

TEST(SteadyFrames, IntervalsCoverTheStatedShareOfErrors) {
  for (const Truth& truth : {Truth(Flat), Truth(Slope), Truth(Steps), Truth(Checkered)}) {
    const std::vector<Noisy> frames = DrawFrames([&](int) { return truth; }, 7);
    const double coverage = Coverage(SteadyOf(frames, 3), truth);
    EXPECT_GT(coverage, 0.93);
  }
}

// The edge of a shadow moves over a wall that stands still: no flow tells of it.
TEST(SteadyFrames, MovingShadowsLeaveNoGhosts) {
  const auto edge = [](int frame) { return 30 + 4 * frame; };
  const auto truth = [&](int frame) -> Truth {
    return [=](int x, int) { return Pixel{.light = x < edge(frame) ? 1.0 : 3.0}; };
  };
  const Image steady = SteadyOf(DrawFrames(truth, 11), 3).image;
  EXPECT_NEAR(MeanOfColumns(steady, edge(2), edge(3)), 1, 0.02);
  EXPECT_NEAR(MeanOfColumns(steady, edge(3), edge(4)), 3, 0.06);
}

// A bright thing moves over a wall that is hardly darker: noise hides the difference, but flow
// tells what the other frames show.
TEST(SteadyFrames, WhatMovesIsFollowedAndWhatItHidIsNotTakenForIt) {
  constexpr int kStep = 5, kWide = 20;
  const auto left = [](int frame) { return 20 + kStep * frame; };
  const auto is_thing = [&](int frame, int x) {
    return x >= left(frame) && x < left(frame) + kWide;
  };
  const auto truth = [&](int frame) -> Truth {
    return [=](int x, int) {
      return Pixel{.light = is_thing(frame, x) ? 1.06 : 1.0, .deviation = 0.5};
    };
  };
  std::vector<Noisy> frames = DrawFrames(truth, 23);
  for (int i = 0; i < kFrames; ++i) {
    AddFlow([&](int x, int) { return is_thing(i, x) ? float(kStep) : 0.0f; },
            frames[std::size_t(i)]);
    // So that each frame by itself keeps them apart.
    for (int p = 0; p < kSide * kSide; ++p) {
      if (is_thing(i, p % kSide))
        frames[std::size_t(i)].at("shading-normal.X")[std::size_t(p)] = 0.3f;
    }
  }
  const Denoised steady = SteadyOf(frames, 3);
  const Image& image = steady.image;
  EXPECT_LT(SquaredError(image, truth(3)), 0.4 * SquaredError(Clean(frames[3]).image, truth(3)));
  EXPECT_NEAR(MeanOfColumns(image, left(3), left(3) + kWide), 1.06, 0.01);
  EXPECT_NEAR(MeanOfColumns(image, left(3) - 2 * kStep, left(3)), 1, 0.01);
  EXPECT_NEAR(MeanOfColumns(image, left(3) + kWide, left(3) + kWide + 2 * kStep), 1, 0.01);
}

// Waves of light move by three tenths of a pixel from frame to frame.
TEST(SteadyFrames, FlowMayBeFractionsOfAPixel) {
  const auto truth = [](int frame) -> Truth {
    return [=](int x, int) {
      return Pixel{.light = 1 + 0.4 * std::sin((x - 0.3 * frame) * 0.3), .deviation = 0.3};
    };
  };
  std::vector<Noisy> frames = DrawFrames(truth, 71);
  for (Noisy& frame : frames) AddFlow([](int, int) { return 0.3f; }, frame);
  EXPECT_LT(SquaredError(SteadyOf(frames, 3).image, truth(3)),
            0.75 * SquaredError(Clean(frames[3]).image, truth(3)));
}

// A wall of one colour and one normal comes out from behind another one: only the way back of flow
// tells that they are two.
TEST(SteadyFrames, WhatIsHiddenElsewhereIsNotTakenFromThere) {
  constexpr int kStep = 6;
  const auto edge = [](int frame) {
    return 20 + kStep * frame;
  };  // of what is in front, on the left
  const auto truth = [&](int frame) -> Truth {
    return
        [=](int x, int) { return Pixel{.light = x < edge(frame) ? 1.2 : 1.0, .deviation = 2.5}; };
  };
  constexpr int kRuns = 4;
  double more = 0;
  for (std::uint32_t run = 0; run < kRuns; ++run) {
    std::vector<Noisy> frames = DrawFrames(truth, 100 * run);
    for (int i = 1; i < 6; ++i) {
      AddFlow([&](int x, int) { return x < edge(i) ? float(kStep) : 0.0f; },
              frames[std::size_t(i)]);
    }
    // What the next frame hides is seen now. Alone it has some of the light of what is in front,
    // from neighbours; other frames have less of that, and hidden ones would bring more.
    const double alone = MeanOfColumns(Clean(frames[3]).image, edge(3), edge(4));
    const double steady = MeanOfColumns(SteadyOf(frames, 3).image, edge(3), edge(4));
    more += (steady - alone) / kRuns;
  }
  EXPECT_LT(more, 0);
}

// What a mirror shows moves, and flow is that of the mirror, which rests. What noise hides is
// mixed, which adds less to the error than noise does.
TEST(SteadyFrames, MirrorImagesAreMixedWithinTheirNoiseOnly) {
  const auto truth = [](int frame) -> Truth {
    return [=](int x, int) {
      return Pixel{.light = 1 + 0.15 * std::sin((x - 4 * frame) * 0.25), .deviation = 0.7};
    };
  };
  const std::vector<Noisy> frames = DrawFrames(truth, 83);
  const double alone = SquaredError(Clean(frames[3]).image, truth(3));
  EXPECT_LT(SquaredError(SteadyOf(frames, 3).image, truth(3)), 1.3 * alone);
}

// Things come nearer, which changes their depth and not what they are.
TEST(SteadyFrames, DepthMayChangeWhereFlowTellsWhatIsTheSame) {
  std::vector<Noisy> frames = DrawFrames([](int) -> Truth { return Flat; }, 41);
  for (int i = 0; i < kFrames; ++i) {
    Noisy& frame = frames[std::size_t(i)];
    for (float& depth : frame.at("depth.Z")) depth = 4 * std::pow(0.8f, float(i));
  }
  const double alone = SquaredError(Clean(frames[3]).image, Flat);
  // Without flow they are another thing.
  EXPECT_NEAR(SquaredError(SteadyOf(frames, 3).image, Flat) / alone, 1, 0.01);
  for (Noisy& frame : frames) AddFlow([](int, int) { return 0.0f; }, frame);
  EXPECT_LT(SquaredError(SteadyOf(frames, 3).image, Flat), 0.4 * alone);
}

// A lamp on the right is switched on in every other frame, which changes the unit of light there.
TEST(SteadyFrames, FramesOfOtherBrightnessAgree) {
  const auto truth = [](int frame) -> Truth {
    return [=](int x, int) {
      const bool is_lamp = x >= 64;
      return is_lamp ? Pixel{.light = frame % 2 == 0 ? 1.0 : 100.0, .deviation = 0} : Pixel{};
    };
  };
  const std::vector<Noisy> frames = DrawFrames(truth, 53);
  const CleanFrame even = CleanOf(frames[2]), odd = CleanOf(frames[3]);
  ASSERT_NE(even.planes.brightness, odd.planes.brightness);
  const auto error = [&](const Image& image) {
    double sum = 0;
    for (int i = 0; i < kSide * kSide; ++i) {
      if (i % kSide < 56) sum += std::pow(double(image.rgb[3 * std::size_t(i)]) - 1, 2);
    }
    return sum;
  };
  EXPECT_LT(error(SteadyOf(frames, 3).image), 0.4 * error(Clean(frames[3]).image));
}

// The excess of an outlier is shared by the frames that show the same, and none of it is lost.
TEST(SteadyFrames, OutliersAreSpreadOverFrames) {
  const std::vector<Noisy> frames = DrawFrames([](int) -> Truth { return Flat; }, 61);
  std::vector<Noisy> with = frames;
  const std::size_t at = 48 * kSide + 50;
  for (const int c : {0, 1, 2}) {
    const std::string channel(1, "RGB"[c]);
    with[3].image.rgb[3 * at + std::size_t(c)] += 100;
    with[3].at("half." + channel)[at] += 200;
    with[3].at("variance." + channel)[at] += 16 * 10000;
    with[3].at("half-variance." + channel)[at] += 16 * 20000;
  }
  for (const std::size_t here : {2u, 3u, 4u}) {
    SCOPED_TRACE(here);
    const Denoised clean = SteadyOf(with, here);
    const double more = Sum(clean.image) - Sum(SteadyOf(frames, here).image);
    EXPECT_NEAR(more / 300, 0.2, 0.01);
    EXPECT_EQ(clean.outliers, here == 3 ? 1u : 0u);
  }
}

// What a thread has brought before for another tile does not matter where frames do not show a
// point.
TEST(SteadyFrames, BytesDoNotDependOnThreads) {
  // The edge of what is in front is elsewhere in each row of tiles.
  const auto is_front = [](int frame, int x, int y) {
    return x < 10 + 6 * frame + y / FilterTile::kHeight * 13 % 40;
  };
  const auto truth = [&](int frame) -> Truth {
    return [=](int x, int y) { return Pixel{.light = is_front(frame, x, y) ? 1.1 : 1.0}; };
  };
  std::vector<Noisy> frames = DrawFrames(truth, 91);
  for (int i = 0; i < kFrames; ++i) {
    AddFlow([&](int x, int y) { return is_front(i, x, y) ? 6.0f : 0.0f; }, frames[std::size_t(i)]);
  }
  std::vector<std::uint32_t> bits;
  for (const std::size_t threads : {1, 2, 7, 2}) {
    const tbb::global_control control(tbb::global_control::max_allowed_parallelism, threads);
    const std::vector<std::uint32_t> these = Bits(SteadyOf(frames, 3));
    if (bits.empty()) bits = these;
    EXPECT_EQ(these, bits) << threads;
  }
}

TEST(SteadyFrames, UnusableFramesAreRefused) {
  const auto expect_refused = [](const auto& work, const std::string& words) {
    try {
      work();
      ADD_FAILURE() << "nothing was thrown instead of " << words;
    } catch (const InputError& error) {
      EXPECT_NE(std::string(error.what()).find(words), std::string::npos) << error.what();
    }
  };
  const Noisy plain = Draw(Flat, 1);
  Noisy flowing = plain, half = plain;
  AddFlow([](int, int) { return 0.0f; }, flowing);
  half.layers.push_back({"flow.A", std::vector<float>(kSide * kSide, 1)});
  expect_refused([&] { CleanOf(half); },
                 "has some of the channels of flow and flow-back, and not flow-back.A");
  const CleanFrame frame = CleanOf(plain, "a.exr"), other = CleanOf(flowing, "b.exr"),
                   small = CleanOf(Draw(Flat, 1, 32, 24), "c.exr");
  const auto steady = [&](const CleanFrame& beside) {
    const CleanFrame* const window[] = {&frame, &beside};
    Steady(window, 0);
  };
  expect_refused([&] { steady(other); }, "b.exr: has flow, and the frame a.exr has none");
  expect_refused([&] { steady(small); }, "c.exr: has 32x24 pixels, and the frame a.exr has 96x96");
}

}  // namespace
}  // namespace skywave
