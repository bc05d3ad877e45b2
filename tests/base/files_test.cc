// Tests what writers of files leave behind when they are killed.
#include "base/files.h"

#include <gtest/gtest.h>
#include <sys/wait.h>
#include <unistd.h>

#include <csignal>
#include <filesystem>
#include <fstream>
#include <string>
#include <vector>

#include "tests/support/temporary_folder.h"

namespace skywave {
namespace {

// Starts a process that writes half of `path` and then waits to be killed. Returns its number.
pid_t StartStuckWriter(const std::string& path) {
  int ready[2];
  EXPECT_EQ(::pipe(ready), 0);
  const pid_t child = ::fork();
  if (child == 0) {
    WriteFileAtomically(path, [&](const std::string& temporary) {
      std::ofstream(temporary, std::ios::binary) << "half of it";
      [[maybe_unused]] const ssize_t told = ::write(ready[1], "x", 1);
      for (;;) ::pause();
    });
  }
  char told = 0;
  EXPECT_EQ(::read(ready[0], &told, 1), 1);
  ::close(ready[0]), ::close(ready[1]);
  return child;
}

TEST(Leftovers, AreRemovedOnceTheirWriterIsDeadAndNotBefore) {
  const TemporaryFolder folder;
  const std::string target = folder.Write("a.exr", "the old one");
  const std::vector<std::string> targets = {target, folder.Path("b.exr")};
  const pid_t writer = StartStuckWriter(target);
  const std::string temporary = target + "." + std::to_string(writer) + ".part";
  ASSERT_TRUE(std::filesystem::exists(temporary));
  EXPECT_EQ(RemoveLeftovers(targets), 0u);
  EXPECT_TRUE(std::filesystem::exists(temporary));

  ::kill(writer, SIGKILL);
  ::waitpid(writer, nullptr, 0);
  EXPECT_EQ(RemoveLeftovers(targets), 1u);
  EXPECT_FALSE(std::filesystem::exists(temporary));
  EXPECT_EQ(ReadFile(target), "the old one");
}

TEST(Leftovers, OfOtherTargetsAndOtherNamesStay) {
  const TemporaryFolder folder;
  for (const char* const name : {"other.exr.77.part", "a.exr.part", "a.exr.7x.part", "a.exr.77"}) {
    folder.Write(name, "kept");
  }
  folder.Write("a.exr.77.part", "left over");
  EXPECT_EQ(RemoveLeftovers(std::vector<std::string>{folder.Path("a.exr")}), 1u);
  EXPECT_EQ(std::distance(std::filesystem::directory_iterator(folder.Path(".")), {}), 4);
}

}  // namespace
}  // namespace skywave
