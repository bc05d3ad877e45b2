// Runs code that must not be trusted with its input, such as a library with known holes, in a
// process of its own that can do nothing but compute.
#pragma once

#include <cstddef>
#include <functional>
#include <stdexcept>

namespace skywave {

struct ConfinedLimits {
  std::size_t memory_bytes = 0;  // beyond what the process has already
  int seconds = 0;               // of processor time
};

// Memory that a confined process shares with this one: zeros at first.
class SharedMemory {
 public:
  explicit SharedMemory(std::size_t bytes);  // throws std::bad_alloc
  ~SharedMemory();
  SharedMemory(const SharedMemory&) = delete;
  SharedMemory& operator=(const SharedMemory&) = delete;
  std::byte* data() const { return data_; }

 private:
  std::byte* data_;
  std::size_t bytes_;
};

// The system cannot confine processes: it has no seccomp, or another architecture.
struct CannotConfine : std::runtime_error {
  using std::runtime_error::runtime_error;
};

// Runs `work` in a child of this process and waits for it. The child sees the memory of this
// process as it is now, and what it writes stays its own, but for SharedMemory. It may ask the
// system for memory and for nothing else: no files, no network, no processes. Throws
// std::runtime_error with what was wrong: what `work` threw, a crash or a limit; or CannotConfine.
void RunConfined(const ConfinedLimits& limits, const std::function<void()>& work);

}  // namespace skywave
