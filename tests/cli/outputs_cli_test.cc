// Tests what commands write from the outside: never over an input, through links and into pipes,
// and PNGs through the tone curve that is asked for.
#include <gtest/gtest.h>
#include <sys/stat.h>

#include <algorithm>
#include <set>
#include <string>

#include "base/error.h"
#include "image/image.h"
#include "tests/support/program.h"

namespace skywave {
namespace {

class Outputs : public Program {};

TEST_F(Outputs, AnInputIsNeverOverwritten) {
  WriteExr(Path("sky.exr"), Image(4, 2));
  Put("sky.pbrt", "WorldBegin Shape \"sphere\"");
  const std::string before = Bytes("sky.exr");
  const Result result = Run("render sky.pbrt --env sky.exr --size 8x8 --spp 1");
  EXPECT_EQ(result.exit_code, 64);
  EXPECT_NE(result.err.find("sky.exr: is an input"), std::string::npos) << result.err;
  EXPECT_EQ(Bytes("sky.exr"), before);
  // What a scene names itself is an input, too.
  Put("part.pbrt", "LightSource \"infinite\" \"string filename\" \"map.exr\"");
  Put("map.pbrt", "WorldBegin Include \"part.pbrt\" Shape \"sphere\"");
  Put("earlier.json", "{}");
  Image map(4, 2);
  map.rgb.assign(map.rgb.size(), 1.0f);
  WriteExr(Path("map.exr"), map);
  for (const std::string name : {"map.exr", "map.pbrt", "part.pbrt"}) {
    const std::string old = Bytes(name);
    for (const std::string& command :
         {"render map.pbrt --size 8x8 --spp 1" + (name == "map.exr" ? "" : " --stats " + name),
          "paths map.pbrt --size 8x8 --spp 1 -o " + name,
          "converge map.pbrt --size 8x8 --budgets 1 --json " + name,
          "converge map.pbrt --size 8x8 --budgets 1 --save-reference " + name,
          "bench map.pbrt --size 8x8 --json " + name,
          "bench map.pbrt --size 8x8 --sustain 0.1 --json " + name,
          "bench map.pbrt --size 8x8 --copies 1 --repetitions 1 --json " + name}) {
      EXPECT_EQ(Run(command).exit_code, kExitUsage) << command;
      EXPECT_EQ(Bytes(name), old) << command;
    }
  }
  EXPECT_EQ(Run("bench --history earlier.json --report earlier.json").exit_code, kExitUsage);
  EXPECT_EQ(Bytes("earlier.json"), "{}");
  for (const char* command :
       {"compare sky.exr map.exr --map sky.exr", "compare map.exr sky.exr --map sky.exr",
        "compare sky.exr map.exr --json sky.exr"}) {
    EXPECT_EQ(Run(command).exit_code, kExitUsage) << command;
    EXPECT_EQ(Bytes("sky.exr"), before) << command;
  }
}

// `--ground catcher` is one switch for a plane and its name; a crop keeps its place through merging
// and denoising.
TEST_F(Outputs, TheGroundMayBeACatcher) {
  const std::string picture = "render three-spheres --size 24x18 --spp 4 -q ";
  ASSERT_EQ(Run(picture + "--ground --catcher ground -o named.exr").exit_code, 0);
  ASSERT_EQ(Run(picture + "--ground catcher -o word.exr").exit_code, 0);
  ASSERT_EQ(Run(picture + "--ground=catcher -o sign.exr").exit_code, 0);
  ASSERT_EQ(Run(picture + "--ground -o grey.exr").exit_code, 0);
  EXPECT_EQ(Bytes("word.png"), Bytes("named.png"));
  EXPECT_EQ(Bytes("word.exr"), Bytes("sign.exr"));
  EXPECT_NE(Bytes("word.png"), Bytes("grey.png"));
  const Metadata metadata = ReadExrMetadata(Path("word.exr"));
  const auto command = std::find_if(metadata.begin(), metadata.end(),
                                    [](const auto& text) { return text.first == "command"; });
  ASSERT_NE(command, metadata.end());
  EXPECT_NE(command->second.find(" --ground catcher "), std::string::npos) << command->second;
  EXPECT_EQ(Run(picture + "--ground catchers -o x.exr").exit_code, kExitUsage);
}

TEST_F(Outputs, CropsKeepTheirPlaceWhenDenoisedAndMerged) {
  const std::string picture =
      "render spheres --size 40x30 --crop 16x12+8+9 --spp 8 --aovs denoiser,crypto-object -q ";
  ASSERT_EQ(Run(picture + "-o part.exr --film part.film").exit_code, 0);
  ASSERT_EQ(Run("merge part.film --crop 16x12+8+9 -q -o merged.exr").exit_code, 0);
  EXPECT_EQ(Bytes("merged.exr"), Bytes("part.exr"));
  ASSERT_EQ(Run("denoise part.exr -q -o clean.exr").exit_code, 0);
  const Placement place = ReadDataWindow(Path("clean.exr")).placement;
  EXPECT_EQ(place.x, 8);
  EXPECT_EQ(place.y, 9);
  EXPECT_EQ(place.width, 40);
  EXPECT_EQ(place.height, 30);
  // The clean picture has no matte, so its header has no names of one.
  for (const auto& [name, text] : ReadExrMetadata(Path("clean.exr"))) {
    EXPECT_FALSE(name.starts_with("cryptomatte")) << name;
  }
}

TEST_F(Outputs, MattesAreNotWrittenWithLoss) {
  for (const char* const lossy : {"dwaa", "dwab", "pxr24"}) {
    const Result result =
        Run("render spheres --size 8x6 --spp 1 --aovs crypto-object -o x.exr "
            "--compression " +
            std::string(lossy));
    EXPECT_EQ(result.exit_code, kExitUsage);
    EXPECT_NE(result.err.find("crypto-object"), std::string::npos) << result.err;
  }
  // Numbers of 16 bits are for colours alone.
  const std::string picture = "render spheres --size 8x6 --spp 4 --aovs crypto-object -q ";
  ASSERT_EQ(Run(picture + "-o full.exr").exit_code, 0);
  ASSERT_EQ(Run(picture + "--half -o half.exr").exit_code, 0);
  const std::vector<std::string> names = {"crypto_object00.R", "crypto_object00.G",
                                          "crypto_object00.B", "crypto_object00.A"};
  const LayeredImage full = ReadLayeredImage(Path("full.exr"), names);
  const LayeredImage half = ReadLayeredImage(Path("half.exr"), names);
  for (std::size_t i = 0; i < names.size(); ++i) {
    EXPECT_EQ(full.layers[i].values, half.layers[i].values) << names[i];
  }
}

// Pictures with catchers have alpha, in the PNG too, and are put together from parts as others are.
TEST_F(Outputs, CatchersGiveBothFilesAlpha) {
  const std::string picture =
      "render spheres --catcher floor --size 40x30 --spp 8 --tone filmic -q ";
  ASSERT_EQ(Run(picture + "-o whole.exr").exit_code, 0);
  EXPECT_TRUE(IsRgba(Path("whole.exr")) && IsRgba(Path("whole.png")));
  const LayeredImage whole = ReadLayeredImage(Path("whole.exr"), {"A", "shadow.G", "difference.G"});
  const std::vector<float>& alpha = whole.layers[0].values;
  const Image in_png = ReadTexture(Path("whole.png"), Encoding::kAlpha);
  int between = 0;
  for (std::size_t i = 0; i < alpha.size(); ++i) {
    EXPECT_NEAR(in_png.rgb[3 * i], alpha[i], 0.51 / 255);
    between += alpha[i] > 0.1 && alpha[i] < 0.9;
  }
  EXPECT_GT(between, 20);

  ASSERT_EQ(Run(picture + "--alpha straight -o straight.exr").exit_code, 0);
  const Image straight = ReadImage(Path("straight.exr"));
  for (std::size_t i = 0; i < straight.rgb.size(); ++i) {
    if (alpha[i / 3] > 0) {
      EXPECT_NEAR(straight.rgb[i] * alpha[i / 3], whole.image.rgb[i],
                  1e-6 * (1 + whole.image.rgb[i]));
    }
  }
  EXPECT_TRUE(Bytes("straight.png") == Bytes("whole.png"));

  ASSERT_EQ(Run(picture + "--sample-range 2:8 --film a.film").exit_code, 0);
  ASSERT_EQ(Run(picture + "--sample-range 0:2 --film b.film").exit_code, 0);
  ASSERT_EQ(Run("merge a.film b.film -q -o merged.exr").exit_code, 0);
  EXPECT_TRUE(Bytes("merged.exr") == Bytes("whole.exr"));
  EXPECT_TRUE(Bytes("merged.png") == Bytes("whole.png"));

  const std::string clear = "render spheres --background transparent --size 40x30 --spp 16 -q ";
  ASSERT_EQ(Run(clear + "--aovs denoiser -o noisy.exr").exit_code, 0);
  ASSERT_EQ(Run("denoise noisy.exr -q -o clean.exr").exit_code, 0);
  ASSERT_EQ(Run(clear + "--denoise -o clear.exr").exit_code, 0);
  const LayeredImage clean = ReadLayeredImage(Path("clean.exr"), {"A"});
  EXPECT_EQ(clean.image.rgb, ReadImage(Path("clear.exr")).rgb);
  EXPECT_EQ(clean.layers[0].values, ReadLayeredImage(Path("clear.exr"), {"A"}).layers[0].values);
  EXPECT_TRUE(Bytes("clean.png") == Bytes("clear.png"));

  ASSERT_EQ(Run(clear + "--aovs denoiser --alpha straight -o divided.exr").exit_code, 0);
  ASSERT_EQ(Run("denoise divided.exr -q -o divided_clean.exr").exit_code, 0);
  const LayeredImage divided = ReadLayeredImage(Path("divided_clean.exr"), {"A"});
  for (std::size_t i = 0; i < divided.image.rgb.size(); ++i) {
    const float share = clean.layers[0].values[i / 3];
    ASSERT_EQ(divided.layers[0].values[i / 3], share);
    ASSERT_NEAR(divided.image.rgb[i] * (share > 0 ? share : 1), clean.image.rgb[i],
                1e-4 * (0.1 + clean.image.rgb[i]));
  }

  ASSERT_EQ(Run(picture + "--background map -o map.exr").exit_code, 0);
  EXPECT_FALSE(IsRgba(Path("map.exr")) || IsRgba(Path("map.png")));
  ASSERT_EQ(Run("render spheres --size 40x30 --spp 8 --tone filmic -q -o plain.exr").exit_code, 0);
  EXPECT_EQ(ReadImage(Path("map.exr")).rgb, ReadImage(Path("plain.exr")).rgb);
}

// The PNG is the picture of the EXR through the curve that is asked for.
TEST_F(Outputs, PngsHaveTheirToneCurve) {
  std::set<std::string> pngs;
  for (const auto& [curve, name] : kEnumNames<ToneCurve>) {
    const std::string tone(name);
    ASSERT_EQ(Run("render gallery --size 24x16 --spp 4 -q --exposure 1.5 --tone " + tone + " -o " +
                  tone + ".exr")
                  .exit_code,
              0);
    const Image picture = ReadImage(Path(tone + ".exr"));
    EXPECT_EQ(Bytes(tone + ".png"),
              EncodePng(24, 16, ToneMap(picture, {.exposure_stops = 1.5f, .curve = curve})))
        << tone;
    EXPECT_TRUE(pngs.insert(Bytes(tone + ".png")).second) << tone;
  }
  EXPECT_GE(pngs.size(), 4u);
}

// The ball is metered, and not the sky behind it; the layer that tells them apart is not written
// unless it is asked for.
TEST_F(Outputs, AutomaticExposureMetersWhatObjectsCover) {
  Put("ball.pbrt",
      "WorldBegin LightSource \"infinite\" \"rgb L\" [1 1 1]\n"
      "Material \"diffuse\" \"rgb reflectance\" [.1 .1 .1] Shape \"sphere\"");
  const std::string render = "render ball.pbrt --size 24x16 --spp 16 -q --exposure auto ";
  ASSERT_EQ(Run(render + "-o plain.exr").exit_code, 0);
  ASSERT_EQ(Run(render + "--aovs coverage -o layers.exr").exit_code, 0);
  EXPECT_TRUE(ReadLayerNames(Path("plain.exr")).empty());
  const LayeredImage picture = ReadLayeredImage(Path("layers.exr"), {"coverage.V"});
  const std::vector<float>& coverage = picture.layers[0].values;
  EXPECT_GT(std::count(coverage.begin(), coverage.end(), 1.0f), 20);
  EXPECT_GT(std::count(coverage.begin(), coverage.end(), 0.0f), 20);
  const float stops = AutomaticExposureStops(picture.image, coverage);
  EXPECT_NE(stops, AutomaticExposureStops(picture.image));
  for (const std::string name : {"plain", "layers"}) {
    EXPECT_EQ(Bytes(name + ".png"),
              EncodePng(24, 16, ToneMap(picture.image, {.exposure_stops = stops})))
        << name;
  }
}

TEST_F(Outputs, LinksAndPipesSurviveBeingWrittenTo) {
  std::filesystem::create_symlink("real.json", Path("link.json"));
  Put("real.json", "old");
  ASSERT_EQ(Run("render furnace --size 8x8 --spp 1 -q -o a.exr --stats link.json").exit_code, 0);
  EXPECT_TRUE(std::filesystem::is_symlink(Path("link.json")));
  EXPECT_EQ(Bytes("real.json").front(), '{');
  ASSERT_EQ(::mkfifo(Path("pipe").c_str(), 0600), 0);
  const Result read = Run("render furnace --size 8x8 --spp 1 -q -o b.exr --stats pipe & cat pipe");
  EXPECT_EQ(read.out.front(), '{') << read.out;
  EXPECT_TRUE(std::filesystem::is_fifo(Path("pipe")));
}

}  // namespace
}  // namespace skywave
