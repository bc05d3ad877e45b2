#include "bench/measure/copies.h"

#include <fmt/format.h>
#include <poll.h>
#include <sched.h>
#include <signal.h>
#include <sys/mman.h>
#include <sys/prctl.h>
#include <sys/wait.h>
#include <unistd.h>

#include <algorithm>
#include <atomic>
#include <cerrno>
#include <cstdio>
#include <fstream>
#include <new>

#include "base/error.h"

namespace skywave {

// Lies in memory that all copies share.
struct CopyCounts {
  std::atomic<int> arrived = 0;   // at all meetings so far
  std::atomic<int> finished = 0;  // with all measurements so far
};
static_assert(std::atomic<int>::is_always_lock_free, "copies count in shared memory");

namespace {

[[noreturn]] void FailCopies(const std::string& reason, int exit_code = kExitIo) {
  throw InputError(InputPosition::File("--copies"), reason, exit_code);
}

class SharedMemory {
 public:
  SharedMemory()
      : bytes_(::mmap(nullptr, sizeof(CopyCounts), PROT_READ | PROT_WRITE,
                      MAP_SHARED | MAP_ANONYMOUS, -1, 0)) {
    if (bytes_ == MAP_FAILED) FailCopies("there is no shared memory");
    new (bytes_) CopyCounts;
  }
  SharedMemory(const SharedMemory&) = delete;
  SharedMemory& operator=(const SharedMemory&) = delete;
  ~SharedMemory() { ::munmap(bytes_, sizeof(CopyCounts)); }
  CopyCounts& counts() { return *static_cast<CopyCounts*>(bytes_); }

 private:
  void* bytes_;
};

bool Pin(int processor) {
  cpu_set_t set;
  CPU_ZERO(&set);
  CPU_SET(processor, &set);
  return ::sched_setaffinity(0, sizeof set, &set) == 0;
}

void WriteAll(int file, const std::string& text) {
  for (std::size_t at = 0; at < text.size();) {
    const ssize_t written = ::write(file, text.data() + at, text.size() - at);
    if (written <= 0) return;
    at += std::size_t(written);
  }
}

// The life of a copy. It ends without running what the parent's exit would run.
[[noreturn]] void BeCopy(int file, pid_t parent, std::optional<int> processor, CopyCounts& counts,
                         int copies, int copy, const CopyWork& work) {
  ::prctl(PR_SET_PDEATHSIG, SIGKILL);
  if (::getppid() != parent) ::_exit(kExitIo);
  // The first byte says whether it is pinned.
  WriteAll(file, processor && Pin(*processor) ? "p" : "-");
  try {
    CopyBarrier barrier(counts, copies, copy);
    WriteAll(file, work(barrier));
    ::_exit(0);
  } catch (const InputError& error) {
    WriteAll(file, error.what());
    ::_exit(error.exit_code());
  } catch (const std::exception& error) {
    WriteAll(file, error.what());
    ::_exit(kExitIo);
  }
}

struct RunningCopy {
  pid_t process = -1;
  int file = -1;  // the end to read
};

void EndCopies(std::vector<RunningCopy>& copies) {
  for (RunningCopy& copy : copies) {
    if (copy.process > 0) {
      ::kill(copy.process, SIGKILL);
      ::waitpid(copy.process, nullptr, 0);
    }
    if (copy.file >= 0) ::close(copy.file);
    copy = {};
  }
}

// Appends what can be read of `file` without waiting to `text`. Returns false at its end.
bool ReadMore(int file, std::string& text) {
  char bytes[4096];
  const ssize_t count = ::read(file, bytes, sizeof bytes);
  if (count > 0) text.append(bytes, std::size_t(count));
  return count > 0 || (count < 0 && errno == EINTR);
}

// Returns an empty text if the copy has ended well, else what was wrong with it.
std::string Failure(int status, const std::string& text) {
  if (WIFSIGNALED(status)) return fmt::format("ended by signal {}", WTERMSIG(status));
  if (text.empty()) return "ended before it began";
  return WEXITSTATUS(status) == 0 ? "" : text.substr(1);
}

}  // namespace

void CopyBarrier::Meet() {
  ++meetings_;
  counts_.arrived.fetch_add(1);
  while (counts_.arrived.load() < meetings_ * copies_) ::usleep(200);
}

bool CopyBarrier::Finish() {
  if (!waits_) {
    ++parts_;
    counts_.finished.fetch_add(1);
  }
  waits_ = counts_.finished.load() < parts_ * copies_;
  return !waits_;
}

std::vector<int> ProcessorsByCore() {
  cpu_set_t set;
  CPU_ZERO(&set);
  std::vector<int> firsts, others;
  if (::sched_getaffinity(0, sizeof set, &set) != 0) return firsts;
  for (int processor = 0; processor < CPU_SETSIZE; ++processor) {
    if (!CPU_ISSET(processor, &set)) continue;
    // The list begins with the lowest number: "0,64" or "0-1".
    std::ifstream file(
        fmt::format("/sys/devices/system/cpu/cpu{}/topology/thread_siblings_list", processor));
    int first = processor;
    file >> first;
    (!file || first == processor ? firsts : others).push_back(processor);
  }
  firsts.insert(firsts.end(), others.begin(), others.end());
  return firsts;
}

std::vector<std::size_t> PartsOfCopy(int copy, std::size_t parts, bool rotate) {
  std::vector<std::size_t> order(parts);
  for (std::size_t i = 0; i < parts; ++i) order[i] = (i + (rotate ? std::size_t(copy) : 0)) % parts;
  return order;
}

std::vector<CopyResult> RunCopies(int copies, std::span<const int> processors,
                                  const CopyWork& work) {
  SharedMemory memory;
  std::vector<RunningCopy> running(static_cast<std::size_t>(copies));
  std::vector<CopyResult> results(running.size());
  std::fflush(nullptr);  // each copy would write once more what is buffered
  const pid_t parent = ::getpid();
  for (std::size_t i = 0; i < running.size(); ++i) {
    if (!processors.empty()) results[i].processor = processors[i % processors.size()];
    int ends[2];
    const bool piped = ::pipe(ends) == 0;
    const pid_t process = piped ? ::fork() : -1;
    if (process == 0) {
      ::close(ends[0]);
      BeCopy(ends[1], parent, results[i].processor, memory.counts(), copies, int(i), work);
    }
    if (piped) ::close(ends[1]);
    running[i] = {process, piped ? ends[0] : -1};
    if (process > 0) continue;
    EndCopies(running);
    FailCopies(fmt::format("process {} cannot be started", i + 1));
  }
  std::vector<std::string> texts(running.size());
  for (std::size_t left = running.size(); left > 0;) {
    std::vector<pollfd> files;
    for (const RunningCopy& copy : running) files.push_back({copy.file, POLLIN, 0});
    ::poll(files.data(), files.size(), -1);
    for (std::size_t i = 0; i < running.size(); ++i) {
      if (running[i].file < 0 || files[i].revents == 0) continue;
      if (ReadMore(running[i].file, texts[i])) continue;
      int status = 0;
      ::waitpid(running[i].process, &status, 0);
      ::close(running[i].file);
      running[i] = {};
      --left;
      if (const std::string failure = Failure(status, texts[i]); !failure.empty()) {
        EndCopies(running);
        FailCopies(fmt::format("copy {}: {}", i + 1, failure),
                   WIFEXITED(status) && WEXITSTATUS(status) != 0 ? WEXITSTATUS(status) : kExitIo);
      }
      if (texts[i][0] != 'p') results[i].processor.reset();
      results[i].text = texts[i].substr(1);
    }
  }
  return results;
}

}  // namespace skywave
