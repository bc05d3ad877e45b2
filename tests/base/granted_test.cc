// Tests the limits of threads and memory on made-up machines.
#include "base/granted.h"

#include <gtest/gtest.h>

#include <map>

#include "base/files.h"
#include "tests/support/temporary_folder.h"

namespace skywave {
namespace {

constexpr std::size_t kMib = 1 << 20;

// A machine of 16 processors and 64 GiB.
class Machine : public testing::Test {
 protected:
  void Put(const std::string& name, const std::string& text) {
    const std::string path = folder_.Path(name);
    std::filesystem::create_directories(std::filesystem::path(path).parent_path());
    WriteFileAtomically(path, text);
  }
  Granted Find(const std::map<std::string, std::string>& variables = {}) const {
    return FindGranted(
        folder_.Path(""),
        [&](const char* name) {
          const auto found = variables.find(name);
          return found == variables.end() ? nullptr : found->second.c_str();
        },
        16, 65536 * kMib);
  }

 private:
  TemporaryFolder folder_;
};

void ExpectThreads(const Granted& granted, int threads, const std::string& from) {
  EXPECT_EQ(granted.threads, threads);
  EXPECT_EQ(granted.threads_from, from);
  EXPECT_TRUE(granted.notes.empty());
}
void ExpectMemory(const Granted& granted, std::size_t mib, const std::string& from) {
  EXPECT_EQ(granted.memory_bytes, mib * kMib);
  EXPECT_EQ(granted.memory_from, from);
}

using GrantedTest = Machine;

TEST_F(GrantedTest, WithoutLimitsTheMachineIsGranted) {
  ExpectThreads(Find(), 16, "machine");
  ExpectMemory(Find(), 65536, "machine");
  EXPECT_FALSE(Find().limits_threads());
}

TEST_F(GrantedTest, SchedulersLowerTheGrant) {
  ExpectThreads(Find({{"SLURM_CPUS_PER_TASK", "4"}}), 4, "SLURM_CPUS_PER_TASK");
  ExpectThreads(Find({{"CUE_THREADS", "3"}}), 3, "CUE_THREADS");
  ExpectThreads(Find({{"SLURM_CPUS_PER_TASK", "4"}, {"CUE_THREADS", "3"}}), 3, "CUE_THREADS");
  ExpectThreads(Find({{"SLURM_CPUS_PER_TASK", "64"}}), 16, "machine");
  ExpectMemory(Find({{"SLURM_MEM_PER_NODE", "2000"}}), 2000, "SLURM_MEM_PER_NODE");
  ExpectMemory(Find({{"SLURM_MEM_PER_NODE", "0"}}), 65536, "machine");
  ExpectMemory(Find({{"SLURM_MEM_PER_CPU", "500"}, {"SLURM_CPUS_ON_NODE", "4"}}), 2000,
               "SLURM_MEM_PER_CPU");
  ExpectMemory(Find({{"CUE_MEMORY", "2048"}}), 2, "CUE_MEMORY");
}

TEST_F(GrantedTest, InvalidValuesAreIgnoredWithANote) {
  for (const std::string bad : {"", "0", "-2", "four", "4(x2)", "1e3", "99999999999999999999"}) {
    const Granted granted = Find({{"SLURM_CPUS_PER_TASK", bad}});
    EXPECT_EQ(granted.threads, 16) << bad;
    ASSERT_EQ(granted.notes.size(), 1u) << bad;
    EXPECT_NE(granted.notes[0].find("SLURM_CPUS_PER_TASK=" + bad), std::string::npos);
  }
  EXPECT_EQ(Find({{"CUE_MEMORY", "lots"}}).notes.size(), 1u);
}

TEST_F(GrantedTest, ControlGroupsOfVersionTwo) {
  Put("proc/self/cgroup", "0::/jobs/render\n");
  Put("sys/fs/cgroup/jobs/render/cpu.max", "max 100000\n");
  Put("sys/fs/cgroup/jobs/render/memory.max", "max\n");
  ExpectThreads(Find(), 16, "machine");
  Put("sys/fs/cgroup/jobs/cpu.max", "250000 100000\n");  // of the group around it
  Put("sys/fs/cgroup/jobs/memory.max", "1073741824\n");
  ExpectThreads(Find(), 3, "cgroup cpu.max");
  ExpectMemory(Find(), 1024, "cgroup memory.max");
  ExpectThreads(Find({{"CUE_THREADS", "2"}}), 2, "CUE_THREADS");
}

TEST_F(GrantedTest, APartOfAProcessorIsOneThread) {
  Put("proc/self/cgroup", "0::/\n");
  Put("sys/fs/cgroup/cpu.max", "20000 100000\n");
  ExpectThreads(Find(), 1, "cgroup cpu.max");
  Put("sys/fs/cgroup/cpu.max", "200000 100000\n");
  ExpectThreads(Find(), 2, "cgroup cpu.max");
}

TEST_F(GrantedTest, ControlGroupsOfVersionOne) {
  Put("proc/self/cgroup", "4:memory:/box\n3:cpuset:/\n2:cpu,cpuacct:/box\n0::/\nrubbish\n");
  Put("sys/fs/cgroup/cpu,cpuacct/box/cpu.cfs_quota_us", "450000\n");
  Put("sys/fs/cgroup/cpu,cpuacct/box/cpu.cfs_period_us", "100000\n");
  Put("sys/fs/cgroup/memory/box/memory.limit_in_bytes", "9223372036854771712\n");
  ExpectThreads(Find(), 5, "cgroup cpu.cfs_quota_us");
  ExpectMemory(Find(), 65536, "machine");
  Put("sys/fs/cgroup/cpu,cpuacct/box/cpu.cfs_quota_us", "-1\n");
  ExpectThreads(Find(), 16, "machine");
  // A container sees its own group as the outermost one.
  Put("proc/self/cgroup", "4:memory:/docker/0123\n");
  Put("sys/fs/cgroup/memory/memory.limit_in_bytes", "2147483648\n");
  ExpectMemory(Find(), 2048, "cgroup memory.limit_in_bytes");
}

TEST(GrantedHere, IsPositiveAndTheDefaultOfThreads) {
  EXPECT_GE(GrantedHere().threads, 1);
  EXPECT_GT(GrantedHere().memory_bytes, 100 * kMib);
  EXPECT_EQ(ThreadsFor(7), 7);
  EXPECT_EQ(ThreadsFor(0), GrantedHere().threads);
}

}  // namespace
}  // namespace skywave
