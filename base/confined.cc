#include "base/confined.h"

#include <fmt/format.h>
#include <linux/audit.h>
#include <linux/filter.h>
#include <linux/seccomp.h>
#include <sys/mman.h>
#include <sys/prctl.h>
#include <sys/resource.h>
#include <sys/syscall.h>
#include <sys/wait.h>
#include <unistd.h>

#include <algorithm>
#include <cerrno>
#include <chrono>
#include <csignal>
#include <cstddef>
#include <cstdint>
#include <cstring>
#include <exception>
#include <fstream>
#include <iterator>
#include <new>
#include <stdexcept>
#include <string>
#include <string_view>
#include <thread>

namespace skywave {
namespace {

// What the child reports. It may be anything if the input has taken over the child.
struct Report {
  enum State : std::uint32_t { kRunning, kDone, kThrew, kNotConfined };
  std::uint32_t state;
  char message[1020];
};

// System calls that give and take memory, and those by which locks and signals work; sanitizers ask
// for the stack of signals where an exception is thrown.
constexpr unsigned kAllowedCalls[] = {
    SYS_mmap,        SYS_munmap, SYS_mremap,      SYS_brk,          SYS_madvise,
    SYS_mprotect,    SYS_futex,  SYS_sched_yield, SYS_rt_sigreturn, SYS_rt_sigprocmask,
    SYS_sigaltstack, SYS_exit,   SYS_exit_group};

// Every other call fails with EPERM, and calls of another instruction set kill.
bool ForbidSystemCalls() {
#if defined(__x86_64__)
  constexpr std::size_t kCalls = std::size(kAllowedCalls);
  sock_filter filter[kCalls + 6] = {
      BPF_STMT(BPF_LD | BPF_W | BPF_ABS, offsetof(seccomp_data, arch)),
      BPF_JUMP(BPF_JMP | BPF_JEQ | BPF_K, AUDIT_ARCH_X86_64, 1, 0),
      BPF_STMT(BPF_RET | BPF_K, SECCOMP_RET_KILL_PROCESS),
      BPF_STMT(BPF_LD | BPF_W | BPF_ABS, offsetof(seccomp_data, nr))};
  for (std::size_t i = 0; i < kCalls; ++i) {
    const auto to_allow = static_cast<unsigned char>(kCalls - i);
    filter[4 + i] = BPF_JUMP(BPF_JMP | BPF_JEQ | BPF_K, kAllowedCalls[i], to_allow, 0);
  }
  filter[kCalls + 4] = BPF_STMT(BPF_RET | BPF_K, SECCOMP_RET_ERRNO | EPERM);
  filter[kCalls + 5] = BPF_STMT(BPF_RET | BPF_K, SECCOMP_RET_ALLOW);
  sock_fprog program = {.len = static_cast<unsigned short>(kCalls + 6), .filter = filter};
  return prctl(PR_SET_NO_NEW_PRIVS, 1, 0, 0, 0) == 0 &&
         prctl(PR_SET_SECCOMP, SECCOMP_MODE_FILTER, &program) == 0;
#else
  return false;
#endif
}

// Returns the size of the address space [bytes].
std::size_t AddressSpace() {
  std::size_t pages = 0;
  std::ifstream("/proc/self/statm") >> pages;
  return pages * std::size_t(sysconf(_SC_PAGESIZE));
}

// A process that needs more than `most` is told, and stopped where it needs still more.
void Limit(__rlimit_resource resource, std::size_t most) {
  const rlimit limit = {.rlim_cur = most, .rlim_max = most + 1};
  setrlimit(resource, &limit);
}

void Say(Report& report, Report::State state, std::string_view message) {
  const std::size_t length = std::min(message.size(), sizeof report.message - 1);
  std::copy_n(message.data(), length, report.message);
  report.state = state;
}

[[noreturn]] void RunInChild(const ConfinedLimits& limits, std::size_t address_space,
                             const std::function<void()>& work, Report& report) {
  prctl(PR_SET_PDEATHSIG, SIGKILL);
  for (const int signal :
       {SIGSEGV, SIGBUS, SIGABRT, SIGFPE, SIGILL, SIGINT, SIGTERM, SIGHUP, SIGXCPU}) {
    ::signal(signal, SIG_DFL);
  }
  Limit(RLIMIT_AS, address_space + limits.memory_bytes);
  Limit(RLIMIT_CPU, std::size_t(limits.seconds));
  Limit(RLIMIT_CORE, 0);
  if (!ForbidSystemCalls()) {
    Say(report, Report::kNotConfined, "");
    _exit(1);
  }
  try {
    work();
    report.state = Report::kDone;
  } catch (const std::exception& error) {
    Say(report, Report::kThrew, error.what());
  } catch (...) {
    Say(report, Report::kThrew, "an unknown exception");
  }
  _exit(0);
}

// Waits for the child, which may hang on a lock that another thread held when it was made: it has
// kPatience times its processor time.
constexpr int kPatience = 4;
int WaitFor(pid_t child, int seconds) {
  using namespace std::chrono;
  const auto deadline = steady_clock::now() + std::chrono::seconds(kPatience * seconds);
  int status = 0;
  for (auto pause = microseconds(100); waitpid(child, &status, WNOHANG) == 0;
       pause = std::min(2 * pause, microseconds(5000))) {
    if (steady_clock::now() > deadline) kill(child, SIGKILL);
    std::this_thread::sleep_for(pause);
  }
  return status;
}

}  // namespace

SharedMemory::SharedMemory(std::size_t bytes) : bytes_(std::max<std::size_t>(bytes, 1)) {
  void* const memory =
      mmap(nullptr, bytes_, PROT_READ | PROT_WRITE, MAP_SHARED | MAP_ANONYMOUS, -1, 0);
  if (memory == MAP_FAILED) throw std::bad_alloc();
  data_ = static_cast<std::byte*>(memory);
}
SharedMemory::~SharedMemory() { munmap(data_, bytes_); }

void RunConfined(const ConfinedLimits& limits, const std::function<void()>& work) {
  const SharedMemory shared(sizeof(Report));
  auto& report = *reinterpret_cast<Report*>(shared.data());
  const std::size_t address_space = AddressSpace();
  const pid_t child = fork();
  if (child < 0) throw std::runtime_error(fmt::format("cannot fork: {}", std::strerror(errno)));
  if (child == 0) RunInChild(limits, address_space, work, report);
  const int status = WaitFor(child, limits.seconds);
  if (report.state == Report::kDone) return;
  report.message[sizeof report.message - 1] = 0;
  if (report.state == Report::kThrew) throw std::runtime_error(report.message);
  if (report.state == Report::kNotConfined) {
    throw CannotConfine("this system cannot confine processes (seccomp)");
  }
  if (!WIFSIGNALED(status)) throw std::runtime_error("its process ended without a result");
  const int signal = WTERMSIG(status);
  if (signal == SIGXCPU) {
    throw std::runtime_error(
        fmt::format("it takes more than {} s of processor time", limits.seconds));
  }
  if (signal == SIGKILL) {
    throw std::runtime_error(
        fmt::format("its process did not end within {} s", kPatience * limits.seconds));
  }
  throw std::runtime_error(fmt::format("its process ended with signal {}", signal));
}

}  // namespace skywave
