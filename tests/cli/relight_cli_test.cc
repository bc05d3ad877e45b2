// Tests skywave relight from the outside.
#include <gtest/gtest.h>

#include <string>
#include <tuple>
#include <vector>

#include "base/error.h"
#include "image/image.h"
#include "job/picture.h"
#include "tests/support/program.h"

namespace skywave {
namespace {

class RelightCli : public Program {
 protected:
  void SetUp() override {
    Program::SetUp();
    ASSERT_EQ(Run("render lamps --size 24x18 --spp 4 --aovs lights,crypto-object "
                  "--crop 16x12+3+4 --film lamps.film -q -o lamps.exr")
                  .exit_code,
              0);
    // The first layer names a lamp.
    const std::vector<std::string> names = ReadLayerNames(Path("lamps.exr"));
    for (const std::string& name : names) {
      const std::string layer = name.substr(0, name.rfind('.'));
      if (layer.starts_with("lights-") && layer != "lights-environment") {
        lamp_ = layer.substr(std::string("lights-").size());
      }
    }
    ASSERT_NE(lamp_, "");
  }

  std::string lamp_;
};

TEST_F(RelightCli, KeepsTheWorkingSpace) {
  ASSERT_EQ(Run("render lamps --size 12x9 --spp 4 --aovs lights --working-space acescg "
                "--film wide.film -q -o wide.exr")
                .exit_code,
            0);
  for (const std::string from : {"wide.exr", "wide.film"}) {
    ASSERT_EQ(Run("relight " + from + " -o same.exr -q").exit_code, 0);
    const LayeredImage same = ReadOwnColors(Path("same.exr"));
    EXPECT_EQ(same.space, RgbSpace::kAcescg);
    EXPECT_EQ(Bytes("same.png"), Bytes("wide.png"));
  }
}

TEST_F(RelightCli, GivesTheLightsOtherWeights) {
  ASSERT_EQ(Run("relight lamps.exr -o same.exr -q").exit_code, 0);
  EXPECT_EQ(Bytes("same.png"), Bytes("lamps.png"));
  ASSERT_EQ(Run("relight lamps.film --weights " + lamp_ + "=0/0/3 -o blue.exr -q").exit_code, 0);
  const LayeredImage before =
      ReadDataWindow(Path("lamps.exr"), {"lights-" + lamp_ + ".R", "lights-" + lamp_ + ".B"});
  const LayeredImage after = ReadDataWindow(Path("blue.exr"));
  EXPECT_EQ(after.placement.x, 3);
  EXPECT_EQ(after.placement.height, 18);
  for (std::size_t i = 0; i < before.layers[0].values.size(); ++i) {
    const float* const old = &before.image.rgb[3 * i];
    const float* const now = &after.image.rgb[3 * i];
    EXPECT_NEAR(now[0], old[0] - before.layers[0].values[i], 1e-5f * (1 + old[0]));
    EXPECT_NEAR(now[2], old[2] + 2 * before.layers[1].values[i], 1e-5f * (1 + old[2]));
  }
  // The header says what was done, and nothing of layers that are not there.
  bool told = false;
  for (const auto& [name, text] : ReadExrMetadata(Path("blue.exr"))) {
    told |= name == "lightWeights" && text == lamp_ + "=0/0/3";
    EXPECT_NE(name, "command");
    EXPECT_FALSE(name.starts_with("cryptomatte")) << name;
  }
  EXPECT_TRUE(told);
}

// The EXR says that its colours are divided by alpha, so they are multiplied first.
TEST_F(RelightCli, TakesPicturesWithStraightAlpha) {
  const std::string render =
      "render lamps --background transparent --aovs lights --size 40x30 --spp 4 -q ";
  ASSERT_EQ(Run(render + "-o plain.exr").exit_code, 0);
  ASSERT_EQ(Run(render + "--alpha straight -o divided.exr").exit_code, 0);
  for (const std::string name : {"plain", "divided"}) {
    const Result result =
        Run("relight " + name + ".exr --weights environment=0.5 -q -o " + name + "_lit.exr");
    ASSERT_EQ(result.exit_code, 0) << result.err;
  }
  const Image plain = ReadImage(Path("plain_lit.exr")),
              divided = ReadImage(Path("divided_lit.exr"));
  for (std::size_t i = 0; i < plain.rgb.size(); ++i) {
    ASSERT_NEAR(divided.rgb[i], plain.rgb[i], 1e-4 * (0.1 + plain.rgb[i]));
  }
  EXPECT_FALSE(IsStraight(ReadExrMetadata(Path("divided_lit.exr"))));
}

// By render and by denoise, from the EXR and from the film.
TEST_F(RelightCli, TakesPicturesThatWereDenoised) {
  const std::string render = "render lamps --size 40x30 --spp 16 -q ";
  ASSERT_EQ(Run(render + "--aovs lights --denoise --film clean.film -o clean.exr").exit_code, 0);
  ASSERT_EQ(Run(render + "--aovs lights,denoiser -o noisy.exr").exit_code, 0);
  ASSERT_EQ(Run("denoise noisy.exr -q -o later.exr").exit_code, 0);
  const std::string weights = " --weights " + lamp_ + "=0.25 -q -o ";
  const Image clean = ReadImage(Path("clean.exr"));
  for (const std::string from : {"clean.exr", "clean.film", "later.exr"}) {
    const Result same = Run("relight " + from + " -q -o same.exr");
    ASSERT_EQ(same.exit_code, 0) << from << same.err;
    const Image again = ReadImage(Path("same.exr"));
    for (std::size_t i = 0; i < clean.rgb.size(); ++i) {
      ASSERT_NEAR(again.rgb[i], clean.rgb[i], 1e-5 * (1 + clean.rgb[i])) << from;
    }
    ASSERT_EQ(Run("relight " + from + weights + "dim.exr").exit_code, 0);
    ASSERT_EQ(Run("relight noisy.exr" + weights + "noisy_dim.exr").exit_code, 0);
    double sum = 0, noisy_sum = 0;
    for (const float value : ReadImage(Path("dim.exr")).rgb) sum += value;
    for (const float value : ReadImage(Path("noisy_dim.exr")).rgb) noisy_sum += value;
    EXPECT_NEAR(sum / noisy_sum, 1, 0.05) << from;
  }
}

// Layers that nothing has cleaned are not in a clean picture.
TEST_F(RelightCli, RefusesCleanPicturesWithCatchers) {
  const std::string render = "render spheres --catcher floor --size 40x30 --spp 16 -q ";
  ASSERT_EQ(Run(render + "--aovs lights,denoiser -o noisy.exr").exit_code, 0);
  ASSERT_EQ(Run("denoise noisy.exr -q -o clean.exr").exit_code, 0);
  const Result result = Run("relight clean.exr -q -o x.exr");
  EXPECT_EQ(result.exit_code, kExitBadInput);
  EXPECT_NE(result.err.find("has no groups of lights"), std::string::npos) << result.err;
}

TEST_F(RelightCli, MakesAPictureOfEachRowOfATable) {
  Put("day.csv", lamp_ + "\n1\n0.5\n0\n");
  ASSERT_EQ(Run("relight lamps.exr --sky day.csv -o hour_##.exr -q").exit_code, 0);
  ASSERT_EQ(Run("relight lamps.exr --weights " + lamp_ + "=0.5 -o half.exr -q").exit_code, 0);
  EXPECT_EQ(Bytes("hour_00.png"), Bytes("lamps.png"));
  EXPECT_EQ(Bytes("hour_01.png"), Bytes("half.png"));
  EXPECT_TRUE(Files().contains("hour_02.exr"));
  EXPECT_FALSE(Files().contains("hour_03.exr"));
}

// More than are made at the same time.
TEST_F(RelightCli, MakesPicturesOfLongTablesInTheirOrder) {
  Put("day.csv", lamp_ + "\n1\n1\n1\n1\n1\n1\n1\n1\n1\n0.5\n");
  const Result result = Run("relight lamps.exr --sky day.csv -o hour_##.exr --progress json");
  ASSERT_EQ(result.exit_code, 0);
  EXPECT_NE(result.err.find("\"share\":1.0"), std::string::npos) << result.err;
  ASSERT_EQ(Run("relight lamps.exr --weights " + lamp_ + "=0.5 -o half.exr -q").exit_code, 0);
  EXPECT_EQ(Bytes("hour_08.png"), Bytes("lamps.png"));
  EXPECT_EQ(Bytes("hour_09.png"), Bytes("half.png"));
  EXPECT_FALSE(Files().contains("hour_10.exr"));
}

TEST_F(RelightCli, RefusesWhatItCannotDoAndWritesNothing) {
  Put("day.csv", "nobody\n1\n");
  Put("torn.csv", lamp_ + "\n1\nx\n");
  for (const auto& [arguments, exit_code, word] :
       {std::tuple("lamps.exr --weights nobody=2 -o x.exr", kExitUsage, "nobody"),
        {"lamps.exr --sky day.csv -o x_#.exr", kExitUsage, "nobody"},
        {"lamps.exr --sky torn.csv -o x_#.exr", kExitBadInput, "torn.csv:3"},
        {"lamps.exr --sky day.csv -o x.exr", kExitUsage, "#"},
        {"lamps.exr --weights a -o x.exr", kExitUsage, "NAME=WEIGHT"},
        {"lamps.exr -o x.png", kExitUsage, ".exr"},
        {"lamps.exr -o lamps.exr", kExitUsage, "lamps.exr"},
        {"lamps.png -o x.exr", kExitBadInput, "lamps.png"},
        {"none.film -o x.exr", kExitIo, "none.film"}}) {
    const Result result = Run(std::string("relight ") + arguments);
    EXPECT_EQ(result.exit_code, exit_code) << arguments << " " << result.err;
    EXPECT_NE(result.err.find(word), std::string::npos) << result.err;
    EXPECT_FALSE(Files().contains("x.exr") || Files().contains("x_0.exr")) << arguments;
  }
}

}  // namespace
}  // namespace skywave
