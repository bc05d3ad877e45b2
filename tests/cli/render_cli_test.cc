// Tests what render and paths write: pictures, layers, statistics, crops, and the command that
// repeats a picture.
#include <gtest/gtest.h>

#include <cmath>
#include <nlohmann/json.hpp>
#include <string>
#include <vector>

#include "image/exr_header.h"
#include "image/image.h"
#include "tests/support/program.h"
#include "wavefront/film/aovs.h"

namespace skywave {
namespace {

bool Contains(const std::string& text, const std::string& part) {
  return text.find(part) != std::string::npos;
}

class RenderCli : public Program {
 protected:
  void SetUp() override {
    Program::SetUp();
    Put("scene.pbrt",
        "WorldBegin\nLightSource \"infinite\" \"rgb L\" [1 1 1]\n"
        "Shape \"trianglemesh\" \"integer indices\" [0 1 2]\n"
        "  \"point P\" [-1 -1 3 1 -1 3 0 1 3]\nWorldEnd\n");
    Put("good.ply",
        "ply\nformat ascii 1.0\nelement vertex 3\nproperty float x\nproperty float y\n"
        "property float z\nelement face 1\nproperty list uchar int vertex_indices\nend_header\n"
        "0 0 0\n1 0 0\n0 1 0\n3 0 1 2\n");
    Image map(8, 4);
    for (std::size_t i = 0; i < map.rgb.size(); ++i) map.rgb[i] = float(1 + i % 5);
    WriteExr(Path("map.exr"), map);
  }
};

TEST_F(RenderCli, LayersAccompanyThePicture) {
  const std::string picture = "render scene.pbrt --size 6x4 --spp 3 -q";
  ASSERT_EQ(Run(picture + " -o plain.exr").exit_code, 0);
  ASSERT_EQ(Run(picture + " --aovs uv,depth -o layers.exr").exit_code, 0);
  EXPECT_EQ(ReadImage(Path("plain.exr")).rgb, ReadImage(Path("layers.exr")).rgb);
  EXPECT_EQ(Bytes("plain.png"), Bytes("layers.png"));
  const ExrHeader header = ParseExrHeaders("layers.exr", Bytes("layers.exr"), {}).front();
  std::vector<std::string> names;
  for (const ExrChannel& channel : header.channels) names.push_back(channel.name);
  EXPECT_EQ(names, (std::vector<std::string>{"B", "G", "R", "depth.Z", "uv.A", "uv.U", "uv.V"}));
  // The command in the header reproduces the file, layers included.
  std::string command;
  for (const auto& [name, text] : header.strings) command += name == "command" ? text : "";
  ASSERT_EQ(command.find("skywave "), 0u);
  ASSERT_EQ(Run(command.substr(8) + " -q -o again.exr").exit_code, 0);
  EXPECT_TRUE(Bytes("layers.exr") == Bytes("again.exr"));
  for (const Aov& aov : Aovs()) {
    EXPECT_TRUE(Contains(Run("render --help").out, std::string(aov.name)));
  }
}

TEST_F(RenderCli, ACameraExposesThePng) {
  const std::string picture = "render scene.pbrt --size 6x4 --spp 2 -q";
  // EV100 is 0, so a luminance of 1.2 becomes white; the second picture lowers the exposure by
  // log2(1.2) stops.
  ASSERT_EQ(Run(picture + " --shutter 1 --f-number 1 -o camera.exr").exit_code, 0);
  ASSERT_EQ(Run(picture + " --exposure=-0.263034 -o stops.exr").exit_code, 0);
  EXPECT_EQ(Bytes("camera.png"), Bytes("stops.png"));
  ASSERT_EQ(
      Run(picture + " --shutter 1/4 --f-number 2 --iso 400 --exposure=-2 -o sum.exr").exit_code, 0);
  ASSERT_EQ(Run(picture + " --exposure=-4.263034 -o less.exr").exit_code, 0);
  EXPECT_EQ(Bytes("sum.png"), Bytes("less.png"));
  EXPECT_NE(Bytes("sum.png"), Bytes("stops.png"));
  EXPECT_EQ(ReadImage(Path("sum.exr")).rgb, ReadImage(Path("stops.exr")).rgb);
}

// A message appears if a flag can have no effect, and only then.
TEST_F(RenderCli, SaysWhenThereIsNothingToGuide) {
  const auto notes = [&](const std::string& arguments) {
    const Result result = Run("render " + arguments + " --size 4x3 --spp 1 --guide -o a.exr");
    EXPECT_EQ(result.exit_code, 0) << result.err;
    return result.err;
  };
  EXPECT_TRUE(Contains(notes("lamps --integrator bdpt"), "--guide changes nothing"));
  EXPECT_TRUE(Contains(notes("furnace"), "--integrator path has no light paths"));
  EXPECT_FALSE(Contains(notes("furnace --integrator bdpt"), "--guide"));
}

TEST_F(RenderCli, RenderWritesAnExrAndAPngNamedAfterTheScene) {
  const std::set<std::string> before = Files();
  const Result result = Run("render scene.pbrt --size 5x4 --spp 2");
  EXPECT_EQ(result.exit_code, 0) << result.err;
  EXPECT_TRUE(Contains(result.out, "scene.exr") && Contains(result.out, "scene.png")) << result.out;
  std::set<std::string> expected = before;
  expected.insert({"scene.exr", "scene.png"});
  EXPECT_EQ(Files(), expected);
  const Image image = ReadImage(Path("scene.exr"));
  EXPECT_EQ(image.width, 5);
  EXPECT_EQ(image.height, 4);
}

TEST_F(RenderCli, StatisticsHaveThePromisedKeys) {
  ASSERT_EQ(Run("render scene.pbrt --size 6x5 --spp 3 -q --stats s.json --threads 1 --max-depth 3")
                .exit_code,
            0);
  const auto json = nlohmann::json::parse(Bytes("s.json"));
  EXPECT_EQ(json.at("schema"), "skywave-render-stats-1");
  EXPECT_TRUE(json.at("version").is_string());
  const auto& settings = json.at("settings");
  EXPECT_EQ(settings.at("width"), 6);
  EXPECT_EQ(settings.at("height"), 5);
  EXPECT_EQ(settings.at("samples_per_pixel"), 3);
  EXPECT_EQ(settings.at("integrator"), "path");
  EXPECT_EQ(settings.at("max_depth"), 3);
  EXPECT_EQ(settings.at("strategy"), "importance");
  EXPECT_EQ(settings.at("threads"), 1);
  EXPECT_EQ(settings.at("wave"), 2048);
  EXPECT_EQ(settings.at("backend"), "best");
  EXPECT_EQ(json.at("scene").at("triangles"), 1);
  EXPECT_EQ(json.at("scene").at("hash").get<std::string>().size(), 16u);
  for (const char* const key : {"load", "build", "tables", "render", "write"}) {
    EXPECT_GE(json.at("seconds").at(key).get<double>(), 0) << key;
  }
  EXPECT_GT(json.at("peak_memory_mib").get<double>(), 1);
  EXPECT_EQ(json.at("samples"), 6 * 5 * 3);
  // Camera rays come in blocks of 4 x 2 pixels.
  EXPECT_EQ(json.at("rays").at("camera").at("count"), 8 * 6 * 3);
  for (const char* const key : {"camera", "bounce", "shadow"}) {
    EXPECT_GE(json.at("rays").at(key).at("mrays_per_s").get<double>(), 0) << key;
  }
  double share = 0;
  EXPECT_EQ(json.at("stages").size(), 12u);
  for (const auto& stage : json.at("stages")) share += stage.at("share").get<double>();
  EXPECT_NEAR(share, 1, 1e-9);
  EXPECT_GE(json.at("waves").get<int>(), 1);
  EXPECT_FALSE(json.at("occupancy").empty());
  EXPECT_EQ(json.at("clamped_samples"), 0);
  EXPECT_EQ(json.at("invalid_samples"), 0);
  // Millions a second, of all and of each kind.
  const double seconds = json.at("seconds").at("render");
  const auto expect_rate = [&](const nlohmann::json& of, const char* key, double count) {
    EXPECT_NEAR(of.at(key).get<double>() * seconds, count * 1e-6, 1e-9 * count) << key;
  };
  expect_rate(json, "msamples_per_s", 6 * 5 * 3);
  double rays = 0;
  for (const auto& kind : json.at("rays")) {
    expect_rate(kind, "mrays_per_s", kind.at("count"));
    rays += kind.at("count").get<double>();
  }
  expect_rate(json, "mrays_per_s", rays);
  EXPECT_FALSE(json.contains("mean_samples_per_pixel"));
}

// Blocks of an adaptive picture end early, and the mean is what was rendered of each pixel.
TEST_F(RenderCli, StatisticsOfAdaptiveSamplesHaveTheirMean) {
  ASSERT_EQ(Run("render spheres --size 16x16 --spp 64 --adaptive 0.5 --adaptive-min 8 -q --stats "
                "s.json -o a.exr")
                .exit_code,
            0);
  const auto json = nlohmann::json::parse(Bytes("s.json"));
  EXPECT_NEAR(json.at("mean_samples_per_pixel").get<double>(),
              json.at("samples").get<double>() / (16 * 16), 1e-3);
  EXPECT_GT(json.at("ended_blocks").get<double>(), 0);
  EXPECT_LE(json.at("ended_blocks").get<double>(), 1);
}

std::string Value(const Metadata& metadata, const std::string& name) {
  for (const auto& [key, value] : metadata) {
    if (key == name) return value;
  }
  return "(none)";
}

// The metadata records how the picture was made, and its command reproduces it to the last byte.
TEST_F(RenderCli, TheCommandInThePictureRepeatsIt) {
  std::filesystem::create_directory(Path("my maps"));
  std::filesystem::copy_file(Path("map.exr"), Path("my maps/sky's.exr"));
  const std::string commands[] = {
      "render scene.pbrt --size 9x7 --spp 3",
      "render good.ply --env map.exr --env-rotate 31.7 --env-intensity 0.3 --env-up z --seed 77 "
      "--size 8x6 --spp 5 --integrator direct --light-samples 3 --no-mis --threads 2 --wave 33",
      "render scene.pbrt --env \"my maps/sky's.exr\" --env-projection latlong --size 7x7 --spp 2 "
      "--filter gaussian --filter-radius 0.7 --max-depth 2 --embree-config isa=sse2 "
      "--strategy importance:compensate=1 --backend single",
      "render good.ply --env map.exr --ground --size 12x9 --crop 7x5+2+3 --spp 2 --eye=-1.5,2,3 "
      "--fov 31.5 --lens-radius 0.1 --focal-distance 2.25",
      "render good.ply --env map.exr --size 8x4 --spp 2 --camera latlong --target 0.1,0.2,-0.3",
      "render good.ply --env map.exr --ground --size 12x9 --spp 2 --integrator light --wave 7",
      "render good.ply --env map.exr --ground --size 12x9 --spp 2 --integrator bdpt --wave 7",
      "render good.ply --env map.exr --ground --size 12x9 --spp 2 --integrator bdpt --paths 2,1 "
      "--no-mis",
      "render good.ply --env map.exr --ground --size 12x9 --spp 2 --integrator vcm --wave 7",
      "render good.ply --env map.exr --ground --size 12x9 --spp 6 --integrator vcm --progressive 3 "
      "--photons 100 --progressive-alpha 0.5 --photon-kernel cone",
  };
  for (const std::string& command : commands) {
    SCOPED_TRACE(command);
    const Result first = Run(command + " -q -o first.exr");
    ASSERT_EQ(first.exit_code, 0) << first.err;
    const Metadata metadata = ReadExrMetadata(Path("first.exr"));
    EXPECT_TRUE(Contains(Value(metadata, "software"), "skywave 0."));
    EXPECT_TRUE(Contains(command, "--spp " + Value(metadata, "samples")));
    EXPECT_EQ(Value(metadata, "seed"), Contains(command, "--seed") ? "77" : "0");
    EXPECT_EQ(Value(metadata, "sceneHash").size(), 16u);
    const std::string repeat = Value(metadata, "command");
    ASSERT_EQ(repeat.substr(0, 8), "skywave ");
    const Result second = Run(repeat.substr(8) + " -q -o second.exr");
    ASSERT_EQ(second.exit_code, 0) << repeat << "\n" << second.err;
    EXPECT_TRUE(Bytes("first.exr") == Bytes("second.exr")) << repeat;
    EXPECT_TRUE(Bytes("first.png") == Bytes("second.png")) << repeat;
  }
}

// The sheet and the layers show every technique that connects sub-paths.
TEST_F(RenderCli, PathsShowsEveryTechnique) {
  const std::string common = "good.ply --env map.exr --ground --size 12x9 --spp 2 --max-depth 2 -q";
  ASSERT_EQ(Run("paths " + common + " -o techniques.exr").exit_code, 0);
  ASSERT_EQ(Run("render " + common + " --integrator bdpt -o whole.exr").exit_code, 0);
  EXPECT_TRUE(ReadImage(Path("techniques.exr")).rgb == ReadImage(Path("whole.exr")).rgb);
  const std::string bytes = Bytes("techniques.exr");
  for (const char* const technique :
       {"s0t2", "s0t3", "s1t2", "s2t1", "s0t4", "s1t3", "s2t2", "s3t1"}) {
    EXPECT_TRUE(Contains(bytes, std::string("unweighted_") + technique + ".G")) << technique;
    EXPECT_TRUE(Contains(bytes, std::string("weighted_") + technique + ".R")) << technique;
  }
  EXPECT_FALSE(Contains(bytes, "weighted_s1t1"));
  // The sheet has four columns and six rows of 12 x 9 with gaps of 2, each picture below its
  // caption.
  const Image sheet = ReadTexture(Path("techniques.png"), Encoding::kSrgb);
  EXPECT_EQ(sheet.width, 4 * 14 - 2);
  EXPECT_EQ(sheet.height, 6 * 22 - 2);
}

// Each technique is the picture of `render --paths`, in its layer and at its place on the sheet.
TEST_F(RenderCli, PathsShowsWhatRenderMakesOfEachTechnique) {
  const std::string common =
      "good.ply --env map.exr --ground --size 12x9 --spp 2 --max-depth 2 -q ";
  ASSERT_EQ(Run("paths " + common + "--exposure=-3 -o techniques.exr").exit_code, 0);
  const Image sheet = ReadTexture(Path("techniques.png"), Encoding::kSrgb);
  std::vector<double> sum(12 * 9 * 3);
  for (const auto& [light, eye] :
       {std::pair(0, 2), std::pair(0, 3), std::pair(1, 2), std::pair(2, 1), std::pair(0, 4),
        std::pair(1, 3), std::pair(2, 2), std::pair(3, 1)}) {
    for (const bool weighted : {true, false}) {
      const std::string name = (weighted ? "weighted_s" : "unweighted_s") + std::to_string(light) +
                               "t" + std::to_string(eye);
      SCOPED_TRACE(name);
      ASSERT_EQ(
          Run("render " + common + "--exposure=-3 -o one.exr --integrator bdpt --paths " +
              std::to_string(light) + "," + std::to_string(eye) + (weighted ? "" : " --no-mis"))
              .exit_code,
          0);
      const Image one = ReadImage(Path("one.exr"));
      const LayeredImage layers =
          ReadLayeredImage(Path("techniques.exr"), {name + ".R", name + ".G", name + ".B"});
      for (std::size_t i = 0; i < one.rgb.size(); ++i) {
        ASSERT_EQ(layers.layers[i % 3].values[i / 3], one.rgb[i]);
        if (weighted) sum[i] += one.rgb[i];
      }
      const Image png = ReadTexture(Path("one.png"), Encoding::kSrgb);
      const int left = light * 14, top = (light + eye - 2 + (weighted ? 0 : 3)) * 22 + 11;
      for (int y = 0; y < 9; ++y) {
        for (int x = 0; x < 12; ++x) {
          for (int c = 0; c < 3; ++c) {
            ASSERT_EQ(sheet.Pixel(left + x, top + y)[c], png.Pixel(x, y)[c]) << x << ", " << y;
          }
        }
      }
    }
  }
  const Image whole = ReadImage(Path("techniques.exr"));
  for (std::size_t i = 0; i < sum.size(); ++i) EXPECT_NEAR(sum[i], whole.rgb[i], 1e-5 * sum[i]);
}

// A crop of the film has exactly the pixels that the whole film has there.
TEST_F(RenderCli, ACropIsAPartOfTheWholePicture) {
  for (const std::string camera : {"perspective --lens-radius 0.2", "orthographic", "latlong",
                                   "perspective --integrator photon --photons 300 --guide"}) {
    const std::string common =
        "render good.ply --env map.exr --ground --size 12x9 --spp 4 -q "
        "--camera " +
        camera;
    ASSERT_EQ(Run(common + " -o whole.exr").exit_code, 0);
    ASSERT_EQ(Run(common + " --crop 7x5+2+3 -o part.exr").exit_code, 0);
    const Image whole = ReadImage(Path("whole.exr"));
    const LayeredImage in_window = ReadDataWindow(Path("part.exr"));
    const Image& part = in_window.image;
    ASSERT_EQ(part.width, 7);
    ASSERT_EQ(part.height, 5);
    // The EXR says where it lies; who reads the whole picture gets black around it.
    EXPECT_EQ(in_window.placement.x, 2);
    EXPECT_EQ(in_window.placement.y, 3);
    const Image placed = ReadImage(Path("part.exr"));
    ASSERT_EQ(placed.width, 12);
    ASSERT_EQ(placed.height, 9);
    EXPECT_EQ(placed.Pixel(2, 3)[0], part.Pixel(0, 0)[0]);
    EXPECT_EQ(placed.Pixel(1, 3)[0], 0);
    for (int y = 0; y < 5; ++y) {
      for (int x = 0; x < 7; ++x) {
        for (int c = 0; c < 3; ++c) {
          ASSERT_EQ(part.Pixel(x, y)[c], whole.Pixel(x + 2, y + 3)[c]) << x << ", " << y;
        }
      }
    }
  }
}

// pbrt rounds the fractions of a cropwindow up to pixels; a flag overrides the file.
TEST_F(RenderCli, ACropWindowOfAPbrtFileIsTaken) {
  const auto with = [&](const std::string& parameters) {
    return "Film \"rgb\" \"integer xresolution\" 9 \"integer yresolution\" 6 " + parameters + "\n" +
           Bytes("scene.pbrt");
  };
  Put("whole.pbrt", with(""));
  Put("part.pbrt", with("\"float cropwindow\" [.25 .75 .5 1]"));
  ASSERT_EQ(Run("render part.pbrt --spp 2 -q -o a.exr").exit_code, 0);
  ASSERT_EQ(Run("render whole.pbrt --crop 4x3+3+3 --spp 2 -q -o b.exr").exit_code, 0);
  EXPECT_EQ(Bytes("a.png"), Bytes("b.png"));
  EXPECT_EQ(ReadDataWindow(Path("a.exr")).image.width, 4);
  ASSERT_EQ(Run("render part.pbrt --crop 1x2+0+0 --spp 2 -q -o a.exr").exit_code, 0);
  EXPECT_EQ(ReadDataWindow(Path("a.exr")).image.height, 2);
}

// What options of the command line decide is what a render has counted.
TEST_F(RenderCli, OptionsOfSplitPathsChangeTheRayCounts) {
  const auto rays = [&](const std::string& kind, const std::string& options) {
    const Result result =
        Run("render good.ply --env map.exr --ground --size 16x12 --spp 4 -q "
            "--max-depth 2 --stats s.json -o a.exr " +
            options);
    EXPECT_EQ(result.exit_code, 0) << result.err;
    const auto json = nlohmann::json::parse(Bytes("s.json"));
    return json.at("rays").at(kind).at("count").get<double>();
  };
  const double bounces = rays("bounce", "");
  EXPECT_NEAR(rays("bounce", "--split 3") / bounces, 3, 0.3);
  // Light samples after the split cost shadow rays, which the BSDF alone does not need.
  const double by_map = rays("shadow", "--split 3 --strategy importance");
  const double by_bsdf =
      rays("shadow", "--split 3 --strategy importance --continuation-strategy bsdf");
  EXPECT_GT(by_bsdf, 0);
  EXPECT_LT(by_bsdf, 0.9 * by_map);
}

TEST_F(RenderCli, SceneHashesDifferBetweenScenes) {
  const auto hash = [&](const std::string& arguments) {
    EXPECT_EQ(Run("render " + arguments + " -q --size 3x3 --spp 1 -o h.exr").exit_code, 0);
    return Value(ReadExrMetadata(Path("h.exr")), "sceneHash");
  };
  const std::string plain = hash("scene.pbrt");
  EXPECT_EQ(hash("scene.pbrt --seed 3"), plain);
  EXPECT_NE(hash("scene.pbrt --env map.exr"), plain);
  EXPECT_NE(hash("good.ply --env map.exr"), hash("good.ply --env map.exr --env-rotate 5"));
}

}  // namespace
}  // namespace skywave
