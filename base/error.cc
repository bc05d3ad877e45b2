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

std::string WithoutControlCodes(std::string text) {
  for (std::size_t i = 0; i < text.size(); ++i) {
    const auto byte = static_cast<unsigned char>(text[i]);
    // In UTF-8, the codes from 0x80 to 0x9f begin with 0xc2.
    const bool second =
        i > 0 && static_cast<unsigned char>(text[i - 1]) == 0xc2 && byte >= 0x80 && byte < 0xa0;
    if (second) text[i - 1] = '?';
    if (byte < 0x20 || byte == 0x7f || second) text[i] = '?';
  }
  return text;
}

std::string ToString(const InputPosition& position) {
  if (position.line > 0) return fmt::format("{}:{}", position.path, position.line);
  if (position.has_offset) return fmt::format("{} (byte {})", position.path, position.offset);
  return position.path;
}

InputError::InputError(const InputPosition& position, const std::string& reason, int exit_code)
    : std::runtime_error(
          WithoutControlCodes(position.path.empty() ? reason : ToString(position) + ": " + reason)),
      exit_code_(exit_code),
      place_(position.path.empty() ? "" : ToString(position)),
      reason_(WithoutControlCodes(reason)) {}

OptionError::OptionError(std::vector<OptionValue> options, const std::string& why)
    : InputError(InputPosition::File(Listed(options)), why, kExitUsage),
      options_(std::move(options)),
      why_(why) {}

}  // namespace skywave
