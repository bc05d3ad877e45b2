// Tests the progress of commands and what they say of their threads, from the outside.
#include <gtest/gtest.h>

#include <nlohmann/json.hpp>
#include <sstream>
#include <string>

#include "tests/support/program.h"

namespace skywave {
namespace {

using ProgressCli = Program;

constexpr char kSmall[] = "render spheres --size 24x16 --spp 4 -o a.exr --progress ";

TEST_F(ProgressCli, JsonHasOneObjectPerLineAndEndsComplete) {
  const Result result = Run(std::string(kSmall) + "json");
  ASSERT_EQ(result.exit_code, 0);
  std::istringstream lines(result.err);
  nlohmann::json last;
  for (std::string line; std::getline(lines, line);) {
    if (line.starts_with("note: ")) continue;
    last = nlohmann::json::parse(line);
    EXPECT_EQ(last.size(), 9u);
  }
  EXPECT_EQ(last.at("share"), 1);
  EXPECT_EQ(last.at("pictures_done"), 1);
}

TEST_F(ProgressCli, StepsOfPathsAreCounted) {
  const Result result =
      Run("paths spheres --size 8x8 --spp 1 --max-depth 1 -o p.exr --progress openjd");
  ASSERT_EQ(result.exit_code, 0) << result.err;
  EXPECT_NE(result.out.find("openjd_progress: 100.0\n"), std::string::npos) << result.out;
  EXPECT_NE(result.out.find("openjd_status: 1 of 9, "), std::string::npos) << result.out;
}

TEST_F(ProgressCli, OpenJobDescriptionGetsAFailure) {
  const Result result = Run("render missing.ply --progress openjd");
  EXPECT_NE(result.exit_code, 0);
  EXPECT_TRUE(result.out.starts_with("openjd_fail: missing.ply: ")) << result.out;
  EXPECT_EQ(Run("render missing.ply").out, "");
  EXPECT_EQ(Run("render missing.ply -q --progress openjd").out, "");
}

TEST_F(ProgressCli, QuietWins) {
  for (const std::string form : {"bar", "plain", "json", "openjd"}) {
    const Result result = Run(kSmall + form + " -q");
    EXPECT_EQ(result.exit_code, 0);
    EXPECT_EQ(result.out + result.err, "") << form;
  }
}

TEST_F(ProgressCli, ABarIsClearedAtTheEnd) {
  const std::string err = Run(std::string(kSmall) + "bar").err;
  EXPECT_NE(err.find("\r\033[K[...................."), std::string::npos) << err;
  EXPECT_TRUE(err.ends_with("\r\033[K")) << err;
}

class GrantedCli : public Program {
 protected:
  void TearDown() override {
    unsetenv("CUE_THREADS");
    Program::TearDown();
  }
  nlohmann::json Settings(const std::string& options) {
    const Result result =
        Run("render spheres --size 8x8 --spp 1 -o a.exr --stats s.json " + options);
    EXPECT_EQ(result.exit_code, 0) << result.err;
    text_ = result.out + result.err;
    return nlohmann::json::parse(Bytes("s.json")).at("settings");
  }
  std::string text_;
};

TEST_F(GrantedCli, ThreadsAreThoseOfTheFarm) {
  setenv("CUE_THREADS", "1", 1);
  EXPECT_NE(Run("--version").out.find("\nthreads: 1 (CUE_THREADS)\n"), std::string::npos);
  nlohmann::json settings = Settings("");
  EXPECT_EQ(settings.at("threads"), 1);
  EXPECT_EQ(settings.at("threads_from"), "CUE_THREADS");
  EXPECT_NE(text_.find(" 1 threads (CUE_THREADS)\n"), std::string::npos) << text_;
  settings = Settings("--threads 3");
  EXPECT_EQ(settings.at("threads"), 3);
  EXPECT_EQ(settings.at("threads_from"), "option");
}

TEST_F(GrantedCli, ABadGrantIsNoted) {
  setenv("CUE_THREADS", "all", 1);
  Settings("");
  EXPECT_NE(text_.find("note: CUE_THREADS=all "), std::string::npos) << text_;
}

}  // namespace
}  // namespace skywave
