// Tests renders that are stopped, looked at, cut into parts or refused by the disk, from the
// outside.
#include <gtest/gtest.h>

#include <algorithm>
#include <csignal>
#include <cstdlib>
#include <nlohmann/json.hpp>
#include <string>

#include "base/error.h"
#include "image/formats.h"
#include "image/image.h"
#include "tests/support/program.h"

namespace skywave {
namespace {

class RenderStop : public Program {
 protected:
  // Runs lines of a shell in the folder of Run, with $skywave. Returns the exit code.
  int Shell(const std::string& lines) const {
    const std::string command =
        "cd '" + Path("") + "' && skywave='" + ProgramPath() + "'\n" + lines;
    const int status = std::system(command.c_str());
    return WIFEXITED(status) ? WEXITSTATUS(status) : -1;
  }
  // Runs `skywave arguments` in the background and `meanwhile`, which knows its $pid, once it
  // renders.
  int RunAnd(const std::string& arguments, const std::string& meanwhile) const {
    return Shell("$skywave " + arguments +
                 " --progress json >../out 2>../err </dev/null & pid=$!\n"
                 "while kill -0 $pid 2>/dev/null && ! grep -q '^{' ../err; do sleep 0.01; done\n" +
                 meanwhile + "\nwait $pid");
  }
  std::string Errors() const { return ReadFile(Path("../err")); }
  bool Exists(const std::string& name) const { return Files().contains(name); }
};

constexpr char kPicture[] = "render spheres --size 160x120 --spp 150 --aovs albedo ";

TEST_F(RenderStop, SignalsToEndSaveACheckpointToResume) {
  ASSERT_EQ(Run(std::string(kPicture) + "-o whole.exr -q").exit_code, 0);
  for (const std::string signal : {"TERM", "INT", "HUP"}) {
    SCOPED_TRACE(signal);
    const std::string command = std::string(kPicture) + "-o " + signal + ".exr ";
    EXPECT_EQ(RunAnd(command + "--checkpoint 0 --threads 1", "kill -" + signal + " $pid"),
              kExitTryAgain);
    EXPECT_NE(Errors().find(signal + ".checkpoint keeps what is rendered"), std::string::npos);
    EXPECT_NE(Errors().find("--resume"), std::string::npos);
    EXPECT_TRUE(Exists(signal + ".checkpoint"));
    EXPECT_FALSE(Exists(signal + ".exr"));

    Result other = Run(command + "--resume --max-depth 3");
    EXPECT_EQ(other.exit_code, kExitBadInput);
    EXPECT_NE(other.err.find(signal + ".checkpoint: this checkpoint is of something else: "
                                      "`max-depth` is 3 here and 10 there"),
              std::string::npos)
        << other.err;
    EXPECT_EQ(Run(command + "--resume -q").exit_code, 0);
    EXPECT_TRUE(Bytes(signal + ".exr") == Bytes("whole.exr"));
    EXPECT_TRUE(Bytes(signal + ".png") == Bytes("whole.png"));
  }
  EXPECT_EQ(Files(), (std::set<std::string>{"whole.exr", "whole.png", "TERM.exr", "TERM.png",
                                            "INT.exr", "INT.png", "HUP.exr", "HUP.png"}));
}

TEST_F(RenderStop, ASecondSignalOfEitherKindEndsTheProcess) {
  const int code = RunAnd(std::string(kPicture) + "--checkpoint 0 -o a.exr --threads 1",
                          "kill -INT $pid; kill -TERM $pid");
  // Either may be delivered first.
  EXPECT_TRUE(code == 128 + SIGTERM || code == 128 + SIGINT) << code << Errors();
}

TEST_F(RenderStop, StatisticsReportTheSamplesOfALimitedRender) {
  ASSERT_EQ(
      Run("render spheres --size 6x5 --spp 64 --noise 1e9 --stats s.json -q -o a.exr").exit_code,
      0);
  const auto json = nlohmann::json::parse(Bytes("s.json"));
  EXPECT_EQ(json.at("settings").at("samples_per_pixel"), 64);
  EXPECT_EQ(json.at("rendered_samples_per_pixel"), 8);  // the first look
  EXPECT_GE(json.at("noise").get<double>(), 0);
  const Result timed = Run("render spheres --size 6x5 --spp 100000 --time 0.01 -o b.exr");
  EXPECT_NE(timed.out.find(" of 100000 samples per pixel"), std::string::npos) << timed.out;
}

TEST_F(RenderStop, Sigusr1WritesASnapshotAndChangesNothing) {
  ASSERT_EQ(Run(std::string(kPicture) + "-o whole.exr -q").exit_code, 0);
  ASSERT_EQ(
      RunAnd(std::string(kPicture) + "-o a.exr --threads 1",
             "while kill -USR1 $pid 2>/dev/null && ! [ -e a.snapshot.exr ]; do sleep 0.05; done"),
      0)
      << Errors();
  ASSERT_TRUE(Exists("a.snapshot.exr") && Exists("a.snapshot.png"));
  EXPECT_TRUE(Bytes("a.exr") == Bytes("whole.exr"));
  const skywave::Image snapshot = ReadImage(Path("a.snapshot.exr"));
  EXPECT_EQ(snapshot.width, 160);
  EXPECT_GT(*std::max_element(snapshot.rgb.begin(), snapshot.rgb.end()), 0);
}

TEST_F(RenderStop, ASnapshotThatCannotBeWrittenIsANote) {
  ASSERT_EQ(RunAnd("render spheres --size 160x120 --spp 150 -o a.exr --threads 1",
                   "mkdir a.snapshot.exr; kill -USR1 $pid"),
            0)
      << Errors();
  EXPECT_NE(Errors().find("a.snapshot.exr: "), std::string::npos) << Errors();
  EXPECT_TRUE(Exists("a.exr"));
}

TEST_F(RenderStop, OutputsOfTheSameNameAreRefused) {
  const std::string small = "render spheres --size 8x8 --spp 1 -q ";
  for (const std::string names :
       {"--film a.checkpoint --resume", "-o a.exr --film a.exr", "-o a.exr --stats a.png"}) {
    EXPECT_EQ(Run(small + names).exit_code, kExitUsage) << names;
  }
  EXPECT_EQ(Files(), std::set<std::string>());
}

TEST_F(RenderStop, AFilmAloneHasNoFormatOfThePicture) {
  const std::string small = "render spheres --size 8x8 --spp 1 -q --film a.film ";
  for (const std::string format : {"--half", "--compression piz"}) {
    const Result run = Run(small + format);
    EXPECT_EQ(run.exit_code, kExitUsage) << format;
    EXPECT_NE(run.err.find("a film alone is written"), std::string::npos) << run.err;
    EXPECT_EQ(Files(), std::set<std::string>());
  }
}

TEST_F(RenderStop, PartsAreMergedToTheBytesOfOneRender) {
  const std::string picture = "render spheres --size 40x30 --spp 6 --tone filmic -q ";
  ASSERT_EQ(Run(picture + "-o whole.exr").exit_code, 0);
  ASSERT_EQ(Run(picture + "--sample-range 2:6 --film a.film").exit_code, 0);
  EXPECT_EQ(Files(), (std::set<std::string>{"whole.exr", "whole.png", "a.film"}));
  ASSERT_EQ(Run(picture + "--sample-range 0:2 --crop 40x13+0+0 --film b.film").exit_code, 0);
  ASSERT_EQ(Run(picture + "--sample-range 0:2 --crop 40x17+0+13 --film c.film -o c.exr --threads 1")
                .exit_code,
            0);
  EXPECT_TRUE(Exists("c.exr"));

  Result merged = Run("merge a.film c.film -o m.exr");
  EXPECT_EQ(merged.exit_code, kExitBadInput);
  EXPECT_NE(merged.err.find("no film holds crop 40x13+0+0 sample-range 0:2"), std::string::npos)
      << merged.err;
  EXPECT_FALSE(Exists("m.exr"));
  merged = Run("merge a.film c.film a.film -o m.exr");
  EXPECT_EQ(merged.exit_code, kExitBadInput);
  EXPECT_TRUE(merged.err.starts_with("skywave: a.film: ") || merged.err.starts_with("a.film: "))
      << merged.err;
  EXPECT_EQ(Run("merge a.film -o a.film").exit_code, kExitUsage);
  EXPECT_EQ(Run("merge a.film -o a.png").exit_code, kExitUsage);
  EXPECT_EQ(Run("merge a.film b.film c.film --sample-range 0:9 -o m.exr").exit_code, kExitUsage);

  ASSERT_EQ(Run("merge c.film a.film -o ca.film -q").exit_code, 0);
  ASSERT_EQ(Run("merge b.film ca.film -o m.exr -q").exit_code, 0);
  EXPECT_TRUE(Bytes("m.exr") == Bytes("whole.exr"));
  EXPECT_TRUE(Bytes("m.png") == Bytes("whole.png"));
  // A part is a picture as well.
  ASSERT_EQ(Run("merge c.film --crop 40x17+0+13 --sample-range 0:2 -o part.exr -q").exit_code, 0);
  EXPECT_TRUE(Bytes("part.exr") == Bytes("c.exr"));
  // The format is asked for where the picture is written.
  ASSERT_EQ(Run(picture + "--half -o half.exr").exit_code, 0);
  ASSERT_EQ(Run("merge b.film ca.film --half -o m.exr -q").exit_code, 0);
  EXPECT_TRUE(Bytes("m.exr") == Bytes("half.exr"));
  EXPECT_FALSE(Bytes("m.exr") == Bytes("whole.exr"));
}

TEST_F(RenderStop, ALimitOfTimeRecordsACommandThatRepeatsThePicture) {
  ASSERT_EQ(Run("render spheres --size 40x30 --spp 1000000 --time 0.1 -q -o a.exr").exit_code, 0);
  std::string command;
  for (const auto& [name, text] : ReadExrMetadata(Path("a.exr"))) {
    if (name == "command") command = text.substr(std::string("skywave ").size());
  }
  EXPECT_NE(command.find("--sample-range 0:"), std::string::npos) << command;
  ASSERT_EQ(Run(command + " -q -o b.exr").exit_code, 0);
  EXPECT_TRUE(Bytes("a.exr") == Bytes("b.exr"));
}

// Whatever goes wrong with a disk, the old file is there or the new one, and the error names it.
class Disk : public RenderStop {
 protected:
  // Expects `lines`, which run the program with `2>../err`, to fail because of `name`.
  void ExpectFails(const std::string& lines, const std::string& name) {
    EXPECT_EQ(Shell(lines), kExitIo) << Errors();
    EXPECT_NE(Errors().find(name), std::string::npos) << Errors();
    for (const std::string& file : Files()) EXPECT_FALSE(file.ends_with(".part")) << file;
  }
};

TEST_F(Disk, ALimitOfFileSizesLeavesTheOldFile) {
  ASSERT_EQ(Run("render spheres --size 8x8 --spp 1 -q -o a.exr --film a.film").exit_code, 0);
  const std::string picture = Bytes("a.exr"), film = Bytes("a.film");
  const std::string limited = "ulimit -f 150; $skywave ";
  const std::string large = "render spheres --size 160x120 --spp 40 -q ";
  ExpectFails(limited + large + "-o a.exr 2>../err", "a.exr: cannot be written: File too large");
  EXPECT_TRUE(Bytes("a.exr") == picture);
  ExpectFails(limited + large + "--film a.film 2>../err", "a.film: cannot be written");
  EXPECT_TRUE(Bytes("a.film") == film);
  // It takes longer than the time until the clock is checked. The picture is smaller than its
  // checkpoint, so it is written.
  EXPECT_EQ(Shell("ulimit -f 1000; $skywave " + std::string(kPicture) +
                  "--threads 1 --checkpoint 0.01 -o a.exr 2>../err"),
            0);
  EXPECT_NE(Errors().find("a.checkpoint: cannot be written"), std::string::npos) << Errors();
  EXPECT_FALSE(Bytes("a.exr") == picture);
  EXPECT_FALSE(Exists("a.checkpoint"));
}

TEST_F(Disk, AFullDiskAndOneForReadingOnlyAreNamed) {
  const std::string small = "$skywave render spheres --size 64x48 --spp 1 -q ";
  ExpectFails("ln -s /dev/full a.exr; " + small + "-o a.exr 2>../err", "a.exr: cannot be written");
  ExpectFails("ln -s /dev/full a.film; " + small + "--film a.film 2>../err",
              "a.film: cannot be written");
  ExpectFails(small + "-o /proc/a.exr 2>../err", "/proc/a.exr: cannot be written");
  ExpectFails(small + "-o b.exr --film /proc/a.film 2>../err", "/proc/a.film: cannot be written");
  EXPECT_FALSE(Exists("b.exr"));
}

TEST_F(Disk, AFullFileSystemLeavesTheOldFile) {
  if (Shell("mkdir full && mount -t tmpfs -o size=64k tmpfs full 2>/dev/null") != 0) {
    GTEST_SKIP() << "skipped: no file system can be mounted here";
  }
  EXPECT_EQ(Shell("$skywave render spheres --size 8x8 --spp 1 -q --film full/a.film"), 0);
  const std::string before = Bytes("full/a.film");
  ExpectFails("$skywave render spheres --size 160x120 --spp 1 -q --film full/a.film 2>../err",
              "full/a.film: cannot be written: No space left on device");
  EXPECT_TRUE(Bytes("full/a.film") == before);
  EXPECT_EQ(Shell("test \"$(ls full)\" = a.film"), 0);
  EXPECT_EQ(Shell("umount full"), 0);
}

}  // namespace
}  // namespace skywave
