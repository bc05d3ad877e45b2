// Runs `skywave probe` in a folder of its own that holds a small map, sun.exr.
#pragma once

#include <gtest/gtest.h>
#include <sys/wait.h>
#include <unistd.h>

#include <cstdlib>
#include <filesystem>
#include <string>

#include "base/files.h"
#include "image/image.h"
#include "tests/support/light_test_maps.h"
#include "tests/support/paths.h"

namespace skywave {

class ProbeCommand : public testing::Test {
 protected:
  void SetUp() override {
    folder_ = std::filesystem::temp_directory_path() /
              ("skywave_probe_" + std::to_string(getpid()) + "_" +
               testing::UnitTest::GetInstance()->current_test_info()->name());
    std::filesystem::create_directories(folder_);
    WriteExr(File("sun.exr"), test::SunMap(64, 32, 1000));
  }
  void TearDown() override { std::filesystem::remove_all(folder_); }
  std::string File(const std::string& name) const { return (folder_ / name).string(); }
  // Returns the exit code; both streams are written to out_.
  int Probe(const std::string& arguments) {
    const int status = std::system(("cd '" + folder_.string() + "' && " + ProgramPath() +
                                    " probe " + arguments + " > out.txt 2>&1")
                                       .c_str());
    out_ = ReadFile(File("out.txt"));
    return WEXITSTATUS(status);
  }

  std::filesystem::path folder_;
  std::string out_;
};

}  // namespace skywave
