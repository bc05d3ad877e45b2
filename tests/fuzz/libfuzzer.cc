// The entry point of clang's libFuzzer for the reader that the build names in SKYWAVE_FUZZ_READER.
#include <algorithm>
#include <cstdlib>

#include "tests/fuzz/readers.h"

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  static const auto readers = skywave::FuzzedReaders();
  static const auto reader = std::find_if(
      readers.begin(), readers.end(), [](const auto& r) { return r.name == SKYWAVE_FUZZ_READER; });
  if (reader == readers.end()) std::abort();
  skywave::FuzzOnce(*reader, {reinterpret_cast<const char*>(data), size});
  return 0;
}
