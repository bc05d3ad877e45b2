// Tests what writers of files leave behind when they are killed or fail.
#include "base/files.h"

#include <gtest/gtest.h>
#include <sys/wait.h>
#include <unistd.h>

#include <csignal>
#include <filesystem>
#include <fstream>
#include <functional>
#include <stdexcept>
#include <string>
#include <vector>

#include "base/error.h"
#include "tests/support/temporary_folder.h"

namespace skywave {
namespace {

void RemoveAndEnd(int) {
  RemoveUnfinishedFiles();
  ::_exit(0);
}

// Returns the exit code of a process in which `run` is called. RemoveUnfinishedFiles is the last
// that a process does with files, so it is called in one of its own.
int ExitCodeOf(const std::function<int()>& run) {
  const pid_t process = ::fork();
  if (process == 0) ::_exit(run());
  int status = 0;
  EXPECT_EQ(::waitpid(process, &status, 0), process);
  return WIFEXITED(status) ? WEXITSTATUS(status) : -1;
}

// A process that writes half of `path`, calls `meanwhile` and then waits to be killed; SIGTERM
// makes it remove its unfinished files. It ends with its test at the latest.
class StuckWriter {
 public:
  explicit StuckWriter(
      const std::string& path, const std::function<void()>& meanwhile = [] {}) {
    int ready[2];
    EXPECT_EQ(::pipe(ready), 0);
    process_ = ::fork();
    if (process_ == 0) {
      ::signal(SIGTERM, RemoveAndEnd);
      WriteFileAtomically(path, [&](const std::string& temporary) {
        std::ofstream(temporary, std::ios::binary) << "half of it";
        meanwhile();
        [[maybe_unused]] const ssize_t told = ::write(ready[1], "x", 1);
        for (;;) ::pause();
      });
    }
    temporary_ = path + "." + std::to_string(process_) + ".part";
    char told = 0;
    EXPECT_EQ(::read(ready[0], &told, 1), 1);
    ::close(ready[0]), ::close(ready[1]);
  }
  ~StuckWriter() { End(SIGKILL); }
  StuckWriter(const StuckWriter&) = delete;
  StuckWriter& operator=(const StuckWriter&) = delete;

  void End(int signal) {
    if (process_ <= 0) return;
    ::kill(process_, signal);
    ::waitpid(process_, nullptr, 0);
    process_ = 0;
  }
  const std::string& temporary() const { return temporary_; }

 private:
  pid_t process_;
  std::string temporary_;
};

TEST(Leftovers, AreRemovedOnlyOnceTheirWriterIsDead) {
  const TemporaryFolder folder;
  const std::string target = folder.Write("a.exr", "the old one");
  const std::vector<std::string> targets = {target, folder.Path("b.exr")};
  StuckWriter writer(target);
  ASSERT_TRUE(std::filesystem::exists(writer.temporary()));
  EXPECT_EQ(RemoveLeftovers(targets), 0u);
  EXPECT_TRUE(std::filesystem::exists(writer.temporary()));

  writer.End(SIGKILL);
  EXPECT_EQ(RemoveLeftovers(targets), 1u);
  EXPECT_FALSE(std::filesystem::exists(writer.temporary()));
  EXPECT_EQ(ReadFile(target), "the old one");
}

TEST(Leftovers, CheckingATargetRemovesThem) {
  const TemporaryFolder folder;
  const std::string leftover = folder.Write("a.exr.77.part", "left over");
  const std::string other = folder.Write("b.exr.77.part", "another's");
  CheckWritable(folder.Path("a.exr"));
  EXPECT_FALSE(std::filesystem::exists(leftover));
  EXPECT_TRUE(std::filesystem::exists(other));
}

TEST(Leftovers, CheckingSeveralOutputsRemovesThem) {
  const TemporaryFolder folder;
  folder.Write("a.exr.77.part", "left over"), folder.Write("a.png.77.part", "left over");
  const std::vector<std::string> outputs = {folder.Path("a.exr"), "", folder.Path("a.png"),
                                            "/dev/null"};
  CheckAllWritable(outputs);
  EXPECT_TRUE(std::filesystem::is_empty(folder.Path(".")));
  const std::vector<std::string> bad = {folder.Path("a.exr"), folder.Path("none/a.png")};
  EXPECT_THROW(CheckAllWritable(bad), InputError);
}

TEST(Unfinished, FilesAreRemovedByAHandlerOfSignals) {
  const TemporaryFolder folder;
  const std::string target = folder.Write("a.exr", "the old one");
  StuckWriter writer(target, [&] {
    // A process that was forked while its parent writes leaves the file.
    const pid_t forked = ::fork();
    if (forked == 0) RemoveAndEnd(0);
    ::waitpid(forked, nullptr, 0);
  });
  ASSERT_TRUE(std::filesystem::exists(writer.temporary()));
  writer.End(SIGTERM);
  EXPECT_FALSE(std::filesystem::exists(writer.temporary()));
  EXPECT_EQ(ReadFile(target), "the old one");
}

TEST(Unfinished, FilesThatAreFinishedStay) {
  const TemporaryFolder folder;
  EXPECT_EQ(ExitCodeOf([&] {
              for (int i = 0; i < 100; ++i) {  // more than are known at once
                WriteFileAtomically(folder.Path(std::to_string(i)), "all of it");
              }
              RemoveUnfinishedFiles();
              return 0;
            }),
            0);
  EXPECT_EQ(std::distance(std::filesystem::directory_iterator(folder.Path(".")), {}), 100);
}

// Another thread may be about to make a file when a handler has looked for those that there are.
TEST(Unfinished, FilesAreNotMadeOnceTheHandlerHasRemovedThem) {
  const TemporaryFolder folder;
  EXPECT_EQ(ExitCodeOf([&] {
              RemoveUnfinishedFiles();
              try {
                WriteFileAtomically(folder.Path("a.exr"), "the new one");
              } catch (const InputError&) {
                return 7;
              }
              return 0;
            }),
            7);
  EXPECT_TRUE(std::filesystem::is_empty(folder.Path(".")));
}

TEST(BeforeRename, AFailureLeavesTheOldFile) {
  const TemporaryFolder folder;
  const std::string target = folder.Write("a.exr", "the old one");
  const auto write = [](const std::string& temporary) {
    std::ofstream(temporary, std::ios::binary) << "the new one";
  };
  EXPECT_THROW(WriteFileAtomically(target, write, [] { throw std::runtime_error("no room"); }),
               InputError);
  EXPECT_EQ(ReadFile(target), "the old one");
  EXPECT_EQ(std::distance(std::filesystem::directory_iterator(folder.Path(".")), {}), 1);
  // The other file is replaced while this one is still the old one.
  WriteFileAtomically(target, write, [&] { EXPECT_EQ(ReadFile(target), "the old one"); });
  EXPECT_EQ(ReadFile(target), "the new one");
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

// A file may have any name that the file system takes.
TEST(LongNames, FilesBesideThemHaveTheirStart) {
  EXPECT_EQ(NameBeside("a/b.c/d.e.exr", ".checkpoint"), "a/b.c/d.e.checkpoint");
  EXPECT_EQ(NameBeside("d", ".checkpoint"), "d.checkpoint");
  const std::string longest(244, 'a');
  EXPECT_EQ(NameBeside("a/" + longest + ".exr", ".checkpoint"), "a/" + longest + ".checkpoint");
  const std::string one = NameBeside("a/" + longest + "b.exr", ".checkpoint");
  EXPECT_EQ(one.size(), 2 + 255u);
  EXPECT_EQ(one.find("a/" + longest.substr(0, 200)), 0u);
  EXPECT_TRUE(one.ends_with(".checkpoint"));
  EXPECT_NE(one, NameBeside("a/" + longest + "c.exr", ".checkpoint"));
}

TEST(LongNames, AreWrittenAndCleanedUpAsOthers) {
  const TemporaryFolder folder;
  const std::string stem(250, 'a');
  const std::string targets[] = {folder.Path(stem + "b.exr"), folder.Path(stem + "c.exr")};
  for (const std::string& target : targets) {
    CheckWritable(target);
    WriteFileAtomically(target, "of " + target);
  }
  for (const std::string& target : targets) EXPECT_EQ(ReadFile(target), "of " + target);
  // The leftover of one of them is not that of the other one.
  StuckWriter writer(targets[0]);
  const auto files = [&] {
    return std::distance(std::filesystem::directory_iterator(folder.Path(".")), {});
  };
  writer.End(SIGKILL);
  ASSERT_EQ(files(), 3);
  EXPECT_EQ(RemoveLeftovers({&targets[1], 1}), 0u);
  EXPECT_EQ(RemoveLeftovers({&targets[0], 1}), 1u);
  EXPECT_EQ(files(), 2);
}

}  // namespace
}  // namespace skywave
