// Tests what the pictures of `skywave probe plot` show.
#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <nlohmann/json.hpp>
#include <numbers>
#include <string>
#include <utility>

#include "base/error.h"
#include "base/files.h"
#include "image/image.h"
#include "lights/probe/calibration.h"
#include "tests/support/probe_command.h"

namespace skywave {
namespace {

// A grey map stays grey by its tone, and is coloured by its luminance.
TEST_F(ProbeCommand, PlotsAreColouredAsAsked) {
  Image map(32, 16);
  for (std::size_t i = 0; i < map.rgb.size(); ++i) map.rgb[i] = i < map.rgb.size() / 2 ? 0.5f : 4;
  WriteExr(File("grey.exr"), map);
  const auto coloured = [&](const std::string& color) {
    EXPECT_EQ(Probe("plot grey.exr -o p.png --what map --height 64 --color " + color), 0) << out_;
    const Image picture = DecodeTexture("p.png", ReadFile(File("p.png")), Encoding::kLinear);
    std::size_t count = 0;
    for (int y = 0; y < picture.height; ++y) {
      for (int x = 0; x < picture.width; ++x) {
        const float* const rgb = picture.Pixel(x, y);
        count += std::abs(rgb[0] - rgb[1]) > 0.05f || std::abs(rgb[1] - rgb[2]) > 0.05f;
      }
    }
    return double(count) / (double(picture.width) * picture.height);
  };
  EXPECT_EQ(coloured("tone"), 0);
  EXPECT_GT(coloured("log"), 0.4);
}

// The middle of the sphere is the axis from which it is seen, in the colour that calibrate prints.
TEST_F(ProbeCommand, PlotsShowTheRequestedSide) {
  ASSERT_EQ(Probe("calibrate -o axes.exr --height 128"), 0) << out_;
  const std::pair<const char*, Vector3> sides[] = {{"right", {1, 0, 0}}, {"left", {-1, 0, 0}},
                                                   {"front", {0, 1, 0}}, {"back", {0, -1, 0}},
                                                   {"up", {0, 0, 1}},    {"down", {0, 0, -1}}};
  for (const auto& [side, direction] : sides) {
    ASSERT_EQ(Probe(std::string("plot axes.exr -o p.png --what map --view sphere --color tone "
                                "--height 128 --side ") +
                    side),
              0)
        << out_;
    const Image picture = DecodeTexture("p.png", ReadFile(File("p.png")), Encoding::kSrgb);
    for (const CalibrationAxis& axis : kCalibrationAxes) {
      if (Dot(axis.direction, direction) < 0.5) continue;
      const float* const middle = picture.Pixel(picture.width / 2, picture.height / 2);
      for (int c = 0; c < 3; ++c) EXPECT_NEAR(middle[c], axis.radiance[c], 0.02) << side;
    }
  }
}

// A picture as it is shown, in bytes.
struct Plot {
  Image image;
  bool Has(int x, int y, const std::array<int, 3>& rgb, int off = 2) const {
    const float* const pixel = image.Pixel(x, y);
    return std::abs(255 * pixel[0] - float(rgb[0])) <= float(off) &&
           std::abs(255 * pixel[1] - float(rgb[1])) <= float(off) &&
           std::abs(255 * pixel[2] - float(rgb[2])) <= float(off);
  }
  int Count(const std::array<int, 3>& rgb, int off = 2) const {
    int count = 0;
    for (int y = 0; y < image.height; ++y) {
      for (int x = 0; x < image.width; ++x) count += Has(x, y, rgb, off);
    }
    return count;
  }
};

// The sun is the brightest, and what is brightest has the end of the ramp. On a sphere that is seen
// from a side it lies where its direction is, and what is not the sphere is white.
TEST_F(ProbeCommand, PlotsShowTheMapWhereItIs) {
  constexpr std::array<int, 3> kBrightest = {255, 255, 217}, kWhite = {255, 255, 255};
  const auto plot = [&](const std::string& view) {
    EXPECT_EQ(Probe("plot sun.exr --height 64 -o p.png --what map --view " + view), 0) << out_;
    return Plot{DecodeTexture("p.png", ReadFile(File("p.png")), Encoding::kLinear)};
  };
  const Plot flat = plot("latlong");
  ASSERT_EQ(flat.image.width, 128);
  ASSERT_EQ(flat.image.height, 64);
  // Two texels of 64 x 32 along each side, of two pixels each.
  EXPECT_EQ(flat.Count(kBrightest), 16);
  for (int y = 16; y < 20; ++y) {
    for (int x = 42; x < 46; ++x) EXPECT_TRUE(flat.Has(x, y, kBrightest)) << x << ' ' << y;
  }
  EXPECT_EQ(flat.Count(kWhite), 0);

  // The middle of these texels; that of the map is forward, and its right half to the right.
  const double turn = 2 * std::numbers::pi * (22 / 64.0 - 0.5), down = std::numbers::pi * 9 / 32;
  const double right = std::sin(down) * std::sin(turn), forward = std::sin(down) * std::cos(turn);
  const double up = std::cos(down);
  const struct {
    const char* side;
    double x, y, depth;  // the sun, to the right, upwards, and towards the eye
  } views[] = {{"up", -right, -forward, up},  {"left", -forward, up, -right},
               {"right", forward, up, right}, {"front", -right, up, forward},
               {"back", right, up, -forward}, {"down", -right, forward, -up}};
  for (const auto& view : views) {
    SCOPED_TRACE(view.side);
    const Plot sphere = plot(std::string("sphere --side ") + view.side);
    ASSERT_EQ(sphere.image.width, 64);
    EXPECT_TRUE(sphere.Has(0, 0, kWhite) && sphere.Has(63, 63, kWhite));
    EXPECT_FALSE(sphere.Has(32, 32, kWhite));
    const int x = int(32 + 30 * view.x), y = int(32 - 30 * view.y);
    if (view.depth > 0.1) {
      EXPECT_TRUE(sphere.Has(x, y, kBrightest, 8)) << x << ' ' << y;
    } else if (view.depth < -0.1) {
      EXPECT_EQ(sphere.Count(kBrightest), 0);
    }
  }
}

// Lights are bright dots where their directions are, cells have pale borders, and strata a green
// one beyond which the map is dimmed.
TEST_F(ProbeCommand, PlotsShowLightsCellsAndStrata) {
  constexpr std::array<int, 3> kDot = {89, 255, 242}, kBorder = {51, 255, 77};
  const auto plot = [&](const std::string& what) {
    const std::string lights = what == "lights" || what == "cells" ? "-n 9 " : "";
    EXPECT_EQ(Probe("plot sun.exr " + lights + "--height 256 -o p.png --what " + what), 0) << out_;
    return Plot{DecodeTexture("p.png", ReadFile(File("p.png")), Encoding::kLinear)};
  };
  ASSERT_EQ(Probe("lights sun.exr -n 9 --format json -o l.json"), 0) << out_;
  const auto lights = nlohmann::json::parse(ReadFile(File("l.json")))["lights"];
  ASSERT_EQ(lights.size(), 9u);
  const Plot map = plot("map"), dots = plot("lights"), cells = plot("cells"),
             strata = plot("strata");
  for (const auto& light : lights) {
    const double right = light["direction"][0], forward = light["direction"][1],
                 up = light["direction"][2];
    // The middle of the picture is forward, its right half to the right.
    const double u = 0.5 + std::atan2(right, forward) / (2 * std::numbers::pi);
    const double v = std::acos(std::clamp(up, -1.0, 1.0)) / std::numbers::pi;
    const int x = std::min(int(512 * u), 511), y = std::min(int(256 * v), 255);
    EXPECT_TRUE(dots.Has(x, y, kDot)) << x << ' ' << y;
    EXPECT_TRUE(cells.Has(x, y, kDot)) << x << ' ' << y;
  }
  EXPECT_EQ(map.Count(kDot), 0);
  EXPECT_EQ(strata.Count(kDot), 0);
  // Borders of cells are all that the two pictures differ by; they are brighter than the map.
  int borders = 0, dimmed = 0, others = 0;
  for (int y = 0; y < 256; ++y) {
    for (int x = 0; x < 512; ++x) {
      const auto sum = [&](const Plot& of) {
        const float* const rgb = of.image.Pixel(x, y);
        return rgb[0] + rgb[1] + rgb[2];
      };
      borders += sum(cells) > sum(dots) + 0.1f;
      others += sum(cells) < sum(dots) - 0.1f;
      dimmed += std::abs(sum(strata) - 0.45f * sum(map)) < 0.03f;
    }
  }
  EXPECT_GT(borders, 256);
  EXPECT_LT(borders, 512 * 256 / 8);
  EXPECT_EQ(others, 0);
  EXPECT_GT(strata.Count(kBorder, 30), 20);
  EXPECT_GT(dimmed, 512 * 256 / 4);
  EXPECT_LT(dimmed, 512 * 256);
}

TEST_F(ProbeCommand, PlotsDrawTheCurvesOfSampling) {
  ASSERT_EQ(Probe("plot sun.exr --what thresholds -o curves.svg"), 0) << out_;
  const std::string curves = ReadFile(File("curves.svg"));
  for (const char* part : {">f(x)<", ">g(x)<", ">zeta(x)<", ">A ends, p = "}) {
    EXPECT_NE(curves.find(part), std::string::npos) << part;
  }
  ASSERT_EQ(Probe("plot sun.exr --what densities --column 0.25 -o pdf.svg"), 0) << out_;
  const std::string densities = ReadFile(File("pdf.svg"));
  for (const char* part : {">p(u)<", ">P(u)<", ">p(v | u = 0.25", ">P(v | u = 0.25"}) {
    EXPECT_NE(densities.find(part), std::string::npos) << part;
  }
  ASSERT_EQ(Probe("plot sun.exr --what density --height 64 -o density.png"), 0) << out_;
  ASSERT_EQ(Probe("plot sun.exr --height 64 -o map.png"), 0) << out_;
  EXPECT_NE(ReadFile(File("density.png")), ReadFile(File("map.png")));
  EXPECT_EQ(Probe("plot sun.exr --what thresholds -o curves.png"), kExitUsage);
  EXPECT_NE(out_.find("makes curves: name a file that ends in .svg"), std::string::npos) << out_;
  EXPECT_EQ(Probe("plot sun.exr --what map -o map.svg"), kExitUsage);
  EXPECT_EQ(Probe("plot sun.exr --what thresholds --column 0.25 -o curves.svg"), kExitUsage);
  EXPECT_NE(out_.find("--column: has nothing to say of --what thresholds"), std::string::npos)
      << out_;
}

TEST_F(ProbeCommand, PlotsDrawSamplesOfRendersAndMergedLights) {
  ASSERT_EQ(Probe("plot sun.exr --height 64 -o map.png"), 0) << out_;
  ASSERT_EQ(Probe("plot sun.exr --what samples --scene spheres --spp 1 --height 64 -o s.png"), 0)
      << out_;
  EXPECT_NE(out_.find(" light samples"), std::string::npos) << out_;
  EXPECT_NE(ReadFile(File("s.png")), ReadFile(File("map.png")));
  ASSERT_EQ(Probe("plot sun.exr --what merging --method penrose -n 60 --cluster F1 --clusters 40 "
                  "--height 64 -o m.png"),
            0)
      << out_;
  EXPECT_NE(out_.find(" are merged into "), std::string::npos) << out_;
  ASSERT_EQ(Probe("plot sun.exr --what plane -n 60 --height 64 -o p.png"), 0) << out_;
  EXPECT_NE(ReadFile(File("p.png")), ReadFile(File("m.png")));
  EXPECT_EQ(Probe("plot sun.exr --what merging -o m.png"), kExitUsage);
  EXPECT_NE(out_.find("merges no lights"), std::string::npos) << out_;
  EXPECT_EQ(Probe("plot sun.exr --what plane --lloyd 2 -o m.png"), kExitUsage);
  EXPECT_NE(out_.find("--lloyd: has nothing to say of --what plane"), std::string::npos) << out_;
  EXPECT_EQ(Probe("plot sun.exr -n 5 -o m.png"), kExitUsage);
  EXPECT_EQ(Probe("plot sun.exr --what samples -o m.png"), kExitUsage);
  EXPECT_NE(out_.find("--scene"), std::string::npos) << out_;
  EXPECT_EQ(Probe("plot sun.exr --what cells --scene spheres -o m.png"), kExitUsage);
  EXPECT_NE(out_.find("--scene: has nothing to say of --what cells"), std::string::npos) << out_;
}

}  // namespace
}  // namespace skywave
