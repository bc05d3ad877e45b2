// Runs the program as a user does, in a separate folder for every test.
#pragma once

#include <gtest/gtest.h>
#include <sys/wait.h>
#include <unistd.h>

#include <cstdlib>
#include <filesystem>
#include <set>
#include <string>

#include "base/files.h"
#include "tests/support/paths.h"

namespace skywave {

class Program : public testing::Test {
 protected:
  struct Result {
    int exit_code;  // -1: killed by a signal
    std::string out, err;
  };

  void SetUp() override {
    const testing::TestInfo* const test = testing::UnitTest::GetInstance()->current_test_info();
    folder_ = testing::TempDir() + "skywave_" + std::to_string(::getpid()) + "_" + test->name();
    std::filesystem::create_directories(folder_ + "/files");
  }
  void TearDown() override { std::filesystem::remove_all(folder_); }

  // Runs `skywave arguments` in the test's folder. The shell splits the arguments.
  Result Run(const std::string& arguments) const {
    return Shell("'" + ProgramPath() + "' " + arguments);
  }

  // Runs a command of the shell there.
  Result Shell(const std::string& line) const {
    const std::string command =
        "cd '" + folder_ + "/files' || exit; { " + line + "; } >../out 2>../err </dev/null";
    const int status = std::system(command.c_str());
    return {WIFEXITED(status) ? WEXITSTATUS(status) : -1, ReadFile(folder_ + "/out"),
            ReadFile(folder_ + "/err")};
  }

  // Returns the path of a file in the folder in which the program runs.
  std::string Path(const std::string& name) const { return folder_ + "/files/" + name; }
  std::string Bytes(const std::string& name) const { return ReadFile(Path(name)); }
  void Put(const std::string& name, const std::string& bytes) const {
    WriteFileAtomically(Path(name), bytes);
  }
  std::set<std::string> Files() const {
    std::set<std::string> names;
    for (const auto& entry : std::filesystem::directory_iterator(folder_ + "/files")) {
      names.insert(entry.path().filename().string());
    }
    return names;
  }

 private:
  std::string folder_;
};

}  // namespace skywave
