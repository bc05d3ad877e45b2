// A read position in a binary file that cannot leave its bytes: every overrun is an InputError with
// the byte offset. All readers in this folder use it.
#pragma once

#include <cstddef>
#include <cstdint>
#include <string>
#include <string_view>

#include "base/error.h"

namespace skywave {

class ByteCursor {
 public:
  // Both arguments must outlive the cursor.
  ByteCursor(const std::string& path, std::string_view bytes, std::size_t offset = 0)
      : path_(path), bytes_(bytes), offset_(offset) {}

  std::size_t offset() const { return offset_; }  // [bytes] from the start of the file
  std::size_t left() const { return bytes_.size() - offset_; }
  // Throws an InputError at the current offset.
  [[noreturn]] void Fail(const std::string& reason) const {
    throw InputError(InputPosition::Byte(path_, offset_), reason);
  }

  // Returns the next `count` bytes. `what` names them in the error.
  std::string_view Take(std::size_t count, const char* what) {
    if (count > left()) Fail(std::string("the file ends within ") + what);
    const std::string_view taken = bytes_.substr(offset_, count);
    offset_ += count;
    return taken;
  }
  // Returns the bytes before the next `end`, at most `max_length`; `end` itself is skipped.
  std::string_view TakeUntil(char end, std::size_t max_length, const char* what) {
    const std::string_view window = bytes_.substr(offset_, max_length + 1);
    const std::size_t length = window.find(end);
    if (length == std::string_view::npos) {
      if (window.size() <= max_length) Fail(std::string("the file ends within ") + what);
      Fail(std::string(what) + " has more than " + std::to_string(max_length) + " bytes");
    }
    offset_ += length + 1;
    return window.substr(0, length);
  }
  // Read little-endian numbers.
  std::uint8_t U8(const char* what) { return std::uint8_t(Take(1, what)[0]); }
  std::uint16_t U16(const char* what) { return std::uint16_t(LittleEndian(2, what)); }
  std::uint32_t U32(const char* what) { return std::uint32_t(LittleEndian(4, what)); }
  std::int32_t I32(const char* what) { return std::int32_t(U32(what)); }
  std::uint64_t U64(const char* what) { return LittleEndian(8, what); }

 private:
  std::uint64_t LittleEndian(int count, const char* what) {
    const std::string_view taken = Take(count, what);
    std::uint64_t value = 0;
    for (int i = count; i-- > 0;) value = value << 8 | std::uint8_t(taken[i]);
    return value;
  }

  const std::string& path_;
  std::string_view bytes_;
  std::size_t offset_;
};

}  // namespace skywave
