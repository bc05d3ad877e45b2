#include "base/error.h"

#include <fmt/format.h>

namespace skywave {

std::string ToString(const InputPosition& position) {
  if (position.line > 0) return fmt::format("{}:{}", position.path, position.line);
  if (position.has_offset) return fmt::format("{} (byte {})", position.path, position.offset);
  return position.path;
}

InputError::InputError(const InputPosition& position, const std::string& reason, int exit_code)
    : std::runtime_error(position.path.empty() ? reason : ToString(position) + ": " + reason),
      exit_code_(exit_code) {}

}  // namespace skywave
