// Memory of tables that take megabytes. In huge pages the first writes fault once every 2 MiB
// rather than every 4 KiB, and threads do not wait for each other meanwhile
// (docs/decisions/2026-11-23-huge-pages.md).
#pragma once

#include <cstddef>
#include <vector>

namespace skywave {

// Asks for huge pages in memory that has just been allocated and is not written yet. It stays as it
// is where the system has none.
void AdviseHugePages(void* memory, std::size_t bytes);

// Returns the whole pages of a block to the system; they read as zeros afterwards.
void GivePagesBack(void* memory, std::size_t bytes);

// Returns whole pages that malloc keeps without need to the system, of all its arenas; some
// milliseconds.
void ReturnFreeMemory();

// Resizes an empty vector to `count` zeros in such memory.
template <class T>
void ResizeLarge(std::vector<T>& values, std::size_t count) {
  values.reserve(count);
  AdviseHugePages(values.data(), count * sizeof(T));
  values.resize(count);
}

}  // namespace skywave
