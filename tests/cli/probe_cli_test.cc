// Tests every subcommand of `skywave probe` on a small map, and its messages for bad input.
#include <gtest/gtest.h>
#include <sys/wait.h>

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <cstdlib>
#include <filesystem>
#include <nlohmann/json.hpp>
#include <numbers>
#include <sstream>
#include <string>
#include <utility>
#include <vector>

#include "base/error.h"
#include "base/files.h"
#include "lights/maps/resample.h"
#include "tests/support/light_test_maps.h"
#include "tests/support/paths.h"
#include "tests/support/probe_command.h"

namespace skywave {
namespace {

TEST_F(ProbeCommand, InfoDescribesTheMap) {
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

TEST_F(ProbeCommand, ConvertingThereAndBackKeepsTheIntegral) {
  const auto before = SphereIntegral(test::SunMap(64, 32, 1000), Projection::kLatLong);
  for (const char* name : {"angular", "mirror-ball", "horizontal-cross", "vertical-cross",
                           "cube-strip", "cube-column", "octahedral"}) {
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

TEST_F(ProbeCommand, AFileWhoseLayerIsReadIsNotWritten) {
  const std::string before = ReadFile(File("sun.exr"));
  EXPECT_EQ(Probe("convert sun.exr:R sun.exr --to latlong"), kExitUsage);
  EXPECT_NE(out_.find("is an input of this command"), std::string::npos) << out_;
  EXPECT_EQ(ReadFile(File("sun.exr")), before);
}

TEST_F(ProbeCommand, PresamplePlotAndCalibrateWrite) {
  ASSERT_EQ(Probe("presample sun.exr -n 30 -o set.json --cells cells.png"), 0) << out_;
  const auto json = nlohmann::json::parse(ReadFile(File("set.json")));
  double probability = 0;
  for (const auto& sample : json["samples"]) probability += double(sample["probability"]);
  EXPECT_NEAR(probability, 1, 1e-9);
  for (const char* what : {"map", "lights -n 9", "cells -n 9", "strata"}) {
    for (const char* view : {"latlong", "sphere --side up", "sphere --side left"}) {
      ASSERT_EQ(Probe(std::string("plot sun.exr --height 64 -o p.png --what ") + what + " --view " +
                      view),
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

// A renderer that reads the cells of the pre-processor makes the picture of one that makes them
// itself, to the bit where the light of texels is exact: at powers of two.
TEST_F(ProbeCommand, PresampledCellsGiveThePictureOfThoseThatTheStrategyMakes) {
  Image map = test::SunMap(64, 32, 1024);
  for (float& value : map.rgb) value = std::exp2(std::floor(std::log2(value)));
  WriteExr(File("exact.exr"), map);
  const auto render = [&](const std::string& strategy) {
    const int status = std::system(("cd '" + folder_.string() + "' && " + ProgramPath() +
                                    " render spheres --env exact.exr --size 24x18 --spp 2 "
                                    "--integrator direct --light-samples 4 "
                                    "--no-mis -o out.exr --strategy " +
                                    strategy + " > out.txt 2>&1")
                                       .c_str());
    EXPECT_EQ(WEXITSTATUS(status), 0) << ReadFile(File("out.txt"));
    return ReadImage(File("out.exr")).rgb;
  };
  ASSERT_EQ(Probe("presample exact.exr -n 30 -o set.json"), 0) << out_;
  const std::string own = "lights=30,position=sample";
  EXPECT_EQ(render("presampled:mode=fixed,file=set.json"), render("presampled:mode=fixed," + own));
  EXPECT_EQ(render("presampled:file=set.json"), render("presampled:" + own));
  ASSERT_EQ(Probe("presample exact.exr -n 9 --strata variation -o bright.json"), 0) << out_;
  EXPECT_EQ(render("hybrid:file=bright.json"), render("hybrid:lights=9,position=sample"));
  EXPECT_NE(render("hybrid:file=bright.json"), render("hybrid:file=set.json"));
  const auto refusal = [&](const std::string& strategy, int code) {
    const int status = std::system(("cd '" + folder_.string() + "' && " + ProgramPath() +
                                    " render spheres --env exact.exr --spp 1 --size 8x6 -o out.exr "
                                    "--strategy " +
                                    strategy + " > out.txt 2>&1")
                                       .c_str());
    EXPECT_EQ(WEXITSTATUS(status), code) << strategy;
    return ReadFile(File("out.txt"));
  };
  // Outside of the bright part no texel has a cell, and its light would be lost.
  for (const char* mode : {"fixed", "jittered"}) {
    EXPECT_NE(refusal(std::string("presampled:file=bright.json,mode=") + mode, kExitBadInput)
                  .find("bright.json: texel 0, 0 of the map has light and no cell"),
              std::string::npos);
  }
  // What the file has chosen is not chosen again.
  for (const char* strategy :
       {"presampled:file=set.json,lights=9", "presampled:file=set.json,from=median-cut",
        "hybrid:file=bright.json,strata=p"}) {
    EXPECT_NE(refusal(strategy, kExitUsage)
                  .find("and file= both choose the lights: leave one of them out"),
              std::string::npos);
  }
}

TEST_F(ProbeCommand, PresampleFollowsTheSetOfTheMapBefore) {
  const auto set_of = [&](const char* name) { return nlohmann::json::parse(ReadFile(File(name))); };
  ASSERT_EQ(Probe("presample sun.exr --method k-means -n 12 -o set.json"), 0) << out_;
  ASSERT_EQ(Probe("presample sun.exr --follow set.json -o next.json"), 0) << out_;
  const auto set = set_of("set.json"), next = set_of("next.json");
  EXPECT_EQ(next["method"], "k-means");
  ASSERT_EQ(next["samples"].size(), set["samples"].size());
  for (std::size_t i = 0; i < set["samples"].size(); ++i) {
    for (std::size_t axis = 0; axis < 3; ++axis) {
      EXPECT_NEAR(double(next["samples"][i]["direction"][axis]),
                  double(set["samples"][i]["direction"][axis]), 0.01);
    }
  }
  const std::string before = ReadFile(File("set.json"));
  for (const char* both :
       {"--follow set.json -n 9 -o out.json", "--follow set.json --method penrose -o out.json",
        "--follow set.json -o set.json"}) {
    EXPECT_EQ(Probe(std::string("presample sun.exr ") + both), kExitUsage) << both;
  }
  EXPECT_EQ(Probe("presample sun.exr --follow none.json -o out.json"), kExitIo) << out_;
  EXPECT_NE(out_.find("none.json"), std::string::npos) << out_;
  EXPECT_EQ(ReadFile(File("set.json")), before);
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

// The faces of a cube are squares of one size, and the file of the one that is not is named.
TEST_F(ProbeCommand, FacesOfUnequalSizesAreRefused) {
  const char* const names[] = {"right", "left", "up", "down", "front", "back"};
  for (const char* const odd : names) {
    for (const auto& [width, height] : {std::pair(5, 5), {4, 5}, {5, 4}}) {
      SCOPED_TRACE(testing::Message() << odd << ' ' << width << " x " << height);
      for (const char* const name : names) {
        const bool is_odd = std::string(name) == odd;
        WriteExr(File(std::string("cube-") + name + ".exr"),
                 is_odd ? Image(width, height) : Image(4, 4));
      }
      EXPECT_EQ(Probe("convert cube.exr back.exr --from-faces --to latlong"), kExitBadInput);
      // The first face is what the others are compared with, unless it is no square itself.
      const bool first = std::string(odd) == "right" && width == height;
      EXPECT_NE(out_.find(std::string("cube-") + (first ? "left" : odd) + ".exr"),
                std::string::npos)
          << out_;
      EXPECT_NE(out_.find("squares of one size"), std::string::npos) << out_;
      EXPECT_FALSE(std::filesystem::exists(File("back.exr")));
    }
  }
}

TEST_F(ProbeCommand, ASizeIsTheSideOfASquareOrAFace) {
  const struct {
    const char* to;
    int width, height;
  } cases[] = {{"latlong", 40, 20},     {"angular", 20, 20},          {"mirror-ball", 20, 20},
               {"octahedral", 20, 20},  {"horizontal-cross", 80, 60}, {"vertical-cross", 60, 80},
               {"cube-strip", 120, 20}, {"cube-column", 20, 120}};
  for (const auto& map : cases) {
    ASSERT_EQ(Probe(std::string("convert sun.exr o.exr --size 20 --to ") + map.to), 0) << out_;
    const Image image = ReadImage(File("o.exr"));
    EXPECT_EQ(image.width, map.width) << map.to;
    EXPECT_EQ(image.height, map.height) << map.to;
  }
}

}  // namespace
}  // namespace skywave
