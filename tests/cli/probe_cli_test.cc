// Tests every subcommand of `skywave probe` on a small map, and its messages for bad input.
#include <gtest/gtest.h>
#include <sys/wait.h>
#include <unistd.h>

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <cstdlib>
#include <filesystem>
#include <nlohmann/json.hpp>
#include <numbers>
#include <sstream>
#include <string>
#include <vector>

#include "base/error.h"
#include "base/files.h"
#include "lights/maps/resample.h"
#include "lights/probe/calibration.h"
#include "tests/support/light_test_maps.h"
#include "tests/support/paths.h"

namespace skywave {
namespace {

class ProbeCommand : public testing::Test {
 protected:
  void SetUp() override {
    folder_ = std::filesystem::temp_directory_path() /
              ("skywave_probe_" + std::to_string(getpid()) + "_" +
               testing::UnitTest::GetInstance()->current_test_info()->name());
    std::filesystem::create_directories(folder_);
    WriteExr(File("sun.exr"), test::SunMap(64, 32, 1000));
  }
  void TearDown() override { std::filesystem::remove_all(folder_); }
  std::string File(const std::string& name) const { return (folder_ / name).string(); }
  // Returns the exit code; both streams are written to out_.
  int Probe(const std::string& arguments) {
    const int status = std::system(("cd '" + folder_.string() + "' && " + ProgramPath() +
                                    " probe " + arguments + " > out.txt 2>&1")
                                       .c_str());
    out_ = ReadFile(File("out.txt"));
    return WEXITSTATUS(status);
  }

  std::filesystem::path folder_;
  std::string out_;
};

TEST_F(ProbeCommand, InfoTellsTheMap) {
  ASSERT_EQ(Probe("info sun.exr --json info.json"), 0) << out_;
  const auto json = nlohmann::json::parse(ReadFile(File("info.json")));
  EXPECT_EQ(json["projection"], "latlong");
  EXPECT_EQ(json["spots"][0]["x"], 21);
  EXPECT_GT(json["table_7_1"]["p"], 0.5);
  // Both strata together are the sphere and all of its energy.
  const auto& table = json["table_7_1"];
  const double area = table["sphere_area"], energy = table["energy"];
  EXPECT_NEAR(table["area_a"].get<double>() + table["area_b"].get<double>(), area, 1e-6 * area);
  EXPECT_NEAR(table["energy_a"].get<double>() + table["energy_b"].get<double>(), energy,
              1e-6 * energy);
  const std::size_t row = out_.find("\narea A, B ");
  ASSERT_NE(row, std::string::npos) << out_;
  double pixels[2], percent[2];
  ASSERT_EQ(std::sscanf(out_.c_str() + row, "\narea A, B %lf, %lf (%lf %%, %lf %%)", &pixels[0],
                        &pixels[1], &percent[0], &percent[1]),
            4)
      << out_;
  EXPECT_NEAR(percent[0], 100 * table["area_a"].get<double>() / area, 0.001);
  EXPECT_NEAR(percent[0] + percent[1], 100, 0.002);
}

TEST_F(ProbeCommand, ConvertGoesThereAndBack) {
  const auto before = SphereIntegral(test::SunMap(64, 32, 1000), Projection::kLatLong);
  for (const char* name : {"angular", "mirror-ball", "horizontal-cross", "vertical-cross",
                           "cube-strip", "octahedral"}) {
    ASSERT_EQ(Probe(std::string("convert sun.exr there.exr --to ") + name), 0) << out_;
    ASSERT_EQ(Probe(std::string("convert there.exr back.exr --to latlong --size 64x32 "
                                "--projection ") +
                    name),
              0)
        << out_;
    const auto after = SphereIntegral(ReadImage(File("back.exr")), Projection::kLatLong);
    for (int c = 0; c < 3; ++c) EXPECT_NEAR(after[c] / before[c], 1, 1e-5) << name;
  }
  ASSERT_EQ(Probe("convert sun.exr cube.exr --to cube-faces --size 16"), 0) << out_;
  EXPECT_EQ(ReadImage(File("cube-up.exr")).width, 16);
  ASSERT_EQ(Probe("convert cube.exr back.exr --from-faces --to latlong --size 32"), 0) << out_;
  EXPECT_EQ(ReadImage(File("back.exr")).width, 64);
}

TEST_F(ProbeCommand, LightsComeInEveryFormat) {
  for (const char* format : {"table", "json", "pbrt", "povray", "blender", "maya"}) {
    for (const char* method : {"median-cut", "variance-cut", "penrose"}) {
      ASSERT_EQ(Probe(std::string("lights sun.exr -n 9 --strata 0.6 --residual rest.exr -o l.txt "
                                  "--format ") +
                      format + " --method " + method),
                0)
          << out_;
      EXPECT_GT(ReadFile(File("l.txt")).size(), 300u);
      EXPECT_NE(out_.find("map"), std::string::npos);
    }
  }
  EXPECT_EQ(ReadImage(File("rest.exr")).width, 64);
  ASSERT_EQ(Probe("lights sun.exr -n 40 --clusters 7 --cluster F1 --lloyd 2"), 0) << out_;
  EXPECT_NE(out_.find("7 lights"), std::string::npos) << out_;
}

// A bright texel on a dim sky: the energy of the only cell is there, and the middle of its area is
// the origin, from which no light comes.
TEST_F(ProbeCommand, LightsLieWhereTheirPositionSays) {
  const auto direction = [&](const std::string& position) {
    EXPECT_EQ(Probe("lights sun.exr -n 1 --method median-cut --format json -o l.json --position " +
                    position),
              0)
        << out_;
    const auto json = nlohmann::json::parse(ReadFile(File("l.json")));
    const auto d = json["lights"][0]["direction"].get<std::vector<double>>();
    return Vector3{d[0], d[1], d[2]};
  };
  ASSERT_EQ(Probe("info sun.exr --json info.json --spots 3"), 0) << out_;
  const auto spots = nlohmann::json::parse(ReadFile(File("info.json")))["spots"];
  EXPECT_EQ(spots.size(), 3u);
  const auto s = spots[0]["direction"].get<std::vector<double>>();
  const Vector3 sun = {s[0], s[1], s[2]};
  EXPECT_GT(Dot(direction("centroid"), sun), 0.99);
  EXPECT_LT(Dot(direction("center"), sun), 0.9);
}

TEST_F(ProbeCommand, LightsAreAsFarApartAsAsked) {
  const auto lights = [&](const std::string& options) {
    EXPECT_EQ(Probe("lights sun.exr -n 40 --format json -o l.json " + options), 0) << out_;
    return nlohmann::json::parse(ReadFile(File("l.json")));
  };
  const auto all = lights(""), apart = lights("--separation 50");
  EXPECT_EQ(all["lights"].size(), 40u);
  EXPECT_GT(apart["lights"].size(), 2u);
  EXPECT_LT(apart["lights"].size(), 40u);
  EXPECT_NEAR(apart["total_energy"].get<double>() / all["total_energy"].get<double>(), 1, 1e-6);
  for (const auto& a : apart["lights"]) {
    for (const auto& b : apart["lights"]) {
      if (&a == &b) continue;
      double cosine = 0;
      for (int i = 0; i < 3; ++i) {
        cosine += a["direction"][i].get<double>() * b["direction"][i].get<double>();
      }
      EXPECT_LT(cosine, std::cos(50 * std::numbers::pi / 180) + 1e-9);
    }
  }
}

// The lights of a map whose upper half alone shines come from above, along the axis that is up.
TEST_F(ProbeCommand, LightsComeFromTheAxisThatIsUp) {
  Image map(32, 16);
  std::fill_n(map.rgb.begin(), map.rgb.size() / 2, 1.0f);
  WriteExr(File("half.exr"), map);
  for (const std::size_t up : {0u, 1u, 2u}) {
    ASSERT_EQ(Probe(std::string("lights half.exr -n 1 --format pbrt -o l.pbrt --up ") + "xyz"[up]),
              0)
        << out_;
    std::istringstream text(ReadFile(File("l.pbrt")));
    std::string line;
    while (std::getline(text, line) && line.find("\"point3 from\"") == std::string::npos) continue;
    std::istringstream from(line.substr(line.find("\"point3 from\"") + 16));
    double direction[3] = {};
    from >> direction[0] >> direction[1] >> direction[2];
    EXPECT_GT(direction[up], 0.9) << line;
  }
}

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

// The middle of the sphere is the axis from which it is seen, in the colour that calibrate tells.
TEST_F(ProbeCommand, PlotsShowTheSideThatIsAskedFor) {
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

TEST_F(ProbeCommand, PresamplePlotAndCalibrateWrite) {
  ASSERT_EQ(Probe("presample sun.exr -n 30 -o set.json --cells cells.png"), 0) << out_;
  const auto json = nlohmann::json::parse(ReadFile(File("set.json")));
  double probability = 0;
  for (const auto& sample : json["samples"]) probability += double(sample["probability"]);
  EXPECT_NEAR(probability, 1, 1e-9);
  for (const char* what : {"map", "lights", "cells", "strata"}) {
    for (const char* view : {"latlong", "sphere --side up", "sphere --side left"}) {
      ASSERT_EQ(Probe(std::string("plot sun.exr -n 9 --height 64 -o p.png --what ") + what +
                      " --view " + view),
                0)
          << out_;
      EXPECT_EQ(ReadFile(File("p.png")).substr(1, 3), "PNG");
    }
  }
  ASSERT_EQ(Probe("calibrate -o c.exr --height 256"), 0) << out_;
  const Image map = ReadImage(File("c.exr"));
  EXPECT_NEAR(map.Pixel(384, 128)[0], 1, 0.01);  // the right is red
  EXPECT_NEAR(map.Pixel(384, 128)[1], 0.05, 0.01);
  EXPECT_NEAR(map.Pixel(256, 128)[1], 1, 0.01);  // forward is green
  EXPECT_NEAR(map.Pixel(10, 0)[2], 1, 0.01);     // up is blue
}

TEST_F(ProbeCommand, AMapIsNeverOverwritten) {
  const std::string before = ReadFile(File("sun.exr"));
  for (const char* name : {"right", "left", "up", "down", "front", "back"}) {
    WriteExr(File(std::string("cube-") + name + ".exr"), Image(4, 4));
  }
  const std::string face = ReadFile(File("cube-left.exr"));
  for (const char* command :
       {"convert sun.exr sun.exr --to angular", "convert sun.exr ./sun.exr --to octahedral",
        "convert cube.exr cube-left.exr --from-faces --to latlong",
        "convert cube.exr cube.exr --from-faces --to cube-faces",
        "convert cube-left.exr cube.exr --projection latlong --to cube-faces",
        "info sun.exr --json sun.exr", "presample sun.exr -n 10 -o sun.exr",
        "presample sun.exr -n 10 -o set.json --cells sun.exr", "plot sun.exr -o sun.exr",
        "lights sun.exr -n 8 -o sun.exr", "lights sun.exr -n 8 --strata 0.5 --residual sun.exr"}) {
    EXPECT_EQ(Probe(command), kExitUsage) << command << out_;
    EXPECT_NE(out_.find("is an input"), std::string::npos) << command << out_;
    EXPECT_EQ(ReadFile(File("sun.exr")), before) << command;
    EXPECT_EQ(ReadFile(File("cube-left.exr")), face) << command;
  }
}

TEST_F(ProbeCommand, BadInputIsNamed) {
  EXPECT_EQ(Probe("info missing.exr"), kExitIo);
  EXPECT_NE(out_.find("missing.exr"), std::string::npos) << out_;
  WriteExr(File("odd.exr"), Image(5, 3));
  EXPECT_EQ(Probe("info odd.exr"), kExitBadInput);
  EXPECT_EQ(Probe("info odd.exr --projection latlong"), 0) << out_;
  EXPECT_EQ(Probe("info odd.exr --projection nonsense"), kExitUsage);
  EXPECT_EQ(Probe("lights sun.exr --residual r.exr"), kExitUsage);
  EXPECT_NE(out_.find("--strata"), std::string::npos) << out_;
  EXPECT_EQ(Probe("lights sun.exr -n 0"), kExitUsage);
  EXPECT_EQ(Probe("lights sun.exr --strata 2"), kExitUsage);
  EXPECT_EQ(Probe("convert sun.exr x.exr --to latlong --size 3y4"), kExitUsage);
  EXPECT_EQ(Probe("convert sun.exr x.exr --to horizontal-cross --size 10x10"), kExitBadInput);
  EXPECT_EQ(Probe("plot sun.exr -o p.png --height 3"), kExitUsage);
  EXPECT_EQ(Probe(""), kExitUsage);
}

}  // namespace
}  // namespace skywave
