#include "base/error.h"

#include <fmt/format.h>

#include <algorithm>
#include <string_view>

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

// Returns a message without control codes, in lines: what follows the first one is indented by two
// blanks, and a name that it holds begins no line like a message does.
std::string Message(std::string_view text) {
  constexpr std::string_view kNextLine = "\n  ";
  std::string clean;
  for (std::size_t end; (end = text.find(kNextLine)) != text.npos;) {
    clean += WithoutControlCodes(std::string(text.substr(0, end))).append(kNextLine);
    text.remove_prefix(end + kNextLine.size());
  }
  return clean + WithoutControlCodes(std::string(text));
}

// Returns the number of bytes of the first character, or 0 if these are not UTF-8 (RFC 3629).
std::size_t LengthOfCharacter(std::string_view text) {
  const auto byte = [&](std::size_t i) {
    return i < text.size() ? static_cast<unsigned char>(text[i]) : 0u;
  };
  const unsigned first = byte(0);
  if (first < 0x80) return 1;
  if (first < 0xc2 || first > 0xf4) return 0;
  const std::size_t length = first < 0xe0 ? 2 : first < 0xf0 ? 3 : 4;
  for (std::size_t i = 1; i < length; ++i) {
    if ((byte(i) & 0xc0) != 0x80) return 0;
  }
  // Longer than need be, half of a pair of UTF-16, or beyond the last character.
  const bool wrong = (first == 0xe0 && byte(1) < 0xa0) || (first == 0xed && byte(1) >= 0xa0) ||
                     (first == 0xf0 && byte(1) < 0x90) || (first == 0xf4 && byte(1) >= 0x90);
  return wrong ? 0 : length;
}

}  // namespace

std::string WithoutControlCodes(std::string text) {
  std::string clean;
  for (std::size_t i = 0; i < text.size();) {
    const std::size_t length = LengthOfCharacter(std::string_view(text).substr(i));
    const auto byte = static_cast<unsigned char>(text[i]);
    // In UTF-8, the codes from 0x80 to 0x9f begin with 0xc2.
    const bool second = byte == 0xc2 && static_cast<unsigned char>(text[i + 1]) < 0xa0;
    const bool shown = length > 0 && !second && byte != 0x7f && byte >= 0x20;
    clean += shown ? text.substr(i, length) : "?";
    i += std::max<std::size_t>(length, 1);
  }
  return clean;
}

std::string ToString(const InputPosition& position) {
  if (position.line > 0) return fmt::format("{}:{}", position.path, position.line);
  if (position.has_offset) return fmt::format("{} (byte {})", position.path, position.offset);
  return position.path;
}

InputError::InputError(const InputPosition& position, const std::string& reason, int exit_code)
    : std::runtime_error(
          Message(position.path.empty() ? reason : ToString(position) + ": " + reason)),
      exit_code_(exit_code),
      place_(position.path.empty() ? "" : ToString(position)),
      reason_(Message(reason)) {}

InputError InputError::NoSuchFile(const InputPosition& position, const std::string& name) {
  InputError error(position, fmt::format("there is no file \"{}\"", name), kExitIo);
  error.missing_file_ = name;
  return error;
}

OptionError::OptionError(std::vector<OptionValue> options, const std::string& why)
    : InputError(InputPosition::File(Listed(options)), why, kExitUsage),
      options_(std::move(options)),
      why_(why) {}

}  // namespace skywave
