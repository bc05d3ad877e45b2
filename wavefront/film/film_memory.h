// The memory of a film's columns. It can be larger than the machine's, as long as only a part of it
// is in use: pages take memory from the first write on, until they are given back.
#pragma once

#include <cstddef>
#include <cstdlib>
#include <new>
#include <span>
#include <utility>
#include <vector>

#include "base/large_memory.h"

namespace skywave {

// Gives zeros without writing them. Values that a vector makes without arguments are left as they
// are given, so a vector must not shrink and grow again.
template <class T>
struct ZeroPages {
  using value_type = T;
  ZeroPages() = default;
  template <class U>
  ZeroPages(const ZeroPages<U>&) {}  // NOLINT: allocators convert
  T* allocate(std::size_t count) {
    void* const memory = std::calloc(count, sizeof(T));
    if (memory == nullptr) throw std::bad_alloc();
    AdviseHugePages(memory, count * sizeof(T));
    return static_cast<T*>(memory);
  }
  void deallocate(T* memory, std::size_t) { std::free(memory); }
  template <class U>
  void construct(U*) {}
  template <class U, class... Args>
  void construct(U* at, Args&&... args) {
    ::new (static_cast<void*>(at)) U(std::forward<Args>(args)...);
  }
  friend bool operator==(const ZeroPages&, const ZeroPages&) { return true; }
};
static_assert(alignof(std::max_align_t) >= alignof(unsigned __int128));

template <class T>
using FilmValues = std::vector<T, ZeroPages<T>>;

// Frees the whole pages of these values, which then read as zeros.
template <class T>
void GiveBack(std::span<T> values) {
  GivePagesBack(values.data(), values.size_bytes());
}

}  // namespace skywave
