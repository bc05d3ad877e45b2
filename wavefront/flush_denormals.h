// Denormals count as zero while rays are traced and shaded, as Embree advises.
#pragma once

#include <pmmintrin.h>
#include <xmmintrin.h>

namespace skywave {

// Flushes denormals on this thread until it is destroyed. Every thread of a frame does so, because
// the bits of an image depend on it.
class FlushDenormals {
 public:
  FlushDenormals() : saved_(_mm_getcsr()) {
    _MM_SET_FLUSH_ZERO_MODE(_MM_FLUSH_ZERO_ON);
    _MM_SET_DENORMALS_ZERO_MODE(_MM_DENORMALS_ZERO_ON);
  }
  ~FlushDenormals() { _mm_setcsr(saved_); }
  FlushDenormals(const FlushDenormals&) = delete;
  FlushDenormals& operator=(const FlushDenormals&) = delete;

 private:
  unsigned saved_;
};

}  // namespace skywave
