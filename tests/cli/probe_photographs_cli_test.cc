// Tests the subcommands of `skywave probe` that make maps of photographs, and their messages.
#include <gtest/gtest.h>

#include <algorithm>
#include <cstdio>
#include <filesystem>
#include <string>

#include "base/error.h"
#include "tests/support/paths.h"
#include "tests/support/probe_command.h"

namespace skywave {
namespace {

// Writes what a picture of light x + 10 y shows in an exposure, clipped at 40.
void WriteExposure(const std::string& path, float exposure) {
  Image image(12, 8);
  for (int y = 0; y < 8; ++y) {
    for (int x = 0; x < 12; ++x) {
      std::fill_n(image.Pixel(x, y), 3, std::min(40.0f, exposure * float(1 + x + 10 * y)));
    }
  }
  WriteImage(path, image);
}

TEST_F(ProbeCommand, ExposuresBecomeLightOfWhichAPartIsWritten) {
  WriteExposure(File("long.pfm"), 1), WriteExposure(File("short.pfm"), 0.25f);
  ASSERT_EQ(Probe("assemble long.pfm short.pfm --times 1/5,1/20 --no-align -o light.exr"), 0)
      << out_;
  ASSERT_EQ(Probe("assemble long.pfm short.pfm --times 0.2,0.05 --no-align --crop 4x3+6+5 -o "
                  "part.exr"),
            0)
      << out_;
  const Image light = ReadImage(File("light.exr")), part = ReadImage(File("part.exr"));
  ASSERT_EQ(part.width, 4);
  ASSERT_EQ(part.height, 3);
  for (int y = 0; y < 3; ++y) {
    for (int x = 0; x < 4; ++x) {
      const float truth = 5 * float(1 + (6 + x) + 10 * (5 + y));
      EXPECT_NEAR(light.Pixel(6 + x, 5 + y)[1], truth, 1e-3f * truth);
      EXPECT_EQ(part.Pixel(x, y)[1], light.Pixel(6 + x, 5 + y)[1]);
    }
  }
}

TEST_F(ProbeCommand, BadPhotographsAreNamed) {
  WriteExposure(File("a.pfm"), 1), WriteExposure(File("b.pfm"), 0.25f);
  const struct {
    const char* arguments;
    const char* message;
  } cases[] = {
      {"assemble a.pfm b.pfm -o c.exr", "a.pfm: has no exposure time"},
      {"assemble a.pfm b.pfm --times 1 -o c.exr", "1 times for 2 photographs"},
      {"assemble a.pfm b.pfm --times 1,fast -o c.exr", "fast"},
      {"assemble a.pfm b.pfm --times 1,2 --crop 12x8+1+0 -o c.exr", "is not within 12 x 8"},
      {"assemble a.pfm b.pfm --times 1,2 --response best -o c.exr", "debevec|robertson"},
      {"join a.pfm b.pfm -o c.exr", "a.pfm: is 12x8: crop"},
      {"join a.pfm --camera 200 -o c.exr", "--camera"},
  };
  for (const auto& bad : cases) {
    EXPECT_NE(Probe(bad.arguments), 0) << bad.arguments;
    EXPECT_NE(out_.find(bad.message), std::string::npos) << bad.arguments << "\n" << out_;
    EXPECT_FALSE(std::filesystem::exists(File("c.exr"))) << bad.arguments;
  }
}

TEST_F(ProbeCommand, JoiningAViewWithItselfKeepsItAndItsCamera) {
  ASSERT_EQ(Probe("convert sun.exr ball.exr --to mirror-ball --size 64"), 0) << out_;
  ASSERT_EQ(Probe("join ball.exr ball.exr --height 32 -o joined.exr"), 0) << out_;
  double angle, tilt, gain, correlation;
  const std::size_t line = out_.find("ball.exr  ");
  ASSERT_NE(line, std::string::npos) << out_;
  ASSERT_EQ(std::sscanf(out_.c_str() + line,
                        "ball.exr %lf degrees to the right of the first, tilted by %lf, times %lf "
                        "1 1, correlation %lf",
                        &angle, &tilt, &gain, &correlation),
            4)
      << out_;
  EXPECT_NEAR(angle, 0, 0.2);
  EXPECT_NEAR(tilt, 0, 0.2);
  EXPECT_EQ(gain, 1);
  EXPECT_GT(correlation, 0.99);
  EXPECT_NE(out_.find("of the map are seen beside the cameras alone"), std::string::npos) << out_;
  ASSERT_EQ(Probe("convert ball.exr one.exr --projection mirror-ball --to latlong --size 64x32"),
            0);
  const Image joined = ReadImage(File("joined.exr")), one = ReadImage(File("one.exr"));
  // The sky of that map is 1 but for its sun and the ground.
  EXPECT_NEAR(joined.Pixel(0, 10)[0], one.Pixel(0, 10)[0], 0.02);
}

}  // namespace
}  // namespace skywave
