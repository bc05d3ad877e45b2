#include "base/granted.h"

#include <fmt/format.h>
#include <sched.h>
#include <unistd.h>

#include <algorithm>
#include <charconv>
#include <cstdint>
#include <cstdlib>
#include <fstream>
#include <optional>
#include <sstream>
#include <string_view>
#include <thread>

namespace skywave {
namespace {

std::optional<std::int64_t> WholeNumber(std::string_view text) {
  std::int64_t value;
  const auto [end, error] = std::from_chars(text.data(), text.data() + text.size(), value);
  if (error != std::errc() || end != text.data() + text.size()) return std::nullopt;
  return value;
}

// Returns the words of a file's first line; none if there is no such file.
std::vector<std::string> FirstWords(const std::string& path) {
  std::ifstream file(path);
  std::string line;
  std::getline(file, line);
  std::istringstream words(line);
  std::vector<std::string> found;
  for (std::string word; words >> word;) found.push_back(word);
  return found;
}

// A group of the process, as a line of /proc/self/cgroup gives it: "ID:CONTROLLERS:/PATH".
struct ControlGroup {
  std::string controllers;  // empty: version 2
  std::string path;
};

std::vector<ControlGroup> ControlGroups(const std::string& root) {
  std::ifstream file(root + "/proc/self/cgroup");
  std::vector<ControlGroup> groups;
  for (std::string line; std::getline(file, line);) {
    const std::size_t first = line.find(':');
    if (first == std::string::npos) continue;
    const std::size_t second = line.find(':', first + 1);
    if (second == std::string::npos) continue;
    groups.push_back({line.substr(first + 1, second - first - 1), line.substr(second + 1)});
  }
  return groups;
}

bool Controls(const ControlGroup& group, std::string_view controller) {
  std::istringstream names(group.controllers);
  for (std::string name; std::getline(names, name, ',');) {
    if (name == controller) return true;
  }
  return false;
}

// Calls `read` with the folders of a group and of all groups around it. A container may see its own
// group as the outermost one while the path is the host's; then only that one is there.
template <class Read>
void ForEachFolder(const std::string& mount, std::string path, const Read& read) {
  while (!path.empty() && path != "/") {
    read(mount + path);
    path.erase(path.rfind('/'));
  }
  read(mount);
}

class Finder {
 public:
  Finder(const std::string& root, const Environment& environment, Granted& granted)
      : root_(root), environment_(environment), granted_(granted) {}
  void Find() {
    for (const ControlGroup& group : ControlGroups(root_)) ReadGroup(group);
    ReadThreads("SLURM_CPUS_PER_TASK");
    ReadThreads("CUE_THREADS");
    ReadMemory("SLURM_MEM_PER_NODE", 1 << 20, 1);
    ReadMemory("SLURM_MEM_PER_CPU", 1 << 20, SlurmProcessors());
    ReadMemory("CUE_MEMORY", 1 << 10, 1);
  }

 private:
  void LimitThreads(std::int64_t threads, const std::string& from) {
    if (threads >= granted_.threads) return;
    granted_.threads = int(threads);
    granted_.threads_from = from;
  }
  void LimitMemory(double bytes, const std::string& from) {
    if (bytes >= double(granted_.memory_bytes)) return;
    granted_.memory_bytes = std::size_t(bytes);
    granted_.memory_from = from;
  }

  // `quota` and `period` are microseconds of processors in microseconds of time.
  void LimitQuota(const std::string& quota, const std::string& period, const std::string& from) {
    const std::optional<std::int64_t> part = WholeNumber(quota), whole = WholeNumber(period);
    if (!part || !whole || *part <= 0 || *whole <= 0) return;  // "max" and -1: no limit
    LimitThreads(1 + (*part - 1) / *whole, from);
  }
  void LimitGroupMemory(const std::string& path, const std::string& from) {
    const std::vector<std::string> words = FirstWords(path);
    if (words.empty()) return;
    if (const auto bytes = WholeNumber(words[0]); bytes && *bytes > 0) {
      LimitMemory(double(*bytes), from);
    }
  }

  void ReadGroup(const ControlGroup& group) {
    const std::string cgroups = root_ + "/sys/fs/cgroup";
    if (group.controllers.empty()) {
      // Where both versions are in use, the second one is mounted below the first.
      for (const std::string& mount : {cgroups, cgroups + "/unified"}) {
        ForEachFolder(mount, group.path, [&](const std::string& folder) {
          const std::vector<std::string> words = FirstWords(folder + "/cpu.max");
          if (words.size() == 2) LimitQuota(words[0], words[1], "cgroup cpu.max");
          LimitGroupMemory(folder + "/memory.max", "cgroup memory.max");
        });
      }
      return;
    }
    const auto each = [&](std::string_view controller, const auto& read) {
      if (!Controls(group, controller)) return;
      const std::string own = fmt::format("{}/{}", cgroups, controller);
      ForEachFolder(own, group.path, read);
      const std::string together = fmt::format("{}/{}", cgroups, group.controllers);
      if (together != own) ForEachFolder(together, group.path, read);
    };
    each("cpu", [&](const std::string& folder) {
      const auto quota = FirstWords(folder + "/cpu.cfs_quota_us");
      const auto period = FirstWords(folder + "/cpu.cfs_period_us");
      if (!quota.empty() && !period.empty()) {
        LimitQuota(quota[0], period[0], "cgroup cpu.cfs_quota_us");
      }
    });
    each("memory", [&](const std::string& folder) {
      LimitGroupMemory(folder + "/memory.limit_in_bytes", "cgroup memory.limit_in_bytes");
    });
  }

  // Returns the whole number that a variable has, if it is at least `low`. Adds a note about an
  // invalid one.
  std::optional<std::int64_t> Variable(const char* name, std::int64_t low) {
    const char* const text = environment_(name);
    if (text == nullptr) return std::nullopt;
    const std::optional<std::int64_t> value = WholeNumber(text);
    if (value && *value >= low) return value;
    granted_.notes.push_back(
        fmt::format("{}={} is not a number of at least {}, and is ignored", name, text, low));
    return std::nullopt;
  }
  void ReadThreads(const char* name) {
    if (const auto threads = Variable(name, 1)) LimitThreads(*threads, name);
  }
  // Slurm writes 0 for all of a node's memory.
  void ReadMemory(const char* name, double unit, std::int64_t factor) {
    const auto amount = Variable(name, 0);
    if (amount && *amount > 0) LimitMemory(double(*amount) * unit * double(factor), name);
  }
  // Returns the number of processors for which Slurm grants memory.
  std::int64_t SlurmProcessors() {
    const std::size_t notes = granted_.notes.size();
    auto count = Variable("SLURM_CPUS_ON_NODE", 1);
    if (!count) count = Variable("SLURM_CPUS_PER_TASK", 1);
    granted_.notes.resize(notes);  // the one of them that limits threads has its note
    return count.value_or(1);
  }

  const std::string& root_;
  const Environment& environment_;
  Granted& granted_;
};

// Returns the number of processors that the process may run on, as its affinity mask says.
int Processors() {
  for (int size = 1024; size <= 1 << 20; size *= 2) {
    cpu_set_t* const set = CPU_ALLOC(size);
    const std::size_t bytes = CPU_ALLOC_SIZE(size);
    const int count = sched_getaffinity(0, bytes, set) == 0 ? CPU_COUNT_S(bytes, set) : 0;
    CPU_FREE(set);
    if (count > 0) return count;
  }
  return std::max(1, int(std::thread::hardware_concurrency()));
}

}  // namespace

Granted FindGranted(const std::string& root, const Environment& environment, int processors,
                    std::size_t memory_bytes) {
  Granted granted = {.threads = processors,
                     .threads_from = "machine",
                     .memory_bytes = memory_bytes,
                     .memory_from = "machine"};
  Finder(root, environment, granted).Find();
  return granted;
}

const Granted& GrantedHere() {
  static const Granted granted = FindGranted(
      "", [](const char* name) { return std::getenv(name); }, Processors(),
      std::size_t(sysconf(_SC_PHYS_PAGES)) * std::size_t(sysconf(_SC_PAGE_SIZE)));
  return granted;
}

int ThreadsFor(int wanted) { return wanted > 0 ? wanted : GrantedHere().threads; }

}  // namespace skywave
