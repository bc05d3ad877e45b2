// Tests the denoiser from the outside: two commands and one, batches, refusals.
#include <gtest/gtest.h>

#include <string>

#include "base/error.h"
#include "image/image.h"
#include "tests/support/program.h"

namespace skywave {
namespace {

constexpr char kRender[] = "render spheres --size 32x24 --spp 16 -q ";

std::string ValueOf(const Metadata& metadata, const std::string& name) {
  for (const auto& [key, text] : metadata) {
    if (key == name) return text;
  }
  return "";
}

class DenoiseProgram : public Program {
 protected:
  void Make(const std::string& arguments) {
    const Result result = Run(arguments);
    ASSERT_EQ(result.exit_code, 0) << arguments << ": " << result.err;
  }
  void ExpectRefused(const std::string& arguments, int exit_code, const std::string& words) {
    const std::set<std::string> before = Files();
    const Result result = Run(arguments);
    EXPECT_EQ(result.exit_code, exit_code) << arguments;
    EXPECT_NE(result.err.find(words), std::string::npos) << result.err;
    EXPECT_EQ(Files(), before);
  }
};

TEST_F(DenoiseProgram, RenderThenDenoiseEqualsOneCommand) {
  Make(kRender + std::string("--denoise -o one.exr"));
  Make(kRender + std::string("--aovs denoiser -o noisy.exr"));
  Make("denoise noisy.exr -q -o two.exr");
  const Image clean = ReadImage(Path("one.exr")), noisy = ReadImage(Path("noisy.exr"));
  EXPECT_EQ(ReadImage(Path("two.exr")).rgb, clean.rgb);
  EXPECT_EQ(Bytes("two.png"), Bytes("one.png"));
  EXPECT_NE(clean.rgb, noisy.rgb);
  EXPECT_EQ(ReadLayeredImage(Path("one.exr"), {"error.G"}).layers[0].values,
            ReadLayeredImage(Path("two.exr"), {"error.G"}).layers[0].values);
  // It is kept only with the layers that it was cleaned by.
  EXPECT_THROW(ReadLayeredImage(Path("one.exr"), {"noisy.G"}), InputError);
  Make(kRender + std::string("--denoise --aovs denoiser -o both.exr"));
  EXPECT_EQ(ReadImage(Path("both.exr")).rgb, clean.rgb);
  const LayeredImage both = ReadLayeredImage(Path("both.exr"), {"noisy.G"});
  for (std::size_t i = 0; i < both.layers[0].values.size(); ++i) {
    ASSERT_EQ(both.layers[0].values[i], noisy.rgb[3 * i + 1]);
  }
  // The command of the noisy picture does not make the clean one.
  const Metadata metadata = ReadExrMetadata(Path("two.exr"));
  EXPECT_EQ(ValueOf(metadata, "command"), "");
  EXPECT_EQ(ValueOf(metadata, "noisyCommand"),
            ValueOf(ReadExrMetadata(Path("noisy.exr")), "command"));
}

TEST_F(DenoiseProgram, KeepsTheWorkingSpace) {
  const std::string wide = kRender + std::string("--working-space acescg ");
  Make(wide + "--denoise -o one.exr");
  Make(wide + "--aovs denoiser -o noisy.exr");
  Make("denoise noisy.exr -q -o two.exr");
  const LayeredImage one = ReadOwnColors(Path("one.exr")), two = ReadOwnColors(Path("two.exr"));
  EXPECT_EQ(one.space, RgbSpace::kAcescg);
  EXPECT_EQ(two.space, one.space);
  EXPECT_EQ(two.image.rgb, one.image.rgb);
  EXPECT_EQ(Bytes("two.png"), Bytes("one.png"));
}

// The same for pictures with catchers, whose parts are cleaned one by one.
TEST_F(DenoiseProgram, CatchersAreCleanedByOneCommandAndByTwo) {
  for (const std::string background : {"transparent", "map"}) {
    const std::string render = kRender + ("--catcher floor --background " + background);
    Make(render + " --denoise -o one.exr");
    Make(render + " --aovs denoiser -o noisy.exr");
    Make("denoise noisy.exr -q -o two.exr");
    EXPECT_EQ(Bytes("two.png"), Bytes("one.png")) << background;
    std::vector<std::string> names = {"shadow.R", "difference.G", "error.B"};
    names.push_back(background == "map" ? "alpha.A" : "A");
    const LayeredImage one = ReadLayeredImage(Path("one.exr"), names);
    const LayeredImage two = ReadLayeredImage(Path("two.exr"), names);
    const LayeredImage noisy = ReadLayeredImage(Path("noisy.exr"), {names[0], names[1]});
    EXPECT_EQ(two.image.rgb, one.image.rgb);
    for (std::size_t k = 0; k < names.size(); ++k) {
      EXPECT_EQ(two.layers[k].values, one.layers[k].values) << names[k];
    }
    for (std::size_t k = 0; k < noisy.layers.size(); ++k) {
      EXPECT_NE(noisy.layers[k].values, one.layers[k].values) << names[k];
    }
  }
  ExpectRefused("denoise noisy.exr one.exr --steady 1 -o b", kExitUsage, "shows catchers");
}

// A noisy picture that was exposed automatically leads to a clean one that is, too.
TEST_F(DenoiseProgram, ExposureIsAutomaticWhereThatOfTheNoisyPictureWas) {
  Make(kRender + std::string("--denoise --exposure auto -o one.exr"));
  Make(kRender + std::string("--denoise -o plain.exr"));
  Make(kRender + std::string("--aovs denoiser --exposure auto -o noisy.exr"));
  Make("denoise noisy.exr -q -o two.exr");
  EXPECT_EQ(Bytes("two.png"), Bytes("one.png"));
  EXPECT_NE(Bytes("two.png"), Bytes("plain.png"));
  Make("denoise noisy.exr --exposure 0 -q -o two.exr");
  EXPECT_EQ(Bytes("two.png"), Bytes("plain.png"));
}

TEST_F(DenoiseProgram, ThreadsDoNotChangeABatchOrABlockThatEndsEarly) {
  Make(kRender + std::string("--denoise --threads 1 --adaptive 0.4 --adaptive-min 8 -o one.exr"));
  Make(kRender + std::string("--denoise --threads 2 --adaptive 0.4 --adaptive-min 8 -o two.exr"));
  EXPECT_EQ(Bytes("one.exr"), Bytes("two.exr"));
  Put("job.toml",
      "[base]\nscene = \"spheres\"\nsize = \"32x24\"\nspp = 16\ndenoise = true\n"
      "[axes]\nseed = \"0-1\"\n[output]\npath = \"{seed}.exr\"\n");
  Make("batch job.toml -q");
  Make(kRender + std::string("--denoise -o alone.exr"));
  EXPECT_EQ(ReadImage(Path("0.exr")).rgb, ReadImage(Path("alone.exr")).rgb);
}

// Several pictures become files of the same names in a folder, each by itself unless the frames
// steady each other.
TEST_F(DenoiseProgram, SeveralPicturesAreCleanedIntoAFolder) {
  for (const std::string frame : {"1", "2", "3"}) {
    Make(kRender + std::string("--aovs denoiser --frame ") + frame + " -o f" + frame + ".exr");
  }
  Make("denoise f1.exr f2.exr f3.exr -q -o clean");
  Make("denoise f2.exr -q -o one.exr");
  Make("denoise f2.exr -q -o alone/");
  EXPECT_EQ(Bytes("alone/f2.exr"), Bytes("one.exr"));
  EXPECT_EQ(Bytes("clean/f2.exr"), Bytes("one.exr"));
  EXPECT_EQ(Bytes("clean/f2.png"), Bytes("one.png"));
  EXPECT_EQ(ValueOf(ReadExrMetadata(Path("one.exr")), "steady"), "");

  const Result steady = Run("denoise f1.exr f2.exr f3.exr --steady 1 --threads 1 -o steady");
  EXPECT_EQ(steady.exit_code, 0);
  EXPECT_NE(steady.err.find("no layers flow and flow-back"), std::string::npos) << steady.err;
  EXPECT_EQ(steady.err.find("flicker"), std::string::npos) << steady.err;
  const Result automatic = Run("denoise f1.exr f2.exr --steady 1 --exposure auto -o automatic");
  EXPECT_NE(automatic.err.find("give --exposure a number"), std::string::npos) << automatic.err;
  Make("denoise f1.exr f2.exr f3.exr --steady 1 --threads 2 -q -o again/");
  EXPECT_EQ(Bytes("steady/f2.exr"), Bytes("again/f2.exr"));
  EXPECT_EQ(ValueOf(ReadExrMetadata(Path("steady/f2.exr")), "steady"), "1");
  EXPECT_NE(ReadImage(Path("steady/f2.exr")).rgb, ReadImage(Path("one.exr")).rgb);
  // The third frame is not beside the first one.
  Make("denoise f1.exr f2.exr --steady 1 -q -o two");
  EXPECT_EQ(Bytes("steady/f1.exr"), Bytes("two/f1.exr"));
  EXPECT_NE(Bytes("steady/f2.exr"), Bytes("two/f2.exr"));
  Make("denoise f2.exr f3.exr --steady 1 -q -o two");
  EXPECT_EQ(Bytes("steady/f3.exr"), Bytes("two/f3.exr"));
}

TEST_F(DenoiseProgram, FramesThatCannotSteadyEachOtherAreRefused) {
  Make(kRender + std::string("--aovs denoiser -o a.exr"));
  Make("render spheres --size 16x12 --spp 16 -q --aovs denoiser -o small.exr");
  Put("a.txt", "");
  ExpectRefused("denoise a.exr small.exr -o b.exr", kExitUsage, "need a folder");
  ExpectRefused("denoise a.exr ./a.exr -o b", kExitUsage, "two of the pictures are called a.exr");
  ExpectRefused("denoise a.exr a.txt -o b", kExitUsage, "a.txt: is not an EXR file");
  ExpectRefused("denoise a.exr --steady 1 -o b.exr", kExitUsage, "has no frames around it");
  ExpectRefused("denoise a.exr small.exr --steady 1 --by best -o b", kExitUsage,
                "steadied by statistics only");
  Make(kRender + std::string("-o plain.exr"));
  ExpectRefused("denoise a.exr plain.exr -o b", kExitBadInput, "plain.exr: has no channel");
  const Result small = Run("denoise a.exr small.exr --steady 1 -o b");
  EXPECT_EQ(small.exit_code, kExitBadInput);
  EXPECT_NE(small.err.find("small.exr: has 16x12 pixels"), std::string::npos) << small.err;
}

TEST_F(DenoiseProgram, UnusableInputsAndOutputsAreRefused) {
  Make(kRender + std::string("--denoise --aovs denoiser -o clean.exr"));
  Make(kRender + std::string("--aovs albedo -o albedo.exr"));
  Make(kRender + std::string("--aovs denoiser --sample-range 8:12 -o half.exr"));
  Make(kRender + std::string("--aovs denoiser -o noisy.exr"));
  ExpectRefused("denoise clean.exr -o a.exr", kExitBadInput, "was denoised already");
  ExpectRefused("denoise albedo.exr -o a.exr", kExitBadInput, "has no channel shading-normal.X");
  ExpectRefused("denoise half.exr -o a.exr", kExitBadInput, "of them in one half");
  ExpectRefused("denoise nothing.exr -o a.exr", kExitIo, "nothing.exr");
  ExpectRefused("denoise noisy.exr -o a.png", kExitUsage, "has to end in .exr");
  ExpectRefused("denoise noisy.exr -o no/such/folder.exr", kExitIo, "no/such");
  const std::string before = Bytes("noisy.exr");
  ExpectRefused("denoise noisy.exr -o noisy.exr", kExitUsage, "noisy.exr");
  EXPECT_EQ(Bytes("noisy.exr"), before);
  ExpectRefused("render spheres --size 8x6 --spp 3 --denoise -o a.exr", kExitUsage,
                "--spp 4 or more");
  ExpectRefused("render spheres --size 8x6 --spp 8 --denoise --integrator bdpt -o a.exr",
                kExitUsage, "--integrator bdpt");
  ExpectRefused("render spheres --size 8x6 --spp 8 --denoise --max-depth 0 -o a.exr", kExitUsage,
                "--max-depth 0");
  ExpectRefused("render spheres --size 8x6 --spp 8 --aovs half --integrator bdpt -o a.exr",
                kExitUsage, "halves");
}

// The picture of a film that forgets its rows has 12 bytes a pixel, 76 more for the layers of the
// denoiser and 12 more for texture coordinates, whose film has 8 bytes a pixel from the start.
TEST_F(DenoiseProgram, LayersThatNeedTooMuchMemoryAreRefused) {
  struct Case {
    const char *kib, *options;
    int exit_code;
  };
  for (const Case& c :
       {Case{"64", "", 0}, Case{"64", "--denoise", kExitBadInput}, Case{"368", "--denoise", 0},
        Case{"112", "--aovs uv", kExitBadInput}, Case{"144", "--aovs uv", 0},
        Case{"144", "--aovs uv --checkpoint 60", kExitBadInput}}) {
    const Result result =
        Shell(std::string("CUE_MEMORY=") + c.kib + " '" + ProgramPath() +
              "' render spheres --size 64x64 --spp 8 --max-depth 2 -o a.exr " + c.options);
    EXPECT_EQ(result.exit_code, c.exit_code) << c.kib << " " << c.options << "\n" << result.err;
    const bool tells = result.err.find("CUE_MEMORY") != std::string::npos;
    EXPECT_EQ(tells, c.exit_code != 0) << result.err;
  }
}

// A film of too few samples for a denoiser keeps what it reads all the same.
TEST_F(DenoiseProgram, ASnapshotOfTooFewSamplesStaysNoisy) {
  const Result result =
      Run("render spheres --size 32x24 --spp 16 --sample-range 0:2 --denoise -o a.exr");
  EXPECT_EQ(result.exit_code, 0);
  EXPECT_NE(result.err.find("not denoised"), std::string::npos) << result.err;
  Make(kRender + std::string("--sample-range 0:2 -o b.exr"));
  EXPECT_EQ(ReadImage(Path("a.exr")).rgb, ReadImage(Path("b.exr")).rgb);
}

}  // namespace
}  // namespace skywave
