// Tests how a job file becomes pictures: lists, names, axes, and what is refused with which line.
#include "job/batch/plan.h"

#include <gtest/gtest.h>

#include <filesystem>
#include <set>
#include <string>
#include <vector>

#include "base/error.h"
#include "job/batch/check.h"
#include "job/batch/number_list.h"
#include "job/batch/output_name.h"
#include "tests/support/gltf_document.h"
#include "tests/support/temporary_folder.h"

namespace skywave {
namespace {

using Numbers = std::vector<std::int64_t>;

TEST(NumberList, ListsSinglesRangesAndSteps) {
  const struct {
    std::string text;
    Numbers numbers;
  } cases[] = {
      {"5", {5}},
      {"-5", {-5}},
      {"1-3", {1, 2, 3}},
      {"3-1", {3, 2, 1}},
      {"-3--1", {-3, -2, -1}},
      {"1--1", {1, 0, -1}},
      {"1-10:4", {1, 5, 9}},
      {"10-1:3", {10, 7, 4, 1}},
      {"1-3:100", {1}},
      {" 1 , 3-4 ", {1, 3, 4}},
      {"2,2", {2, 2}},
      {"1-3,5,7-12:2", {1, 2, 3, 5, 7, 9, 11}},
      {"9223372036854775806-9223372036854775807", {9223372036854775806, 9223372036854775807}}};
  for (const auto& [text, expected] : cases) {
    Numbers numbers;
    EXPECT_EQ(ParseNumberList(text, 100, numbers), "") << text;
    EXPECT_EQ(numbers, expected) << text;
  }
}

TEST(NumberList, RefusesInvalidAndTooLongLists) {
  for (const char* const text : {"", ",", "1,", "1-", "-", "1-2-3", "1:2", "1-2:", "1-2:0",
                                 "1-2:-1", "a", "1.5", "1 2", "99999999999999999999"}) {
    Numbers numbers;
    EXPECT_NE(ParseNumberList(text, 100, numbers), "") << text;
  }
  for (const char* const text :
       {"1-101", "1-50,1-51", "1-2000000000", "-9223372036854775808-9223372036854775807"}) {
    Numbers numbers;
    EXPECT_NE(ParseNumberList(text, 100, numbers).find("more than 100"), std::string::npos) << text;
    EXPECT_TRUE(numbers.empty());
  }
}

// Returns the name that `pattern` makes of `value`, or the problem in brackets.
std::string Named(const std::string& pattern, const std::string& value) {
  std::vector<NamePiece> pieces;
  std::string name;
  std::string problem = ParseNamePattern(pattern, pieces);
  if (problem.empty()) {
    problem = FillName(
        pieces,
        [&](const std::string& place) {
          return place == "v" ? std::optional(value) : std::nullopt;
        },
        name);
  }
  return problem.empty() ? name : "[" + problem + "]";
}

TEST(OutputName, PadsNumbersAndReplacesUnsafeCharacters) {
  const struct {
    const char *pattern, *value, *name;
  } cases[] = {{"a_{v}.exr", "x", "a_x.exr"},
               {"{v:04}", "7", "0007"},
               {"{v:04}", "-7", "-007"},
               {"{v:04}", "12345", "12345"},
               {"{v:06.2}", "7.125", "007.12"},
               {"{v:.1}", "60", "60.0"},
               {"{v:05}", "7.5", "007.5"},
               {"{{{v}}}", "x", "{x}"},
               {"{v}/b", "a/b c:*?\"<>|\n", "a_b_c________/b"},
               {"{v}", "..", "__"},
               {"{v}", "\xc3\xa4.b", "\xc3\xa4.b"}};
  for (const auto& [pattern, value, name] : cases) EXPECT_EQ(Named(pattern, value), name);
  for (const char* const pattern :
       {"{", "}", "a{v", "{v}}", "{}", "{v:}", "{v:x}", "{v:4x}", "{v:99}", "{v{v}}", "{w}"}) {
    EXPECT_EQ(Named(pattern, "7").front(), '[') << pattern;
  }
  EXPECT_EQ(Named("{v:04}", "red").front(), '[');
}

TEST(Bytes, HaveUnits) {
  EXPECT_EQ(ParseBytes("4GiB"), std::uint64_t{4} << 30);
  EXPECT_EQ(ParseBytes("1.5 KB"), 1500u);
  EXPECT_EQ(ParseBytes("77"), 77u);
  std::uint64_t decimal = 1, binary = 1;
  for (const std::string prefix : {"K", "M", "G", "T"}) {
    decimal *= 1000, binary *= 1024;
    EXPECT_EQ(ParseBytes("3" + prefix + "B"), 3 * decimal) << prefix;
    EXPECT_EQ(ParseBytes("3" + prefix + "iB"), 3 * binary) << prefix;
  }
  for (const char* const text : {"", "x", "-1GB", "0", "4 G", "4GiBs", "1e300TB", "nan"}) {
    EXPECT_EQ(ParseBytes(text), 0u) << text;
  }
}

class Plan : public testing::Test {
 protected:
  void SetUp() override {
    std::filesystem::create_directory(folder_.Path("skies"));
    for (const char* const map : {"grace.exr", "skies/b.hdr", "skies/a.hdr", "skies/c.txt"}) {
      folder_.Write(map, "");
    }
  }
  BatchPlan Read(const std::string& job) const {
    return ReadBatchPlan(folder_.Write("job.toml", job));
  }
  // The outputs relative to the folder of the job file.
  std::vector<std::string> Outputs(const std::string& job) const {
    std::vector<std::string> outputs;
    for (const BatchPicture& picture : Read(job).pictures) {
      outputs.push_back(std::filesystem::path(picture.output).lexically_relative(folder_.Path("")));
    }
    return outputs;
  }
  // Expects the message "job.toml:LINE: ..." with all of `parts`.
  void ExpectRefused(const std::string& job, std::size_t line,
                     const std::vector<std::string>& parts) const {
    try {
      Read(job);
      ADD_FAILURE() << "not refused:\n" << job;
    } catch (const InputError& error) {
      EXPECT_EQ(error.place(), ToString(InputPosition::Line(folder_.Path("job.toml"), line)))
          << error.what();
      for (const std::string& part : parts) {
        EXPECT_NE(error.reason().find(part), std::string::npos) << part << "\n" << error.reason();
      }
    }
  }
  TemporaryFolder folder_;
};

constexpr char kBase[] = "[base]\nscene = \"spheres\"\n";
constexpr char kOutput[] = "[output]\npath = \"o/{index}.exr\"\n";

TEST_F(Plan, CrossesAxesInTheOrderOfTheFileTheLastOneFastest) {
  const BatchPlan plan = Read(std::string(kBase) +
                              "spp = 3\n"
                              "[output]\npath = \"{strategy}_{env-rotate:03}_{seed}.exr\"\n"
                              "[axes]\nstrategy = [\"uniform\", \"bsdf\"]\nseed = \"1-2\"\n"
                              "env-rotate = { from = 0, to = 360, steps = 3 }\n");
  std::size_t index = 0;
  for (const std::string strategy : {"uniform", "bsdf"}) {
    for (const std::string seed : {"1", "2"}) {
      for (const std::string rotation : {"0", "120", "240"}) {
        const BatchPicture& picture = plan.pictures.at(index);
        const std::string padded = std::string(3 - rotation.size(), '0') + rotation;
        EXPECT_EQ(picture.index, index);
        EXPECT_EQ(picture.output, folder_.Path(strategy + "_" + padded + "_" + seed + ".exr"));
        const PictureRequest request = RequestOf(plan.path, picture.options);
        EXPECT_EQ(request.job.strategy, strategy);
        EXPECT_EQ(request.job.options.seed, unsigned(std::stoi(seed)));
        EXPECT_EQ(request.job.environment.rotation_degrees, std::stof(rotation));
        EXPECT_EQ(request.job.samples_per_pixel, 3u);
        ++index;
      }
    }
  }
  EXPECT_EQ(plan.pictures.size(), index);
  ASSERT_EQ(plan.dimensions.size(), 3u);
  EXPECT_EQ(plan.dimensions[2].labels, (std::vector<std::string>{"0", "120", "240"}));
}

// Nine digits identify any float.
TEST_F(Plan, NumbersKeepTheirDigits) {
  const BatchPlan plan = Read(std::string(kBase) + kOutput +
                              "[axes]\nenv-rotate = [12.3456789, 3]\n"
                              "env-intensity = { from = 0.123456789, to = 1, steps = 1 }\n");
  EXPECT_EQ(plan.pictures[0].axes[0].label, "12.3456789");
  EXPECT_EQ(plan.pictures[0].axes[1].label, "0.123456789");
  const PictureRequest request = RequestOf(plan.path, plan.pictures[0].options);
  EXPECT_EQ(request.job.environment.rotation_degrees, 12.3456789f);
  EXPECT_EQ(request.job.environment.intensity, 0.123456789f);
}

TEST_F(Plan, ZippedAxesVaryTogether) {
  EXPECT_EQ(Outputs(std::string(kBase) + "[[zip]]\nseed = \"7,9\"\nspp = [1, 2]\n"
                                         "[axes]\ntone = [\"clip\", \"filmic\"]\n"
                                         "[output]\npath = \"{seed}_{spp}_{tone}.exr\"\n"),
            (std::vector<std::string>{"7_1_clip.exr", "7_1_filmic.exr", "9_2_clip.exr",
                                      "9_2_filmic.exr"}));
}

TEST_F(Plan, PatternsOfFilesAreSortedAndRelativeToTheJobFile) {
  const BatchPlan plan = Read(std::string(kBase) +
                              "[axes]\nenv = [\"grace.exr\", \"skies/?.h*\"]\n"
                              "[output]\npath = \"{scene}/{env}.exr\"\n");
  ASSERT_EQ(plan.pictures.size(), 3u);
  EXPECT_EQ(plan.pictures[1].output, folder_.Path("spheres/a.exr"));
  EXPECT_EQ(plan.folder, folder_.Path("spheres"));
  EXPECT_EQ(InputFiles(plan),
            (std::set<std::string>{folder_.Path("grace.exr"), folder_.Path("skies/a.hdr"),
                                   folder_.Path("skies/b.hdr")}));
}

TEST_F(Plan, LayersOfAFileAreMapsOfTheirOwn) {
  const BatchPlan plan = Read(std::string(kBase) +
                              "[axes]\nenv = [\"grace.exr\", \"grace.exr:sun\"]\n"
                              "[output]\npath = \"{env}.exr\"\n");
  ASSERT_EQ(plan.pictures.size(), 2u);
  EXPECT_EQ(plan.pictures[1].output, folder_.Path("grace_sun.exr"));
  EXPECT_EQ(InputFiles(plan), std::set<std::string>{folder_.Path("grace.exr")});
}

TEST_F(Plan, MapSequencesNeedAFileForEveryFrame) {
  for (const char* const map : {"sky_08.exr", "sky_09.exr", "sky_10.exr"}) folder_.Write(map, "");
  const std::string job =
      std::string(kBase) + "env = \"sky_##.exr\"\n[output]\npath = \"{env}_{frame:03}.exr\"\n";
  EXPECT_EQ(Outputs(job + "[axes]\nframe = \"8-10\"\n"),
            (std::vector<std::string>{"sky_008.exr", "sky_009.exr", "sky_010.exr"}));
  const BatchPlan plan = Read(job + "[axes]\nframe = [9]\n");
  EXPECT_EQ(InputFiles(plan), std::set<std::string>{folder_.Path("sky_09.exr")});
  ExpectRefused(job + "[axes]\nframe = [\n8,\n11\n]\n", 9, {"frame 11", "no file", "sky_11.exr"});
  ExpectRefused(job + "[axes]\nframe = [8.5]\n", 7, {"frame 8.5", "whole"});
  ExpectRefused(std::string(kBase) + "env = \"sky_##.exr\"\n" + kOutput, 3,
                {"sky_##.exr", "`frame N`"});
}

TEST_F(Plan, AStarSelectsEveryCameraOfTheScene) {
  folder_.Write("a.gltf", TriangleDocument().text());
  const std::string output = "[output]\npath = \"{scene-camera}.exr\"\n[axes]\n";
  const std::string base = "[base]\nscene = \"a.gltf\"\n" + output;
  EXPECT_EQ(Outputs(base + "scene-camera = \"*\"\n"),
            (std::vector<std::string>{"front.exr", "side.exr"}));
  EXPECT_EQ(Outputs(base + "look = [{ label = \"*\", seed = 3 }]\nscene-camera = \"side\"\n"),
            std::vector<std::string>{"side.exr"});
  ExpectRefused(kBase + output + "scene-camera = \"*\"\n", 6, {"spheres has no camera"});
  ExpectRefused(output + "scene = [\"spheres\"]\nscene-camera = \"*\"\n", 5, {"[base]", "scene"});
}

// A file of cameras is all of its photographs, unless one is named.
TEST_F(Plan, AnAxisOfCamerasIsEveryPhotographOfTheFile) {
  const std::string pose = "\"transform_matrix\": [[1,0,0,0],[0,1,0,0],[0,0,1,4],[0,0,0,1]]";
  folder_.Write("transforms.json",
                "{\"camera_angle_x\": 0.7, \"w\": 12, \"h\": 9, \"frames\": [{\"file_path\": "
                "\"./train/r_0.png\", " +
                    pose + "}, {\"file_path\": \"./train/r_1.png\", " + pose + "}]}");
  const BatchPlan plan =
      Read(kBase + std::string("[output]\npath = \"{camera-from}.exr\"\n[axes]\n") +
           "camera-from = \"transforms.json\"\n");
  ASSERT_EQ(plan.pictures.size(), 2u);
  for (const std::size_t i : {0, 1}) {
    const std::string name = "r_" + std::to_string(i);
    EXPECT_EQ(plan.pictures[i].axes[0].label, name);
    const JobRequest job = RequestOf(plan.path, plan.pictures[i].options).job;
    EXPECT_EQ(job.camera.from, folder_.Path("transforms.json"));
    EXPECT_EQ(job.camera.name, "./train/" + name + ".png");
  }
  const std::string base = kBase + std::string("camera-from = \"transforms.json\"\n");
  EXPECT_EQ(Outputs(base + "[output]\npath = \"{scene-camera}.exr\"\n[axes]\n" +
                    "scene-camera = \"*\"\n"),
            (std::vector<std::string>{"r_0.exr", "r_1.exr"}));
  EXPECT_EQ(Outputs(kBase + std::string("scene-camera = \"./train/r_1.png\"\n") +
                    "[output]\npath = \"{camera-from}.exr\"\n[axes]\n" +
                    "camera-from = [\"transforms.json\"]\n"),
            std::vector<std::string>{"transforms.exr"});
}

TEST_F(Plan, ProductsSetSeveralOptionsUnderALabel) {
  const BatchPlan plan =
      Read(std::string(kBase) +
           "[axes]\nlook = [{label = \"red one\", exposure = 1, tone = \"clip\"},"
           " {label = \"b\", exposure = -1.5}]\n"
           "env = [{env = \"grace.exr\", env-intensity = 2}, \"skies/a.hdr\"]\n"
           "[output]\npath = \"{look}_{env}.exr\"\n");
  ASSERT_EQ(plan.pictures.size(), 4u);
  EXPECT_EQ(plan.pictures[0].output, folder_.Path("red_one_grace.exr"));
  EXPECT_EQ(plan.pictures[0].axes[0].label, "red one");
  EXPECT_EQ(RequestOf("", plan.pictures[0].options).job.environment.intensity, 2);
  EXPECT_EQ(RequestOf("", plan.pictures[3].options).exposure.exposure->stops, -1.5f);
}

TEST_F(Plan, SharesPartitionTheListAndKeepTheirIndices) {
  const BatchPlan plan = Read(std::string(kBase) + kOutput + "[axes]\nseed = \"1-11\"\n");
  std::multiset<std::string> together;
  for (std::size_t share = 1; share <= 3; ++share) {
    for (const BatchPicture& picture : ShareOf(plan, {share, 3}).pictures) {
      EXPECT_EQ(picture.output, plan.pictures[picture.index].output);
      together.insert(picture.output);
    }
  }
  EXPECT_EQ(together.size(), 11u);
  EXPECT_EQ(std::set<std::string>(together.begin(), together.end()).size(), 11u);
}

TEST_F(Plan, AChangedOrRemovedJobFileIsNoticed) {
  const BatchPlan plan = Read(std::string(kBase) + kOutput);
  EXPECT_NO_THROW(CheckUnchanged(plan));
  Read(std::string(kBase) + kOutput + "# more\n");
  EXPECT_THROW(CheckUnchanged(plan), InputError);
  std::filesystem::remove(plan.path);
  EXPECT_THROW(CheckUnchanged(plan), InputError);
}

TEST_F(Plan, BadInputIsRefusedWithItsLine) {
  const std::string base = kBase, start = base + kOutput;  // lines 1 and 2, 3 and 4
  const struct {
    std::string job;
    std::size_t line;
    std::vector<std::string> parts;
  } cases[] = {
      {base + "spp = \n", 3, {}},
      {base + "spp = 0\n" + kOutput, 3, {"spp", "'0'"}},
      {base + "sppp = 1\n" + kOutput, 3, {"sppp", "`spp`"}},
      {base + "spp = [1, 2]\n" + kOutput, 3, {"spp", "[axes]"}},
      {base + "spp = 1979-05-27\n" + kOutput, 3, {"spp"}},
      {base + "env = \"nosuch.hdr\"\n" + kOutput, 3, {"nosuch.hdr"}},
      {base + "shutter = \"1/60\"\n" + kOutput, 3, {"shutter", "f-number"}},
      {"[base]\nscene = \"sphere\"\n" + std::string(kOutput), 2, {"sphere", "built-in"}},
      {"[base]\nspp = 3\n" + std::string(kOutput), 0, {"no scene"}},
      {base + "[axis]\nspp = [1]\n" + kOutput, 3, {"axis", "'axes'"}},
      {start + "paths = 1\n", 5, {"paths", "'path'"}},
      {start + "[batch]\nmemry = \"1GB\"\n", 6, {"memry", "'memory'"}},
      {start + "[batch]\nmemory = \"much\"\n", 6, {"much"}},
      {base, 0, {"[output]"}},
      {base + "[output]\n", 3, {"path"}},
      {base + "[output]\npath = \"a.png\"\n", 4, {".exr"}},
      {base + "[output]\npath = \"{index.exr\"\n", 4, {"{{"}},
      {base + "[output]\npath = \"{indx}.exr\"\n", 4, {"indx", "{index}"}},
      {base + "[output]\npath = \"{scene:04}.exr\"\n", 4, {"scene", "spheres"}},
      // Axes
      {start + "[axes]\nsed = [1]\n", 6, {"sed", "`seed`"}},
      {start + "[axes]\nseed = []\n", 6, {"seed", "no value"}},
      {start + "[axes]\nseed = \"1-\"\n", 6, {"seed", "'1-'"}},
      {start + "[axes]\nseed = [1,\n 2, -7]\n", 7, {"seed", "'-7'"}},
      {start + "[axes]\nseed = { from = 0, to = 3, steps = 2 }\n", 6, {"seed", "'1.5'"}},
      {start + "[axes]\nseed = { from = 0, step = 2 }\n", 6, {"step", "'steps'"}},
      {start + "[axes]\nseed = { from = 0, to = 4 }\n", 6, {"steps"}},
      {start + "[axes]\nseed = { from = 0, to = 4, steps = 0 }\n", 6, {"steps"}},
      {start + "[axes]\nenv = \"skies/*.exr\"\n", 6, {"skies/*.exr"}},
      {start + "[axes]\nlook = [{ tone = \"clip\" }]\n", 6, {"look", "label"}},
      {start + "[axes]\nlook = [{ label = \"a\", tonee = 1 }]\n", 6, {"tonee", "`tone`"}},
      {start + "[axes]\nscene = [\"spheres\"]\n", 6, {"scene", "line 2"}},
      {start + "[axes]\nseed = [1]\na = [{ label = \"a\", seed = 2 }]\n", 7, {"seed", "line 6"}},
      {start + "[[zip]]\nseed = [1, 2]\nspp = [1, 2, 3]\n", 7, {"spp", "seed", "line 6"}},
      {start + "[[zip]]\n", 5, {"no axis"}},
      // Too many: none of them is made.
      {start + "[axes]\nseed = \"0-999999\"\n", 6, {"more than 100000"}},
      {start + "[axes]\nseed = \"1-2000000000\"\n", 6, {"more than 100000"}},
      {start + "[axes]\nenv-rotate = { from = 0, to = 1, steps = 2000000000 }\n", 6, {"steps"}},
      {start + "[axes]\nseed = \"1-1000\"\nspp = \"1-101\"\n", 7, {"spp", "more than 100000"}},
      // Two pictures of one name
      {base + "[output]\npath = \"{spp}.exr\"\n[axes]\nspp = [1, 2]\nseed = [7, 8]\n",
       4,
       {"pictures 0 and 1", "1.exr", "{seed}"}},
      {base + "[output]\npath = \"{env-rotate:.0}.exr\"\n[axes]\nenv-rotate = [1.1, 1.2]\n",
       4,
       {"pictures 0 and 1", "{index}"}},
  };
  for (const auto& [job, line, parts] : cases) ExpectRefused(job, line, parts);
}

TEST_F(Plan, OutputsAreCheckedBeforeAnythingIsRendered) {
  folder_.Write("o", "a file");
  EXPECT_THROW(CheckOutputs(Read(std::string(kBase) + kOutput)), InputError);
  const std::string over_input =
      std::string(kBase) + "env = \"grace.exr\"\n[output]\npath = \"grace.exr\"\n";
  EXPECT_THROW(CheckOutputs(Read(over_input)), InputError);
  const BatchPlan plan = Read(std::string(kBase) + "[output]\npath = \"p/q/{index}.exr\"\n");
  EXPECT_NO_THROW(CheckOutputs(plan));
  EXPECT_FALSE(std::filesystem::exists(folder_.Path("p")));
  PrepareOutputs(plan);
  EXPECT_TRUE(std::filesystem::is_empty(folder_.Path("p/q")));
}

}  // namespace
}  // namespace skywave
