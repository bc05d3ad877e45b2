// Tests Open Image Denoise from the outside, by a library that stands in for it: it is found or
// not, works or fails, and the picture says that it took part.
#include <gtest/gtest.h>

#include <cstdlib>
#include <filesystem>
#include <set>
#include <string>

#include "base/error.h"
#include "image/image.h"
#include "job/denoise/denoise.h"
#include "tests/support/program.h"

namespace skywave {
namespace {

constexpr char kRender[] = "render spheres --size 32x24 --spp 16 -q ";

class OidnProgram : public Program {
 protected:
  void SetUp() override {
    Program::SetUp();
    setenv("SKYWAVE_OIDN", SKYWAVE_STAND_IN_OIDN, 1);
    unsetenv("OIDN_STAND_IN");
  }
  void Make(const std::string& arguments) {
    const Result result = Run(arguments);
    ASSERT_EQ(result.exit_code, 0) << arguments << ": " << result.err;
  }
  void ExpectRefused(const std::string& arguments, const std::string& words) {
    const std::set<std::string> before = Files();
    const Result result = Run(arguments);
    EXPECT_NE(result.exit_code, 0) << arguments;
    EXPECT_NE(result.err.find(words), std::string::npos) << result.err;
    EXPECT_EQ(Files(), before);
  }
  std::string Attribute(const std::string& file, const std::string& name) {
    for (const auto& [key, text] : ReadExrMetadata(Path(file))) {
      if (key == name) return text;
    }
    return "";
  }
};

TEST_F(OidnProgram, MakesTheSamePictureInOneCommandInTwoAndFromFilms) {
  for (const std::string by : {"oidn", "quick", "best"}) {
    Make(kRender + ("--denoise " + by) + " -o one.exr");
    Make(kRender + std::string("--aovs denoiser -o noisy.exr"));
    Make("denoise noisy.exr --by " + by + " -q -o two.exr");
    Make(kRender + ("--denoise=" + by) + " --sample-range 0:8 --film a.film");
    Make(kRender + ("--denoise " + by) + " --sample-range 8:16 --film b.film");
    Make("merge a.film b.film -q -o merged.exr");
    const Image clean = ReadImage(Path("one.exr"));
    EXPECT_NE(clean.rgb, ReadImage(Path("noisy.exr")).rgb);
    EXPECT_EQ(ReadImage(Path("two.exr")).rgb, clean.rgb);
    EXPECT_EQ(Bytes("merged.exr"), Bytes("one.exr"));
    EXPECT_EQ(Attribute("one.exr", "openImageDenoise"), "2.98.3");
    EXPECT_EQ(Attribute("two.exr", "openImageDenoise"), "2.98.3");
    EXPECT_NE(Attribute("one.exr", "command").find("--denoise " + by), std::string::npos);
  }
}

TEST_F(OidnProgram, IsPartOfAutoWhereItIsThere) {
  Make(kRender + std::string("--denoise best -o best.exr"));
  Make(kRender + std::string("--denoise auto -o auto.exr"));
  EXPECT_EQ(Bytes("auto.exr"), Bytes("best.exr"));
  Make(kRender + std::string("--denoise -o statistics.exr"));
  setenv("SKYWAVE_OIDN", "/nowhere", 1);
  const Result alone = Run("render spheres --size 32x24 --spp 16 --denoise auto -o alone.exr");
  EXPECT_EQ(alone.exit_code, 0) << alone.err;
  EXPECT_NE(alone.err.find("pip install pyoidn"), std::string::npos) << alone.err;
  EXPECT_EQ(Bytes("alone.exr"), Bytes("statistics.exr"));
  EXPECT_EQ(Attribute("alone.exr", "openImageDenoise"), "");
}

// A folder that has the library, in it or in its folder lib, will do.
TEST_F(OidnProgram, IsFoundInAFolder) {
  std::filesystem::create_directories(Path("there/lib"));
  std::filesystem::copy_file(SKYWAVE_STAND_IN_OIDN, Path("there/lib/libOpenImageDenoise.so.2"));
  setenv("SKYWAVE_OIDN", Path("there").c_str(), 1);
  Make(kRender + std::string("--denoise oidn -o there.exr"));
  std::filesystem::create_directories(Path("venv/lib/python3.11/site-packages/pyoidn/oidn/lib"));
  std::filesystem::copy_file(
      SKYWAVE_STAND_IN_OIDN,
      Path("venv/lib/python3.11/site-packages/pyoidn/oidn/lib/libOpenImageDenoise.so.2"));
  unsetenv("SKYWAVE_OIDN");
  setenv("VIRTUAL_ENV", Path("venv").c_str(), 1);
  Make(kRender + std::string("--denoise oidn -o package.exr"));
  unsetenv("VIRTUAL_ENV");
  EXPECT_EQ(Bytes("package.exr"), Bytes("there.exr"));
}

TEST_F(OidnProgram, SaysWhatIsWrongBeforeTheFirstRay) {
  const std::string oidn = kRender + std::string("--denoise oidn -o clean.exr");
  setenv("SKYWAVE_OIDN", "/nowhere/lib.so", 1);
  // This process has looked for none yet.
  EXPECT_THROW(ResolveDenoiser(Denoiser::kOidn), OptionError);
  EXPECT_THROW(ResolveDenoiser(Denoiser::kQuick), OptionError);
  EXPECT_THROW(ResolveDenoiser(Denoiser::kBest), OptionError);
  EXPECT_EQ(ResolveDenoiser(Denoiser::kAuto), Denoiser::kStatistics);
  ExpectRefused(oidn, "/nowhere/lib.so");
  ExpectRefused(oidn, "pip install pyoidn");
  ExpectRefused(kRender + std::string("--denoise best -o clean.exr"), "pip install pyoidn");
  setenv("SKYWAVE_OIDN", SKYWAVE_STAND_IN_OIDN, 1);
  setenv("OIDN_STAND_IN", "lame", 1);
  ExpectRefused(oidn, "the stand-in is lame");
  unsetenv("OIDN_STAND_IN");
  // A library that is another one.
  setenv("SKYWAVE_OIDN", "libm.so.6", 1);
  ExpectRefused(oidn, "is no Open Image Denoise");
  ExpectRefused(kRender + std::string("--denoise odin -o clean.exr"), "odin");
  ExpectRefused("denoise noisy.exr --by none -o clean.exr", "statistics|oidn|quick|best|auto");
}

// The rays have been traced when the network fails.
TEST_F(OidnProgram, LeavesRendersTheirNoisyPictureWhereItFails) {
  Make(kRender + std::string("--denoise -o statistics.exr"));
  Make(kRender + std::string("-o noisy.exr --aovs denoiser"));
  setenv("OIDN_STAND_IN", "fails", 1);
  for (const std::string by : {"oidn", "best"}) {
    const Result failed =
        Run("render spheres --size 32x24 --spp 16 --denoise " + by + " -o " + by + ".exr");
    EXPECT_EQ(failed.exit_code, 0) << failed.err;
    EXPECT_NE(failed.err.find("not denoised: Open Image Denoise 2"), std::string::npos)
        << failed.err;
    EXPECT_NE(failed.err.find("the stand-in fails"), std::string::npos) << failed.err;
    EXPECT_EQ(ReadImage(Path(by + ".exr")).rgb, ReadImage(Path("noisy.exr")).rgb);
    ExpectRefused("denoise noisy.exr --by " + by + " -o clean.exr", "the stand-in fails");
    EXPECT_FALSE(std::filesystem::exists(Path("clean.exr")));
  }
  unsetenv("OIDN_STAND_IN");
}

}  // namespace
}  // namespace skywave
