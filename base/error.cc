#include "base/error.h"

#include <fmt/format.h>

namespace skywave {
namespace {

// "photons 0, caustic-photons 0"
std::string Listed(const std::vector<OptionValue>& options) {
  std::string text;
  for (const OptionValue& option : options) {
    if (!text.empty()) text += ", ";
    text += option.name;
    if (!option.value.empty()) text += ' ' + option.value;
  }
  return text;
}

}  // namespace

std::string ToString(const InputPosition& position) {
  if (position.line > 0) return fmt::format("{}:{}", position.path, position.line);
  if (position.has_offset) return fmt::format("{} (byte {})", position.path, position.offset);
  return position.path;
}

InputError::InputError(const InputPosition& position, const std::string& reason, int exit_code)
    : std::runtime_error(position.path.empty() ? reason : ToString(position) + ": " + reason),
      exit_code_(exit_code),
      place_(position.path.empty() ? "" : ToString(position)),
      reason_(reason) {}

OptionError::OptionError(std::vector<OptionValue> options, const std::string& why)
    : InputError(InputPosition::File(Listed(options)), why, kExitUsage),
      options_(std::move(options)),
      why_(why) {}

}  // namespace skywave
