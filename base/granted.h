// How many threads and how much memory the process may use: what the machine has, or less where a
// scheduler or a container grants less.
#pragma once

#include <cstddef>
#include <functional>
#include <string>
#include <vector>

namespace skywave {

struct Granted {
  int threads = 1;
  std::string threads_from;  // whose limit it is: "machine", or as in "SLURM_CPUS_PER_TASK"
  std::size_t memory_bytes = 0;
  std::string memory_from;         // likewise
  std::vector<std::string> notes;  // one for each value that was ignored because it is invalid

  // Returns whether there are fewer threads than the processors that the process may run on.
  bool limits_threads() const { return threads_from != "machine"; }
};

// Returns the value of a variable, or null.
using Environment = std::function<const char*(const char* name)>;

// Returns the least of what the machine has (`processors` that the process may run on, bytes of
// memory), of the limits of the control groups that the files under `root` describe (cpu.max and
// memory.max of version 2, cpu.cfs_quota_us and memory.limit_in_bytes of version 1, of the group of
// the process and of all groups around it), and of what Slurm and OpenCue say in `environment`
// (SLURM_CPUS_PER_TASK, CUE_THREADS; SLURM_MEM_PER_NODE or SLURM_MEM_PER_CPU [MiB], CUE_MEMORY
// [KiB]). A part of a processor counts as one. A grant is a limit, so nothing here is ever more
// than the machine has.
Granted FindGranted(const std::string& root, const Environment& environment, int processors,
                    std::size_t memory_bytes);

// Returns what this process is granted, as found at the first call.
const Granted& GrantedHere();

// Returns `wanted`, or the granted number of threads where that is 0.
int ThreadsFor(int wanted);

}  // namespace skywave
