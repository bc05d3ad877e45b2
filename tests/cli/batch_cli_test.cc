// Tests skywave batch from the outside: pictures, files, exit codes, messages.
#include <gtest/gtest.h>

#include <nlohmann/json.hpp>
#include <set>
#include <sstream>
#include <string>

#include "base/error.h"
#include "image/formats.h"
#include "image/image.h"
#include "tests/support/camera_text.h"
#include "tests/support/gltf_document.h"
#include "tests/support/program.h"

namespace skywave {
namespace {

using Json = nlohmann::json;
using Names = std::set<std::string>;

bool Contains(const std::string& text, const std::string& part) {
  return text.find(part) != std::string::npos;
}

constexpr char kJob[] =
    "[base]\nscene = \"spheres\"\nsize = \"8x6\"\nspp = 1\n"
    "[axes]\nseed = \"1-3\"\n"
    "[output]\npath = \"out/{scene}_{seed:02}.exr\"\n";

class Batch : public Program {
 protected:
  Names FilesIn(const std::string& folder) const {
    Names names;
    for (const auto& entry : std::filesystem::directory_iterator(Path(folder))) {
      names.insert(entry.path().filename().string());
    }
    return names;
  }
};

TEST_F(Batch, PicturesEqualSingleRendersAndNoOtherFileIsMade) {
  Put("job.toml", kJob);
  const Result result = Run("batch job.toml");
  EXPECT_EQ(result.exit_code, 0) << result.err;
  EXPECT_TRUE(Contains(result.out, "out/spheres_02.exr  rendered")) << result.out;
  EXPECT_EQ(FilesIn("out"),
            (Names{"job.batch.html", "job.batch.json", "spheres_01.exr", "spheres_01.png",
                   "spheres_02.exr", "spheres_02.png", "spheres_03.exr", "spheres_03.png"}));
  EXPECT_EQ(Run("render spheres --size 8x6 --spp 1 --seed 2 -q -o alone.exr").exit_code, 0);
  EXPECT_EQ(ReadImage(Path("out/spheres_02.exr")).rgb, ReadImage(Path("alone.exr")).rgb);
  EXPECT_EQ(Bytes("out/spheres_02.png"), Bytes("alone.png"));
  const Json summary = Json::parse(Bytes("out/job.batch.json"));
  EXPECT_EQ(summary["rendered"], 3);
  EXPECT_EQ(summary["pictures"][2]["output"], "spheres_03.exr");
}

TEST_F(Batch, NamesMayHaveAsManyBytesAsFileSystemsTake) {
  const std::string longest = std::string(251, 'n') + ".exr";
  const std::string base = "[base]\nscene = \"spheres\"\nsize = \"8x6\"\nspp = 1\n";
  Put("job.toml", base + "[output]\npath = \"out/" + longest + "\"\n");
  const Result result = Run("batch job.toml");
  EXPECT_EQ(result.exit_code, 0) << result.err;
  EXPECT_EQ(FilesIn("out"),
            (Names{"job.batch.html", "job.batch.json", longest, std::string(251, 'n') + ".png"}));
  Put("job.toml", base + "[output]\npath = \"out/n" + longest + "\"\n");
  const Result longer = Run("batch job.toml");
  EXPECT_NE(longer.exit_code, 0);
  EXPECT_TRUE(Contains(longer.err, "File name too long")) << longer.err;
}

TEST_F(Batch, ASecondRunSkipsFinishedPicturesAndKeepsTheirTimes) {
  Put("job.toml", kJob);
  EXPECT_EQ(Run("batch job.toml -q").exit_code, 0);
  const Json first = Json::parse(Bytes("out/job.batch.json"));
  const std::string bytes = Bytes("out/spheres_03.exr");
  std::filesystem::remove(Path("out/spheres_02.exr"));
  EXPECT_EQ(Run("batch job.toml -q").exit_code, 0);
  const Json second = Json::parse(Bytes("out/job.batch.json"));
  EXPECT_EQ(second["skipped"], 2);
  EXPECT_EQ(second["rendered"], 1);
  for (std::size_t i = 0; i < 3; ++i) {
    EXPECT_EQ(second["pictures"][i]["hash"], first["pictures"][i]["hash"]) << i;
  }
  EXPECT_EQ(second["pictures"][2]["seconds"], first["pictures"][2]["seconds"]);
  EXPECT_EQ(second["samples"], 3 * 48);

  EXPECT_EQ(Run("batch job.toml -q --force").exit_code, 0);
  EXPECT_EQ(Json::parse(Bytes("out/job.batch.json"))["rendered"], 3);
  EXPECT_EQ(Bytes("out/spheres_03.exr"), bytes);
}

TEST_F(Batch, ListingMakesNoFile) {
  Put("job.toml", kJob);
  const Json list = Json::parse(Run("batch job.toml --list --json --only 2/2").out);
  ASSERT_EQ(list["pictures"].size(), 1u);
  EXPECT_EQ(list["pictures"][0]["index"], 1);
  EXPECT_EQ(list["pictures"][0]["options"]["seed"], "2");
  EXPECT_TRUE(Contains(Run("batch job.toml --list").out, "2        out/spheres_03.exr  3"));
  EXPECT_TRUE(Contains(Run("batch job.toml --dry-run").out, "3 pictures, 0.000144 Msamples"));
  EXPECT_EQ(Files(), Names{"job.toml"});
}

TEST_F(Batch, ADryRunCountsTheSamplesOfAPart) {
  Put("job.toml",
      "[base]\nscene = \"spheres\"\nsize = \"8x6\"\nspp = 4\nsample-range = \"1:3\"\n"
      "[axes]\nseed = \"1-3\"\n[output]\npath = \"{seed}.exr\"\n");
  // Three pictures of 8 x 6 pixels have two of four samples each.
  const Result result = Run("batch job.toml --dry-run");
  EXPECT_TRUE(Contains(result.out, "3 pictures, 0.000288 Msamples")) << result.out << result.err;
}

// The table adds up what the summary has of each picture. Large ones take their time to be written.
TEST_F(Batch, TheTableHasTheTimesAndRatesOfTheSummary) {
  std::string job = kJob;
  Put("job.toml", job.replace(job.find("8x6"), 3, "400x300"));
  std::istringstream table(Run("batch job.toml").out);
  std::string line;
  ASSERT_TRUE(std::getline(table, line) && Contains(line, "time [s]")) << line;
  const Json summary = Json::parse(Bytes("out/job.batch.json"));
  ASSERT_EQ(summary.at("pictures").size(), 3u);
  for (const Json& picture : summary.at("pictures")) {
    std::string output, status;
    double seconds = 0, rate = 0, sum = 0;
    table >> output >> status >> seconds >> rate;
    for (const Json& part : picture.at("seconds")) sum += part.get<double>();
    EXPECT_EQ(output, "out/" + picture.at("output").get<std::string>());
    EXPECT_NEAR(seconds, sum, 0.0006);
    const double expected = 400 * 300e-6 / picture.at("seconds").at("render").get<double>();
    EXPECT_NEAR(rate, expected, 0.0006);
    std::getline(table, line);
  }
}

// The format of a picture and the limits under which it ends are those of the job.
TEST_F(Batch, FormatsAndLimitsAreThoseOfTheJob) {
  const auto batch = [&](const std::string& options) {
    Put("job.toml", "[base]\nscene = \"spheres\"\nsize = \"8x6\"\nspp = 64\n" + options +
                        "[output]\npath = \"a.exr\"\n");
    const Result result = Run("batch job.toml -q");
    EXPECT_EQ(result.exit_code, 0) << result.err;
    return Json::parse(Bytes("job.batch.json"));
  };
  batch("half = true\n");
  const std::string half = Bytes("a.exr");
  EXPECT_EQ(Run("render spheres --size 8x6 --spp 64 --half -q -o alone.exr").exit_code, 0);
  EXPECT_EQ(half, Bytes("alone.exr"));
  // Under a limit that is never reached the picture has the same samples, and is another one.
  EXPECT_EQ(batch("noise = 1e-9\n")["rendered"], 1);
  EXPECT_EQ(batch("noise = 1e-9\n")["skipped"], 1);
  EXPECT_EQ(batch("noise = 1e-8\n")["rendered"], 1);
}

// A scene names files that the job does not.
TEST_F(Batch, NoPictureReplacesAnInputOfAnEarlierOne) {
  WriteExr(Path("map_2.exr"), Image(4, 2));
  const std::string before = Bytes("map_2.exr");
  Put("sky.pbrt",
      "WorldBegin LightSource \"infinite\" \"string filename\" \"map_2.exr\" Shape \"sphere\"");
  Put("job.toml",
      "[base]\nscene = \"sky.pbrt\"\nsize = \"8x6\"\nspp = 1\n[axes]\nseed = \"1-3\"\n"
      "[output]\npath = \"map_{seed}.exr\"\n");
  const Result result = Run("batch job.toml");
  EXPECT_NE(result.exit_code, 0);
  EXPECT_TRUE(Contains(result.out + result.err, "map_2.exr: is an input"))
      << result.out << result.err;
  EXPECT_EQ(Bytes("map_2.exr"), before);
  EXPECT_FALSE(std::filesystem::exists(Path("map_2.png")));
  EXPECT_TRUE(std::filesystem::exists(Path("map_3.exr")));
}

// A photograph and its camera are named relative to the job file, as maps are, and are inputs.
TEST_F(Batch, FilesOfOptionsAreBesideTheJob) {
  std::filesystem::create_directory(Path("job"));
  WritePng(Path("job/photo.png"), 8, 6, std::vector<std::uint8_t>(8 * 6 * 3, 90));
  Put("job/camera.json", test::kCameraFile);
  const std::string job =
      "[base]\nscene = \"spheres\"\nspp = 1\nbackplate = \"photo.png\"\n"
      "camera-from = \"camera.json\"\n[axes]\nseed = \"1-1\"\n[output]\npath = ";
  Put("job/job.toml", job + "\"{seed}.exr\"\n");
  const Result result = Run("batch job/job.toml -q");
  ASSERT_EQ(result.exit_code, 0) << result.out << result.err;
  EXPECT_EQ(ReadImage(Path("job/1.exr")).width, 32) << "the size of the camera's photograph";
  Put("job/job.toml", job + "\"photo{seed}.exr\"\n");
  std::filesystem::rename(Path("job/photo.png"), Path("job/photo1.png"));
  std::string text = Bytes("job/job.toml");
  Put("job/job.toml", text.replace(text.find("photo.png"), 9, "photo1.png"));
  const Result over = Run("batch job/job.toml");
  EXPECT_NE(over.exit_code, 0);
  EXPECT_TRUE(Contains(over.out + over.err, "is an input")) << over.out << over.err;
}

TEST_F(Batch, WritesBelowTheRequestedFolder) {
  Put("job.toml", kJob);
  EXPECT_EQ(Run("batch job.toml -q -o else --only 1/2").exit_code, 0);
  EXPECT_EQ(FilesIn("else/out"),
            (Names{"job.batch.1of2.html", "job.batch.1of2.json", "spheres_01.exr", "spheres_01.png",
                   "spheres_03.exr", "spheres_03.png"}));
}

TEST_F(Batch, AFailedPictureIsReportedAndTheOthersAreRendered) {
  Put("bad.hdr", "no map");
  Image map(8, 4);
  std::fill(map.rgb.begin(), map.rgb.end(), 1.0f);
  WritePfm(Path("good.pfm"), map);
  Put("job.toml",
      "[base]\nscene = \"spheres\"\nsize = \"8x6\"\nspp = 1\n"
      "[axes]\nenv = [\"bad.hdr\", \"good.pfm\"]\n[output]\npath = \"{env}.exr\"\n");
  const Result checked = Run("batch job.toml --dry-run");
  EXPECT_EQ(checked.exit_code, kExitBadInput);
  EXPECT_TRUE(Contains(checked.err, "bad.hdr")) << checked.err;
  const Result result = Run("batch job.toml");
  EXPECT_EQ(result.exit_code, kExitBadInput);
  EXPECT_TRUE(Contains(result.err, "skywave: bad.exr: bad.hdr")) << result.err;
  EXPECT_EQ(Files(), (Names{"bad.hdr", "good.pfm", "good.exr", "good.png", "job.toml",
                            "job.batch.html", "job.batch.json"}));
}

TEST_F(Batch, FramesOfAMapSequenceEqualTheirCommands) {
  for (const int frame : {1, 2}) {
    Image map(8, 4);
    std::fill(map.rgb.begin(), map.rgb.end(), float(frame));
    WritePfm(Path("sky_0" + std::to_string(frame) + ".pfm"), map);
  }
  Put("job.toml",
      "[base]\nscene = \"spheres\"\nsize = \"8x6\"\nspp = 1\nenv = \"sky_##.pfm\"\n"
      "[axes]\nframe = \"1-2\"\n[output]\npath = \"{env}_{frame}.exr\"\n");
  const Result result = Run("batch job.toml");
  EXPECT_EQ(result.exit_code, 0) << result.err;
  for (const std::string name : {"sky_1.exr", "sky_2.exr"}) {
    std::string command;
    for (const auto& [key, text] : ReadExrMetadata(Path(name))) {
      if (key == "command") command = text.substr(std::string("skywave ").size());
    }
    EXPECT_EQ(Run(command + " -q -o alone.exr").exit_code, 0) << command;
    EXPECT_TRUE(Bytes("alone.exr") == Bytes(name)) << command;
  }
  Put("job.toml", Bytes("job.toml") + "# changed\n");
  std::filesystem::remove(Path("sky_02.pfm"));
  const Result missing = Run("batch job.toml");
  EXPECT_EQ(missing.exit_code, kExitBadInput);
  EXPECT_TRUE(Contains(missing.err, "job.toml:7: ")) << missing.err;
  EXPECT_TRUE(Contains(missing.err, "sky_02.pfm")) << missing.err;
}

TEST_F(Batch, ADryRunLooksAtTheEndsOfFramesAndAtCameras) {
  GltfDocument document = TriangleDocument();
  document.Animate(0, 2, "scale", document.Add<float>({0, 1}, "SCALAR"),
                   document.Add<float>({1, 1, 1, 0, 0, 0}, "VEC3"));
  Put("moving.gltf", document.text());
  const std::string job =
      "[base]\nscene = \"moving.gltf\"\nsize = \"8x6\"\n[output]\npath = \"{index}.exr\"\n[axes]\n";
  Put("job.toml", job + "frame = \"0-23\"\n");
  const Result good = Run("batch job.toml --dry-run -q");
  EXPECT_EQ(good.exit_code, 0) << good.err;
  Put("job.toml", job + "frame = \"10,24,11\"\n");
  const Result bad = Run("batch job.toml --dry-run -q");
  EXPECT_EQ(bad.exit_code, kExitBadInput);
  EXPECT_TRUE(Contains(bad.err, "moving.gltf") && Contains(bad.err, "camera")) << bad.err;
  Put("job.toml", job + "scene-camera = [\"front\", \"sid\"]\n");
  const Result camera = Run("batch job.toml --dry-run -q");
  EXPECT_EQ(camera.exit_code, kExitBadInput);
  EXPECT_TRUE(Contains(camera.err, "job.toml:7: ") && Contains(camera.err, "sid")) << camera.err;
}

// A shell's limit of 1 KiB for files stands for a full disk.
TEST_F(Batch, AFullDiskFailsThePicturesAndLeavesNoPart) {
  Put("job.toml", kJob);
  const Result result = Shell("ulimit -f 1; '" + ProgramPath() + "' batch job.toml -q");
  EXPECT_EQ(result.exit_code, kExitIo) << result.err;
  for (const std::string& name : FilesIn("out")) EXPECT_FALSE(name.ends_with(".part")) << name;
  EXPECT_EQ(Run("batch job.toml -q").exit_code, 0);
  EXPECT_EQ(FilesIn("out").size(), 8u);
}

TEST_F(Batch, AReaderOfTheTableThatLeavesLosesNoPicture) {
  Put("job.toml", kJob);
  EXPECT_EQ(Shell("'" + ProgramPath() + "' batch job.toml 2>&1 | true").exit_code, 0);
  EXPECT_EQ(FilesIn("out").size(), 8u);
}

TEST_F(Batch, TwoAtOnceMakeTheSameWholePictures) {
  Put("job.toml", kJob);
  EXPECT_EQ(Run("batch job.toml -q -o alone").exit_code, 0);
  const std::string command = "'" + ProgramPath() + "' batch job.toml -q -o both --checkpoint 0.01";
  const Result both = Shell(command + " & " + command + "; code=$?; wait $! && exit $code");
  EXPECT_EQ(both.exit_code, 0) << both.err;
  EXPECT_EQ(FilesIn("both/out"), FilesIn("alone/out"));
  for (const std::string& name : FilesIn("alone/out")) {
    if (Contains(name, "batch")) continue;
    EXPECT_EQ(Bytes("both/out/" + name), Bytes("alone/out/" + name)) << name;
  }
}

TEST_F(Batch, BadFlagsAndFilesAreRefusedBeforeTheFirstRay) {
  Put("job.toml", kJob);
  Put("typo.toml", std::string(kJob) + "[axs]\n");
  const struct {
    std::string arguments;
    int exit_code;
    std::string part;
  } cases[] = {{"batch", kExitUsage, "job is required"},
               {"batch nosuch.toml", kExitIo, "nosuch.toml"},
               {"batch typo.toml", kExitBadInput, "typo.toml:9: 'axs'"},
               {"batch job.toml -o job.toml", kExitIo, "job.toml is a file"},
               {"batch job.toml --only 3/2", kExitUsage, "3/2"},
               {"batch job.toml --only 0/2", kExitUsage, "0/2"},
               {"batch job.toml --only 2", kExitUsage, "--only"},
               {"batch job.toml --json", kExitUsage, "--list"},
               {"batch job.toml --list --dry-run", kExitUsage, "--list"}};
  for (const auto& [arguments, exit_code, part] : cases) {
    const Result result = Run(arguments);
    EXPECT_EQ(result.exit_code, exit_code) << arguments;
    EXPECT_TRUE(Contains(result.err, part)) << arguments << "\n" << result.err;
  }
  EXPECT_EQ(Files(), (Names{"job.toml", "typo.toml"}));
}

}  // namespace
}  // namespace skywave
