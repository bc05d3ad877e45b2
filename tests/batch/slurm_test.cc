// Tests the scripts for Slurm as texts, and by running them with stand-ins for Slurm's commands.
#include "job/batch/slurm.h"

#include <gtest/gtest.h>
#include <sys/wait.h>

#include <cstdlib>
#include <filesystem>
#include <map>
#include <sstream>

#include "base/files.h"
#include "tests/support/temporary_folder.h"

namespace skywave {
namespace {

SlurmPlan PlanOf(const std::string& folder, std::uint32_t shards) {
  return {.name = "batch-1",
          .program = "echo",
          .directory = folder,
          .folder = folder + "/it's a 100% farm",
          .batch = " 'my job.toml'",
          .pictures = {{"a.exr", " gallery --spp 10", 10},
                       {"b c.exr", " spheres --spp 3", 3, " --half"}},
          .shards = shards};
}

// The scripts of a plan in its folder, where they can be run.
class Scripts : public testing::Test {
 protected:
  void Write(const SlurmPlan& plan) {
    std::filesystem::create_directories(plan.folder);
    for (const SlurmScript& script : SlurmScripts(plan)) {
      texts_[script.name] = script.text;
      WriteFileAtomically(plan.folder + "/" + script.name, script.text);
    }
    plan_folder_ = plan.folder;
  }
  // Runs a script. Returns what it prints; its exit code is in `code_`.
  std::string Run(const std::string& name, const std::string& environment = "") {
    const std::string out = folder_.Path("out");
    const std::string command =
        environment + " bash \"" + plan_folder_ + "/" + name + "\" >" + out + " 2>&1";
    const int status = std::system(command.c_str());
    code_ = WIFEXITED(status) ? WEXITSTATUS(status) : -1;
    return ReadFile(out);
  }
  // Makes a command that scripts find before others.
  void Command(const std::string& name, const std::string& text) {
    std::filesystem::create_directories(folder_.Path("bin"));
    const std::string path = folder_.Path("bin/" + name);
    WriteFileAtomically(path, "#!/bin/bash\n" + text + "\n");
    std::filesystem::permissions(path, std::filesystem::perms::owner_all);
  }
  std::string Bin() const { return "PATH=" + folder_.Path("bin") + ":$PATH"; }

  TemporaryFolder folder_;
  std::string plan_folder_;
  std::map<std::string, std::string> texts_;
  int code_ = 0;
};

std::vector<std::string> Lines(const std::string& text) {
  std::istringstream stream(text);
  std::vector<std::string> lines;
  for (std::string line; std::getline(stream, line);) lines.push_back(line);
  return lines;
}

using SlurmScriptsTest = Scripts;

TEST_F(SlurmScriptsTest, AreValidBash) {
  for (const std::uint32_t shards : {1u, 4u}) {
    Write(PlanOf(folder_.Path(""), shards));
    for (const auto& [name, text] : texts_) {
      EXPECT_EQ(std::system(("bash -n \"" + plan_folder_ + "/" + name + "\"").c_str()), 0) << name;
      EXPECT_TRUE(text.starts_with("#!/bin/bash\n")) << name;
    }
  }
}

TEST_F(SlurmScriptsTest, ATaskIsAShareOfThePictures) {
  Write(PlanOf(folder_.Path(""), 1));
  EXPECT_NE(texts_.at("render.sh").find("#SBATCH --array=1-2\n"), std::string::npos);
  EXPECT_EQ(Run("render.sh", "SLURM_ARRAY_TASK_ID=2"), "batch my job.toml --only 2/2\n");
  EXPECT_EQ(Run("finish.sh"), "batch my job.toml\n");
}

TEST_F(SlurmScriptsTest, PartsAreEverySampleOnce) {
  Write(PlanOf(folder_.Path(""), 4));
  EXPECT_NE(texts_.at("render.sh").find("#SBATCH --array=1-7\n"), std::string::npos);
  std::map<std::string, std::vector<std::string>> ranges;  // by scene
  std::string films;
  for (int task = 1; task <= 7; ++task) {
    std::istringstream words(Run("render.sh", "SLURM_ARRAY_TASK_ID=" + std::to_string(task)));
    std::string word, scene;
    words >> word >> scene;
    EXPECT_EQ(word, "render");
    while (words >> word && word != "--sample-range") {
    }
    words >> word;
    ranges[scene].push_back(word);
  }
  EXPECT_EQ(ranges.at("gallery"), (std::vector<std::string>{"0:2", "2:5", "5:7", "7:10"}));
  EXPECT_EQ(ranges.at("spheres"), (std::vector<std::string>{"0:1", "1:2", "2:3"}));
  const std::vector<std::string> finish = Lines(Run("finish.sh"));
  ASSERT_EQ(finish.size(), 3u);
  EXPECT_TRUE(finish[0].starts_with("merge ") && finish[0].ends_with(" -o a.exr")) << finish[0];
  EXPECT_TRUE(finish[1].ends_with(" --half -o b c.exr")) << finish[1];
  EXPECT_EQ(finish[2], "batch my job.toml");
}

TEST_F(SlurmScriptsTest, FinishedPartsAreNotRenderedAgain) {
  SlurmPlan plan = PlanOf(folder_.Path(""), 2);
  // Makes the file after --film, or the picture after -o.
  Command("render",
          "echo \"$1\"; while [[ $# -gt 1 ]]; do "
          "[[ $1 == --film || $1 == -o ]] && touch \"$2\"; shift; done");
  plan.program = folder_.Path("bin/render");
  Write(plan);
  const std::string all =
      "for i in 1 2 3 4; do SLURM_ARRAY_TASK_ID=$i bash \"" + plan_folder_ + "/render.sh\"; done;";
  EXPECT_EQ(Run("finish.sh", all), "merge\nmerge\nbatch\n");
  EXPECT_EQ(Run("render.sh", "SLURM_ARRAY_TASK_ID=3"), "");
  EXPECT_EQ(Run("finish.sh"), "batch\n");
  plan.pictures[1].options += " --seed 3";
  Write(plan);
  EXPECT_EQ(Run("render.sh", "SLURM_ARRAY_TASK_ID=1"), "");
  EXPECT_EQ(Run("render.sh", "SLURM_ARRAY_TASK_ID=3"), "render\n");
}

TEST_F(SlurmScriptsTest, AStoppedTaskIsQueuedAgainAndAFailedOneIsNot) {
  SlurmPlan plan = PlanOf(folder_.Path(""), 1);
  plan.program = folder_.Path("bin/render");
  Command("scontrol", "echo \"$@\"");
  Command("sleep", "true");
  const std::string task = Bin() + " SLURM_ARRAY_JOB_ID=9 SLURM_ARRAY_TASK_ID=2";
  Command("render", "exit 75");
  Write(plan);
  EXPECT_EQ(Run("render.sh", task), "requeue 9_2\n");
  EXPECT_EQ(code_, 75);
  Command("render", "exit 65");
  EXPECT_EQ(Run("render.sh", task), "");
  EXPECT_EQ(code_, 65);
  // SIGTERM goes to the script, as from Slurm, and reaches the program, which ends as it likes.
  Command("render",
          "trap 'echo stopped; exit 75' TERM; kill -TERM $PPID; for i in {1..200}; do "
          "/bin/sleep 0.05; done");
  EXPECT_EQ(Run("render.sh", task), "stopped\nrequeue 9_2\n");
  EXPECT_EQ(code_, 75);
  Command("render", "kill -TERM $PPID; /bin/sleep 0.3; exit 0");
  // One that was killed before it could save anything begins again.
  EXPECT_NE(Run("render.sh", task).find("requeue 9_2\n"), std::string::npos);
  EXPECT_EQ(code_, 75);
}

TEST_F(SlurmScriptsTest, ManyPicturesShareTasks) {
  SlurmPlan plan = PlanOf(folder_.Path(""), 2);
  plan.pictures.assign(700, {"a.exr", " gallery", 4});
  Write(plan);
  EXPECT_NE(texts_.at("render.sh").find("#SBATCH --array=1-1000\n"), std::string::npos);
  EXPECT_EQ(Lines(Run("render.sh", "SLURM_ARRAY_TASK_ID=400")).size(), 2u);
  EXPECT_EQ(Lines(Run("render.sh", "SLURM_ARRAY_TASK_ID=401")).size(), 1u);
}

TEST_F(SlurmScriptsTest, SubmitsOnceWithTheOptionsOfTheUser) {
  Write(PlanOf(folder_.Path(""), 1));
  Command("sbatch", "printf '[%s]' \"$@\" >&2; echo >&2; echo '12;cluster'");
  Command("squeue", "true");
  const std::vector<std::string> lines = Lines(Run("submit.sh", Bin()));
  ASSERT_EQ(lines.size(), 3u);
  EXPECT_NE(lines[0].find("/it's a 100%% farm/logs/render_%a.txt]"), std::string::npos);
  EXPECT_NE(lines[1].find("[--dependency=afterok:12]"), std::string::npos);
  EXPECT_EQ(lines[2], "submitted 12, then 12");
  Command("squeue", "echo 11");
  EXPECT_EQ(Run("submit.sh", Bin()), "is queued already: 11 \n");
}

}  // namespace
}  // namespace skywave
