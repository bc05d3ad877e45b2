// Tests the program from the outside: help, exit codes, messages and files.
#include <gtest/gtest.h>

#include <cmath>
#include <limits>
#include <nlohmann/json.hpp>
#include <string>
#include <vector>

#include "base/error.h"
#include "image/image.h"
#include "tests/support/program.h"
#include "wavefront/rays/trace.h"

namespace skywave {
namespace {

bool Contains(const std::string& text, const std::string& part) {
  return text.find(part) != std::string::npos;
}

constexpr char kTriangle[] =
    "WorldBegin\nShape \"trianglemesh\" \"integer indices\" [0 1 2]\n"
    "  \"point P\" [-1 -1 3 1 -1 3 0 1 3]\nWorldEnd\n";
constexpr char kLight[] = "LightSource \"infinite\" \"rgb L\" [1 1 1]\n";

std::string Ply(const std::string& vertices, const std::string& face) {
  return "ply\nformat ascii 1.0\nelement vertex 3\nproperty float x\nproperty float y\n"
         "property float z\nelement face 1\nproperty list uchar int vertex_indices\nend_header\n" +
         vertices + face + "\n";
}
constexpr char kVertices[] = "0 0 0\n1 0 0\n0 1 0\n";

Image Map(float value) {
  Image map(8, 4);
  for (std::size_t i = 0; i < map.rgb.size(); ++i) map.rgb[i] = value * float(1 + i % 5);
  return map;
}

class Cli : public Program {
 protected:
  void SetUp() override {
    Program::SetUp();
    Put("dark.pbrt", kTriangle);
    Put("scene.pbrt", std::string("WorldBegin\n") + kLight + (kTriangle + 11));
    Put("unknown.pbrt", std::string("# a comment\n\nFrobnicate 3\n") + kTriangle);
    Put("empty.pbrt", "WorldBegin\nLightSource \"point\"\nWorldEnd\n");
    Put("range.pbrt", std::string("WorldBegin\n") + kLight +
                          "\nShape \"trianglemesh\" \"integer indices\" [0 1 3]\n"
                          "  \"point P\" [-1 -1 3 1 -1 3 0 1 3]\nWorldEnd\n");
    Put("point.pbrt", std::string("WorldBegin\n") + kLight +
                          "Shape \"trianglemesh\" \"integer indices\" [0 1 2]\n"
                          "  \"point P\" [1 1 1 1 1 1 1 1 1]\nWorldEnd\n");
    Put("film.pbrt",
        std::string("Film \"image\" \"integer xresolution\" 0\n") + Bytes("scene.pbrt"));
    Put("good.ply", Ply(kVertices, "3 0 1 2"));
    Put("range.ply", Ply(kVertices, "3 0 1 3"));
    Put("nan.ply", Ply("0 0 0\n1 nan 0\n0 1 0\n", "3 0 1 2"));
    Put("far.ply", Ply("0 0 0\n1 3e38 0\n0 1 0\n", "3 0 1 2"));
    Put("scene.blend", "BLENDER");
    const std::string corners = "v 0 0 0\nv 1 0 0\nv 0 1 0\n";
    Put("good.obj", corners + "f 1 2 3\n");
    Put("empty.obj", corners);
    Put("range.obj", corners + "f 1 2 4\n");
    Put("nan.obj", corners + "v 1 nan 1\nf 1 2 3\n");
    Put("library.obj", "mtllib nosuch.mtl\n" + corners + "f 1 2 3\n");
    WriteExr(Path("map.exr"), Map(1));
    Put("cut.exr", Bytes("map.exr").substr(0, Bytes("map.exr").size() - 40));
    Put("text.exr", "not a picture");
    Image odd(7, 4);
    WriteExr(Path("odd.exr"), odd);
    Image bad = Map(1);
    bad.rgb[0] = std::numeric_limits<float>::quiet_NaN();
    bad.rgb[7] = -2;
    bad.rgb[30] = std::numeric_limits<float>::infinity();
    bad.rgb[33] = -1;
    WritePfm(Path("bad.pfm"), bad);
    std::filesystem::create_directory(Path("folder"));
  }
};

TEST_F(Cli, HelpOfTheProgramNamesTheCommandsAndAFirstOne) {
  const Result result = Run("--help");
  EXPECT_EQ(result.exit_code, 0);
  for (const char* const part :
       {"render", "info", "compare", "strategies", "converge", "bench", "-o gallery.exr"}) {
    EXPECT_TRUE(Contains(result.out, part)) << part;
  }
  EXPECT_EQ(result.err, "");
  const std::string version = Run("--version").out;
  EXPECT_TRUE(version.starts_with("skywave 0.") && Contains(version, "(revision ") &&
              Contains(version, ", Embree " RTC_VERSION_STRING ")\n"))
      << version;
}

TEST_F(Cli, HelpOfEveryCommandHasAnExample) {
  for (const std::string command :
       {"render", "info", "compare", "strategies", "converge", "bench"}) {
    const Result result = Run(command + " --help");
    EXPECT_EQ(result.exit_code, 0) << command;
    EXPECT_TRUE(Contains(result.out, "Example")) << command;
    EXPECT_TRUE(Contains(result.out, "  skywave ")) << command;
  }
  const std::string help = Run("render --help").out;
  for (const char* const flag :
       {"--env", "--strategy", "--size", "--spp", "--integrator", "--max-depth", "--filter",
        "--seed", "--threads", "--wave", "--backend", "--output", "--stats"}) {
    EXPECT_TRUE(Contains(help, flag)) << flag;
  }
}

TEST_F(Cli, StrategiesAreListedWithTheirParameters) {
  const Result result = Run("strategies");
  EXPECT_EQ(result.exit_code, 0);
  for (const char* const part : {"importance", "compensate=1/n", "uniform", "cosine"}) {
    EXPECT_TRUE(Contains(result.out, part)) << part;
  }
}

struct BadCase {
  std::string arguments;
  int exit_code;
  std::vector<std::string> message;  // expected parts of the message
};

TEST_F(Cli, BadInputIsReportedAndLeavesNoFile) {
  const std::string small = " --size 4x3 --spp 1";
  const BadCase cases[] = {
      // Scenes
      {"render nosuch.pbrt", kExitBadInput, {"nosuch.pbrt", "no such file", "gallery"}},
      {"render galery", kExitBadInput, {"galery", "gallery, spheres"}},
      {"render scene.blend", kExitBadInput, {"scene.blend", ".pbrt, .obj, .gltf, .glb or .ply"}},
      {"render good.obj", kExitBadInput, {"good.obj", "no light", "--env"}},
      {"render empty.obj --env map.exr", kExitBadInput, {"empty.obj", "no triangle"}},
      {"render range.obj --env map.exr", kExitBadInput, {"range.obj:4: ", "indices beyond"}},
      {"render nan.obj --env map.exr --strict", kExitBadInput, {"nan.obj:4: ", "not finite"}},
      {"render library.obj --env map.exr --strict",
       kExitBadInput,
       {"library.obj:1: ", "nosuch.mtl"}},
      {"render folder", kExitBadInput, {"folder"}},
      {"render unknown.pbrt", kExitBadInput, {"unknown.pbrt:3: ", "Frobnicate"}},
      {"render empty.pbrt", kExitBadInput, {"empty.pbrt", "no triangle"}},
      {"render dark.pbrt", kExitBadInput, {"dark.pbrt", "no light", "--env"}},
      {"render good.ply", kExitBadInput, {"good.ply", "no light", "--env"}},
      {"render range.pbrt", kExitBadInput, {"range.pbrt:4: ", "3"}},
      {"render range.ply --env map.exr", kExitBadInput, {"range.ply", "3"}},
      {"render nan.ply --env map.exr", kExitBadInput, {"nan.ply"}},
      {"render far.ply --env map.exr", kExitBadInput, {"far.ply", "vertex 1"}},
      {"render film.pbrt", kExitBadInput, {"film.pbrt:1: ", "resolution"}},
      // Maps
      {"render scene.pbrt --env nosuch.exr", kExitIo, {"nosuch.exr", "No such file"}},
      {"render scene.pbrt --env folder", kExitIo, {"folder"}},
      {"render scene.pbrt --env cut.exr", kExitBadInput, {"cut.exr", "byte"}},
      {"render scene.pbrt --env text.exr", kExitBadInput, {"text.exr"}},
      {"render scene.pbrt --env odd.exr", kExitBadInput, {"odd.exr", "7 x 4", "--env-projection"}},
      // Outputs
      {"render scene.pbrt -o missing/a.exr", kExitIo, {"missing/a.exr", "no folder missing"}},
      {"render scene.pbrt -o folder", kExitUsage, {"folder", ".exr"}},
      {"render scene.pbrt -o a.png", kExitUsage, {"a.png", ".exr"}},
      {"render scene.pbrt -o scene.pbrt/a.exr", kExitIo, {"scene.pbrt/a.exr"}},
      {"render scene.pbrt -o a.exr --stats missing/s.json", kExitIo, {"missing/s.json"}},
      {"compare map.exr odd.exr", kExitBadInput, {"8 x 4", "7 x 4"}},
      {"compare map.exr nosuch.exr", kExitIo, {"nosuch.exr"}},
      {"compare map.exr cut.exr --map e.png --json e.json", kExitBadInput, {"cut.exr"}},
      {"compare map.exr map.exr --json missing/e.json", kExitIo, {"missing/e.json"}},
      // Flags
      {"", kExitUsage, {"--help"}},
      {"rendr", kExitUsage, {"--help"}},
      {"render", kExitUsage, {"scene is required"}},
      {"compare map.exr", kExitUsage, {"reference is required"}},
      {"render scene.pbrt --frob", kExitUsage, {"--frob"}},
      {"render scene.pbrt surplus", kExitUsage, {"surplus"}},
      {"render scene.pbrt --size 0x0", kExitUsage, {"--size", "0x0"}},
      {"render scene.pbrt --size -4x3", kExitUsage, {"--size"}},
      {"render scene.pbrt --size 10", kExitUsage, {"--size", "WxH"}},
      {"render scene.pbrt --size 4x3x2", kExitUsage, {"--size", "4x3x2"}},
      {"render scene.pbrt --size 99999999999x1", kExitUsage, {"--size"}},
      {"render scene.pbrt --size 30000x30000", kExitBadInput, {"30000 x 30000"}},
      {"render scene.pbrt --spp 0", kExitUsage, {"--spp"}},
      {"render scene.pbrt --spp many", kExitUsage, {"--spp", "many"}},
      {"render scene.pbrt --max-depth -1", kExitUsage, {"--max-depth"}},
      {"render scene.pbrt --light-samples 0", kExitUsage, {"--light-samples"}},
      {"render scene.pbrt --wave 0", kExitUsage, {"--wave"}},
      {"render scene.pbrt --threads -1", kExitUsage, {"--threads"}},
      {"render scene.pbrt --seed 99999999999", kExitUsage, {"--seed"}},
      {"render scene.pbrt --integrator nosuch",
       kExitUsage,
       {"--integrator", "nosuch", "direct|path"}},
      {"render scene.pbrt --filter cubic", kExitUsage, {"--filter", "cubic", "gaussian"}},
      {"render scene.pbrt --filter-radius nan", kExitUsage, {"--filter-radius", "nan"}},
      {"render scene.pbrt --filter-radius -1", kExitUsage, {"--filter-radius"}},
      {"render scene.pbrt --backend gpu", kExitUsage, {"--backend", "gpu", "packet|"}},
      {"render scene.pbrt --env-up w", kExitUsage, {"--env-up", "x|y|z"}},
      {"render scene.pbrt --env-rotate inf", kExitUsage, {"--env-rotate", "inf"}},
      {"render scene.pbrt --env-intensity nan", kExitUsage, {"--env-intensity", "nan"}},
      {"render scene.pbrt --env-projection flat", kExitUsage, {"--env-projection", "latlong"}},
      {"render scene.pbrt --camera pinhole", kExitUsage, {"--camera", "pinhole", "orthographic"}},
      {"render scene.pbrt --eye 1,2", kExitUsage, {"--eye", "1,2", "X,Y,Z"}},
      {"render scene.pbrt --eye 1,2,nan", kExitUsage, {"--eye", "X,Y,Z"}},
      {"render scene.pbrt --eye 1,2,3 --target 1,2,3", kExitUsage, {"--target", "look"}},
      {"render scene.pbrt --fov 180", kExitUsage, {"--fov", "180", "perspective", "fisheye"}},
      {"render scene.pbrt --camera fisheye --fov 361", kExitUsage, {"--fov", "361"}},
      {"render scene.pbrt --aovs albedo,colour", kExitUsage, {"colour", "albedo", "position"}},
      {"render scene.pbrt --aovs depth -o a.png", kExitUsage, {"a.png", "--aovs", "EXR"}},
      {"render scene.pbrt --aovs depth --max-depth 0", kExitUsage, {"--aovs", "--max-depth"}},
      {"render scene.pbrt --shutter 1/60", kExitUsage, {"--shutter", "--f-number"}},
      {"render scene.pbrt --f-number 8", kExitUsage, {"--f-number", "--shutter"}},
      {"render scene.pbrt --iso 100", kExitUsage, {"--iso", "--shutter"}},
      {"render scene.pbrt --f-number 8 --shutter 1/0", kExitUsage, {"--shutter", "1/0", "1/125"}},
      {"render scene.pbrt --f-number 8 --shutter 1/60s", kExitUsage, {"--shutter", "1/60s"}},
      {"render scene.pbrt --f-number 0 --shutter 1", kExitUsage, {"--f-number"}},
      {"render scene.pbrt --lens-radius -1", kExitUsage, {"--lens-radius"}},
      {"render scene.pbrt --focal-distance 0", kExitUsage, {"--focal-distance"}},
      {"render scene.pbrt --crop 2x2", kExitUsage, {"--crop", "WxH+X+Y"}},
      {"render scene.pbrt --crop 2x2+3+0", kExitBadInput, {"2x2+3+0", "4 x 3"}},
      {"render scene.pbrt --crop 0x1+0+0", kExitBadInput, {"0x1+0+0"}},
      {"render scene.pbrt --exposure nan", kExitUsage, {"--exposure", "nan"}},
      {"render scene.pbrt --tone rosy", kExitUsage, {"--tone", "filmic"}},
      {"render scene.pbrt --strategy best", kExitUsage, {"best", "importance"}},
      {"render scene.pbrt --strategy uniform:a=1", kExitUsage, {"a=1", "uniform", "none"}},
      {"render scene.pbrt --strategy importance:b=1", kExitUsage, {"b=1", "compensate"}},
      {"render scene.pbrt --strategy importance:compensate=2", kExitUsage, {"compensate=2"}},
      {"render scene.pbrt --env map.exr --strategy importance:compensate=1 --no-mis",
       kExitUsage,
       {"compensate=1", "--no-mis"}},
      {"render scene.pbrt --integrator light --strategy cosine",
       kExitUsage,
       {"cosine", "light path", "importance"}},
      {"render scene.pbrt --integrator light --aovs variance", kExitUsage, {"variance", "light"}},
      {"render scene.pbrt --integrator bdpt --no-mis", kExitUsage, {"--no-mis", "--paths"}},
      {"render scene.pbrt --integrator bdpt --max-depth 65", kExitUsage, {"--max-depth 65", "64"}},
      {"render scene.pbrt --paths 1,2", kExitUsage, {"--paths", "bdpt"}},
      {"render scene.pbrt --integrator bdpt --paths 1,1", kExitUsage, {"--paths", "T >= 2"}},
      {"render scene.pbrt --integrator bdpt --paths 1x2", kExitUsage, {"1x2", "S,T"}},
      {"render scene.pbrt --integrator vcm --paths 1,2", kExitUsage, {"--paths", "vcm", "bdpt"}},
      {"render scene.pbrt --integrator vcm --photon-distance -1",
       kExitUsage,
       {"--photon-distance"}},
      {"render scene.pbrt --integrator vcm --photon-distance 1e9",
       kExitUsage,
       {"--photon-distance 1000000000", "radius"}},
      {"render scene.pbrt --integrator vcm --photons 0", kExitUsage, {"--photons 0", "bdpt"}},
      {"render scene.pbrt --integrator bdpt --paths=-1,2", kExitUsage, {"--paths", "-1,2", "S,T"}},
      {"render scene.pbrt --integrator bdpt --paths 9,9",
       kExitUsage,
       {"--paths", "16 surfaces", "--max-depth is 5"}},
      {"render scene.pbrt --integrator light --photon-distance nan",
       kExitUsage,
       {"--photon-distance", "nan"}},
      {"render scene.pbrt --integrator photon --photon-distance -1",
       kExitUsage,
       {"--photon-distance", "-1"}},
      {"render scene.pbrt --integrator photon --photons 0 --caustic-photons 0",
       kExitUsage,
       {"needs photons", "--integrator direct"}},
      {"render scene.pbrt --integrator photon --photons 0",
       kExitUsage,
       {"--photons 0", "mirrors", "--integrator direct"}},
      {"render scene.pbrt --integrator photon --photons -3", kExitUsage, {"--photons", "-3"}},
      {"render scene.pbrt --integrator photon --photon-neighbors 1",
       kExitUsage,
       {"--photon-neighbors"}},
      {"render scene.pbrt --integrator photon --photon-kernel box",
       kExitUsage,
       {"--photon-kernel", "box", "cone"}},
      {"render scene.pbrt --integrator photon --gather -1", kExitUsage, {"--gather"}},
      {"render scene.pbrt --integrator photon --progressive 5",
       kExitUsage,
       {"--progressive 5", "--spp is 1"}},
      {"render scene.pbrt --integrator vcm --progressive 0", kExitUsage, {"--progressive"}},
      {"render scene.pbrt --integrator vcm --progressive-alpha 2",
       kExitUsage,
       {"--progressive-alpha"}},
      {"render far.ply --env map.exr --integrator bdpt", kExitBadInput, {"vertex 1", "1e+09"}},
      {"paths scene.pbrt --integrator vcm", kExitUsage, {"--integrator", "bdpt"}},
      {"paths scene.pbrt --paths 1,2", kExitUsage, {"--paths", "every way"}},
      {"paths scene.pbrt -o techniques.png", kExitUsage, {"techniques.png", ".exr"}},
      {"paths scene.pbrt --max-depth 9", kExitUsage, {"--max-depth 9", "layers"}},
      {"bench nosuch.pbrt", kExitBadInput, {"nosuch.pbrt"}},
      {"bench scene.pbrt --repetitions 0", kExitUsage, {"--repetitions"}},
  };
  std::vector<BadCase> all(std::begin(cases), std::end(cases));
  // Light paths have no light to start from, or cannot start.
  for (const std::string integrator : {"light", "bdpt", "photon", "vcm"}) {
    const std::string flag = " --integrator " + integrator;
    all.push_back({"render scene.pbrt --env map.exr --env-intensity 0" + flag,
                   kExitBadInput,
                   {"scene.pbrt", "black", "--env"}});
    all.push_back({"render dark.pbrt" + flag, kExitBadInput, {"dark.pbrt", "no light", "--env"}});
    all.push_back({"render empty.pbrt" + flag, kExitBadInput, {"empty.pbrt", "no triangle"}});
    all.push_back({"render point.pbrt" + flag,
                   kExitBadInput,
                   {"point.pbrt", "radius 0", "--integrator path"}});
  }
  const std::set<std::string> before = Files();
  for (const BadCase& test : all) {
    SCOPED_TRACE("skywave " + test.arguments);
    const bool sized = Contains(test.arguments, "--size") ||
                       Contains(test.arguments, "film.pbrt") ||
                       !Contains(test.arguments, "render ");
    const Result result = Run(test.arguments + (sized ? "" : small));
    EXPECT_EQ(result.exit_code, test.exit_code) << result.err;
    for (const std::string& part : test.message) {
      EXPECT_TRUE(Contains(result.err, part)) << "no \"" << part << "\" in: " << result.err;
    }
    EXPECT_EQ(result.out, "");
    EXPECT_EQ(Files(), before);
  }
}

// A file that existed before a failure survives it.
TEST_F(Cli, AFailureKeepsTheOldPicture) {
  Put("a.exr", "old");
  EXPECT_NE(Run("render scene.pbrt --env cut.exr -o a.exr").exit_code, 0);
  EXPECT_EQ(Bytes("a.exr"), "old");
}

TEST_F(Cli, SquareMapsOfPbrtFourAreOctahedral) {
  Image map(8, 8);
  for (float& value : map.rgb) value = 1;
  WriteExr(Path("square.exr"), map);
  for (const auto& [name, projection] :
       {std::pair("filename", "octahedral"), std::pair("mapname", "angular")}) {
    Put("s.pbrt", std::string("WorldBegin LightSource \"infinite\" \"string ") + name +
                      "\" \"square.exr\" Shape \"sphere\"");
    const Result result = Run("render s.pbrt --size 8x8 --spp 1 -o s.exr");
    EXPECT_NE(result.err.find(projection), std::string::npos) << result.err;
  }
}

// Constants and maps, rotated or not, must look like the sum of their parts in every octant of the
// sphere. The maps are smooth, so that resampling loses little.
TEST_F(Cli, InfiniteLightsAreSummed) {
  const auto write = [&](const std::string& name, int width, int height) {
    Image map(width, height);
    for (int y = 0; y < height; ++y) {
      for (int x = 0; x < width; ++x) {
        for (int c = 0; c < 3; ++c) {
          const double phi = 2 * M_PI * (x + 0.5) / width + c, theta = M_PI * (y + 0.5) / height;
          map.Pixel(x, y)[c] = float(1.5 + std::sin(theta) * std::sin(phi) + 0.4 * std::cos(theta));
        }
      }
    }
    WriteExr(Path(name), map);
  };
  write("map.exr", 32, 16), write("fine.exr", 64, 32);
  const std::string begin =
      "Camera \"environment\" WorldBegin Translate 0 0 9 Shape \"sphere\" \"float radius\" .001\n";
  const std::string flat = "LightSource \"infinite\" \"rgb L\" [1 2 3]\n",
                    coarse = "LightSource \"infinite\" \"string mapname\" \"map.exr\"\n",
                    turned =
                        "AttributeBegin Rotate 50 1 2 0\n"
                        "LightSource \"infinite\" \"string mapname\" \"fine.exr\"\nAttributeEnd\n";
  const auto seen = [&](const std::string& lights) {
    Put("sum.pbrt", begin + lights);
    const Result result = Run("render sum.pbrt --strict --size 64x32 --spp 4 -o sum.exr");
    EXPECT_EQ(result.exit_code, 0) << result.err;
    EXPECT_EQ(result.err.find("are summed") != std::string::npos,
              lights.find("LightSource") != lights.rfind("LightSource"))
        << result.err;
    const Image picture = ReadImage(Path("sum.exr"));
    std::vector<double> eighths(8 * 3);
    for (int y = 0; y < 32; ++y) {
      for (int x = 0; x < 64; ++x) {
        for (int c = 0; c < 3; ++c) {
          eighths[std::size_t((y / 16 * 4 + x / 16) * 3 + c)] += picture.Pixel(x, y)[c] / 256;
        }
      }
    }
    return eighths;
  };
  const auto one = seen(flat), two = seen(coarse), three = seen(turned);
  const auto expect_sum = [&](const std::string& lights, double a, double b, double c) {
    const auto sum = seen(lights);
    for (std::size_t i = 0; i < sum.size(); ++i) {
      const double expected = a * one[i] + b * two[i] + c * three[i];
      EXPECT_NEAR(sum[i], expected, 1e-2 * expected) << lights << i;
    }
  };
  expect_sum(flat + flat, 2, 0, 0);
  expect_sum(flat + coarse, 1, 1, 0);
  expect_sum(coarse + flat + coarse, 1, 2, 0);
  expect_sum(flat + coarse + turned, 1, 1, 1);
}

// What is not rendered as the file asks is a warning, and what was assumed is a note.
TEST_F(Cli, WarningsAreApartFromNotes) {
  const Result result =
      Run("render library.obj --env map.exr --size 4x3 --spp 2 -o a.exr --stats s.json");
  EXPECT_EQ(result.exit_code, 0);
  const std::string missing = "library.obj:1: mtllib: there is no file \"nosuch.mtl\"";
  EXPECT_TRUE(Contains(result.err, "warning: " + missing)) << result.err;
  EXPECT_TRUE(Contains(result.err, "note: library.obj: has no camera")) << result.err;
  const auto json = nlohmann::json::parse(Bytes("s.json"));
  ASSERT_EQ(json.at("warnings").size(), 1u);
  EXPECT_TRUE(Contains(json.at("warnings").at(0).get<std::string>(), missing));
  for (const auto& note : json.at("notes")) {
    EXPECT_FALSE(Contains(note.get<std::string>(), missing)) << note;
  }
  const Result info = Run("info library.obj");
  EXPECT_TRUE(Contains(info.out, "1 warnings\n  " + missing)) << info.out;
}

TEST_F(Cli, BadPixelsOfAMapAreReported) {
  const Result result = Run("render good.ply --env bad.pfm --size 4x3 --spp 2 -o a.exr");
  EXPECT_EQ(result.exit_code, 0);
  EXPECT_TRUE(Contains(result.err, "bad.pfm: 1 NaN, 1 infinite and 2 negative pixels"))
      << result.err;
  EXPECT_TRUE(Contains(result.err, "no camera")) << result.err;
  for (const float value : ReadImage(Path("a.exr")).rgb) EXPECT_TRUE(std::isfinite(value));
  EXPECT_EQ(Run("render good.ply --env bad.pfm --size 4x3 --spp 2 -o a.exr --quiet").err, "");
}

TEST_F(Cli, BenchReportsItsSummary) {
  const Result result =
      Run("bench scene.pbrt --size 16x16 --spp 2 --repetitions 3 --json b.json --threads 1");
  EXPECT_EQ(result.exit_code, 0) << result.err;
  EXPECT_TRUE(Contains(result.out, "SUMMARY msamples_per_s=")) << result.out;
  const auto json = nlohmann::json::parse(Bytes("b.json"));
  EXPECT_EQ(json.at("schema"), "skywave-bench-2");
  EXPECT_EQ(json.at("render_seconds").size(), 3u);
  for (const Backend backend : kBackends) {
    EXPECT_EQ(json.at("replay_seconds").at(ToString(backend)).at("camera").size(), 3u);
  }
  EXPECT_GT(json.at("summary").at("embree_fraction").get<double>(), 0);
}

}  // namespace
}  // namespace skywave
