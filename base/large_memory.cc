#include "base/large_memory.h"

#include <malloc.h>
#include <sys/mman.h>
#include <unistd.h>

#include <cstdint>

namespace skywave {
namespace {

// Advises the system about the whole pages of a block. If it declines, nothing changes.
void AdvisePages(void* memory, std::size_t bytes, int advice) {
  const auto page = std::size_t(sysconf(_SC_PAGESIZE));
  const std::size_t before = (page - reinterpret_cast<std::uintptr_t>(memory) % page) % page;
  if (before >= bytes) return;
  const std::size_t whole = (bytes - before) / page * page;
  if (whole > 0) madvise(static_cast<std::byte*>(memory) + before, whole, advice);
}

}  // namespace

void AdviseHugePages(void* memory, std::size_t bytes) {
  constexpr std::size_t kHugePage = std::size_t{2} << 20;
  if (bytes >= kHugePage) AdvisePages(memory, bytes, MADV_HUGEPAGE);
}

void GivePagesBack(void* memory, std::size_t bytes) { AdvisePages(memory, bytes, MADV_DONTNEED); }

void ReturnFreeMemory() { malloc_trim(0); }

}  // namespace skywave
