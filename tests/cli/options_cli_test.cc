// Tests everything that follows from the table of options: the list, the reference, completions,
// and the commands in pictures that repeat them.
#include <gtest/gtest.h>

#include <algorithm>
#include <cstdlib>
#include <nlohmann/json.hpp>
#include <set>
#include <string>

#include "base/error.h"
#include "image/exr_header.h"
#include "image/image.h"
#include "tests/support/camera_text.h"
#include "tests/support/gltf_document.h"
#include "tests/support/program.h"

namespace skywave {
namespace {

class OptionsCli : public Program {
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
    Put("moving.gltf", MovingTriangle().text());
    Put("camera.json", test::kCameraFile);
    Image map(8, 4);
    for (std::size_t i = 0; i < map.rgb.size(); ++i) map.rgb[i] = float(1 + i % 5);
    WriteExr(Path("map.exr"), map);
  }

  nlohmann::json Options() {
    const Result result = Run("options --json");
    EXPECT_EQ(result.exit_code, 0) << result.err;
    return nlohmann::json::parse(result.out).at("commands");
  }

  // Returns the words of a manual page without fonts, and fails where groff warns of something.
  std::string Printed(const std::string& page) {
    const std::string command = "cd '" + Path("") +
                                "' && groff -ww -man -rHY=0 -Tascii -P-c -P-b -P-u " + page +
                                " > printed 2> warnings";
    EXPECT_EQ(std::system(command.c_str()), 0);
    EXPECT_EQ(Bytes("warnings"), "") << page;
    return Bytes("printed");
  }
};

std::string Squeezed(std::string text) {
  std::erase_if(text, [](unsigned char c) { return std::isspace(c) != 0; });
  return text;
}

bool Contains(const std::string& text, const std::string& part) {
  return text.find(part) != std::string::npos;
}

// Returns the options that the help text shows: "--max-depth" of "  --max-depth N   surfaces ...".
std::set<std::string> FlagsOfHelp(const std::string& help) {
  std::set<std::string> flags;
  std::istringstream lines(help.substr(0, help.find("Example")));
  for (std::string line; std::getline(lines, line);) {
    const std::size_t dashes = line.find("--");
    if (line.rfind("  ", 0) != 0 || dashes > 5 || dashes == std::string::npos) continue;
    flags.insert(line.substr(dashes, line.find_first_of(" ,", dashes) - dashes));
  }
  return flags;
}

TEST_F(OptionsCli, TheListHasEveryFlagOfEverySubcommandAndNoOther) {
  const nlohmann::json commands = Options();
  EXPECT_GE(commands.size(), 13u);
  for (const auto& [name, options] : commands.items()) {
    SCOPED_TRACE(name);
    std::set<std::string> listed = {"--help"};
    for (const nlohmann::json& option : options) {
      for (const char* const key : {"group", "help", "scope", "default", "values"}) {
        EXPECT_TRUE(option.contains(key)) << option;
      }
      if (option.at("positional")) continue;
      const bool negative = option.at("switch") && Contains(option.at("usage"), "--no-");
      listed.insert((negative ? "--no-" : "--") + option.at("name").get<std::string>());
    }
    EXPECT_EQ(FlagsOfHelp(Run(name + " --help").out), listed);
  }
}

// For each option that affects the picture, the metadata of a picture made with it hold a command
// with the option, and the command reproduces both files to the last byte.
TEST_F(OptionsCli, TheRecordedCommandRepeatsThePictureOfEveryOption) {
  const nlohmann::json options = Options().at("render");
  for (const nlohmann::json& option : options) {
    const std::string scope = option.at("scope"), name = option.at("name");
    if (scope != "pixels" && scope != "input") continue;
    const std::string example = option.at("example");
    ASSERT_NE(example, "") << name << ": an option that decides pictures needs an example";
    // An example that needs a scene of its own begins with it.
    std::string command = example.starts_with("-") ? "render good.ply" : "render";
    for (const std::string given : {"--env map.exr", "--ground", "--size 12x9", "--spp 2"}) {
      if (!Contains(example, given.substr(0, given.find(' ') + 1))) command += " " + given;
    }
    command += " " + example;
    SCOPED_TRACE(command);
    const Result first = Run(command + " -q -o first.exr");
    ASSERT_EQ(first.exit_code, 0) << first.err;
    std::string repeat;
    for (const auto& [key, value] : ReadExrMetadata(Path("first.exr"))) {
      if (key == "command") repeat = value;
    }
    ASSERT_EQ(repeat.substr(0, 8), "skywave ");
    if (!option.at("positional")) {
      // Where a limit has ended a picture early, the command asks for the samples that it got.
      const bool ends = name == "time" || name == "noise";
      const std::string recorded = ends ? "sample-range" : name;
      EXPECT_TRUE(Contains(repeat, " --" + recorded) || Contains(repeat, " --no-" + recorded))
          << repeat;
    }
    const Result second = Run(repeat.substr(8) + " -q -o second.exr");
    ASSERT_EQ(second.exit_code, 0) << repeat << "\n" << second.err;
    EXPECT_TRUE(Bytes("first.exr") == Bytes("second.exr")) << repeat;
    EXPECT_TRUE(Bytes("first.png") == Bytes("second.png")) << repeat;
  }
}

// Headers of pictures and films hold UTF-8, and the name of a file need not be that.
TEST_F(OptionsCli, TheRecordedCommandFindsAFileWithAnyName) {
  Put("skywave.sh", "skywave() { '" + ProgramPath() + "' \"$@\" -q -o second.exr; }\n");
  for (const std::string name : {"caf\xe9 1's.ply", "a\\1\n1\x80.ply", "caf\xc3\xa9's.ply"}) {
    SCOPED_TRACE(name);
    Put(name, Bytes("good.ply"));
    Put("name", name);
    const std::string render = "render \"$(cat name)\" --env map.exr --size 12x9 --spp 2 -q ";
    ASSERT_EQ(Run(render + "-o first.exr").exit_code, 0);
    ASSERT_EQ(Run(render + "--film a.film").exit_code, 0);
    ASSERT_EQ(Run("merge a.film -q -o merged.exr").exit_code, 0);
    for (const char* const picture : {"first.exr", "merged.exr"}) {
      SCOPED_TRACE(picture);
      const Metadata metadata = ReadExrMetadata(Path(picture));
      const auto command = std::find_if(metadata.begin(), metadata.end(),
                                        [](const auto& text) { return text.first == "command"; });
      ASSERT_NE(command, metadata.end());
      EXPECT_EQ(WithoutControlCodes(command->second), command->second);
      Put("again.sh", Bytes("skywave.sh") + command->second);
      const Result again = Shell("bash again.sh");
      ASSERT_EQ(again.exit_code, 0) << command->second << again.err;
      EXPECT_TRUE(Bytes("first.exr") == Bytes("second.exr")) << command->second;
    }
  }
}

TEST_F(OptionsCli, SwitchesCanBeTakenBack) {
  const std::string base = "render good.ply --env map.exr --size 12x9 --spp 2 -q -o ";
  ASSERT_EQ(Run(base + "plain.exr").exit_code, 0);
  ASSERT_EQ(Run(base + "back.exr --ground --no-ground --no-mis --mis").exit_code, 0);
  EXPECT_EQ(Bytes("plain.exr"), Bytes("back.exr"));
  ASSERT_EQ(Run(base + "light.exr --integrator light").exit_code, 0);
  ASSERT_EQ(Run(base + "guided.exr --integrator light --guide").exit_code, 0);
  ASSERT_EQ(Run(base + "back.exr --integrator light --guide --no-guide").exit_code, 0);
  EXPECT_EQ(Bytes("light.exr"), Bytes("back.exr"));
  EXPECT_NE(Bytes("light.exr"), Bytes("guided.exr"));
}

TEST_F(OptionsCli, PhotonsOfALookupAreAsManyAsAskedFor) {
  const std::string base = "render lamps --size 12x9 --spp 2 --integrator photon -q -o ";
  ASSERT_EQ(Run(base + "plain.exr").exit_code, 0);
  ASSERT_EQ(Run(base + "same.exr --photon-neighbors 50").exit_code, 0);
  ASSERT_EQ(Run(base + "fewer.exr --photon-neighbors 7").exit_code, 0);
  EXPECT_EQ(ReadImage(Path("plain.exr")).rgb, ReadImage(Path("same.exr")).rgb);
  EXPECT_NE(ReadImage(Path("plain.exr")).rgb, ReadImage(Path("fewer.exr")).rgb);
}

TEST_F(OptionsCli, TheReferenceIsCurrent) {
  EXPECT_EQ(Run("options --format markdown").out, ReadFile(SourcePath("docs/options.md")))
      << "regenerate it: skywave options --format markdown > docs/options.md";
}

TEST_F(OptionsCli, BashCompletesSubcommandsFlagsAndValues) {
  Put("skywave.bash", Run("options --format bash").out);
  const auto complete = [&](const std::string& words, int at) {
    const std::string command = "cd '" + Path("") + "' && bash -c '. ./skywave.bash; COMP_WORDS=(" +
                                words + "); COMP_CWORD=" + std::to_string(at) +
                                "; _skywave; echo \"${COMPREPLY[@]}\"' > completed";
    EXPECT_EQ(std::system(command.c_str()), 0);
    return Bytes("completed");
  };
  EXPECT_EQ(complete("skywave ren", 1), "render\n");
  EXPECT_EQ(complete("skywave render --max-d", 2), "--max-depth\n");
  EXPECT_EQ(complete("skywave render --integrator b", 3), "bdpt\n");
  EXPECT_EQ(complete("skywave probe conv", 2), "convert\n");
  EXPECT_EQ(complete("skywave probe plot --vi", 3), "--view\n");
}

TEST_F(OptionsCli, EverySubcommandHasAManualPageWithAllItsOptions) {
  const nlohmann::json commands = Options();
  const std::string overview = Run("options --format man").out;
  for (const auto& [name, options] : commands.items()) {
    SCOPED_TRACE(name);
    std::string page = "skywave-" + name;
    std::replace(page.begin(), page.end(), ' ', '-');
    EXPECT_TRUE(Contains(overview, "\n.B " + name + "\n"));
    const Result made = Run("options --format man --of '" + name + "'");
    ASSERT_EQ(made.exit_code, 0) << made.err;
    Put(page + ".1", made.out);
    const std::string plain = Printed(page + ".1");
    // Lines are broken where the page is not wide enough, so spaces are not compared.
    EXPECT_TRUE(Contains(Squeezed(plain), "NAME" + page + "-")) << plain;
    for (const nlohmann::json& option : options) {
      EXPECT_TRUE(Contains(Squeezed(plain), Squeezed(option.at("usage")))) << option << plain;
      EXPECT_TRUE(Contains(Squeezed(plain), Squeezed(option.at("help")))) << option << plain;
    }
  }
  Put("skywave.1", overview);
  Printed("skywave.1");
}

TEST_F(OptionsCli, OneSubcommandCanBeListedAlone) {
  const nlohmann::json one =
      nlohmann::json::parse(Run("options --json --of 'probe info'").out).at("commands");
  ASSERT_EQ(one.size(), 1u);
  EXPECT_EQ(one.at("probe info"), Options().at("probe info"));
  const Result wrong = Run("options --format man --of rendre");
  EXPECT_EQ(wrong.exit_code, 64);
  EXPECT_TRUE(Contains(wrong.err, "--of rendre: there is no such subcommand")) << wrong.err;
}

}  // namespace
}  // namespace skywave
