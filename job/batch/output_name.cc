#include "job/batch/output_name.h"

#include <fmt/format.h>

#include <algorithm>
#include <cctype>
#include <charconv>
#include <cmath>
#include <cstdint>
#include <cstring>

namespace skywave {
namespace {

constexpr int kMostDigits = 30;

// Reads "04" or "06.2" after the colon of a place.
bool ParseFormat(std::string_view text, NamePiece& piece) {
  const char *next = text.data(), *const end = next + text.size();
  const auto number = [&](int& to) {
    const auto [stop, error] = std::from_chars(next, end, to);
    const bool good = error == std::errc() && stop != next && to >= 0 && to <= kMostDigits;
    next = stop;
    return good;
  };
  if (!text.starts_with('.') && !number(piece.width)) return false;
  if (next == end) return true;
  return *next++ == '.' && number(piece.digits) && next == end;
}

std::string ParsePlace(std::string_view place, NamePiece& piece) {
  const std::size_t colon = place.find(':');
  piece.place = true;
  piece.text = place.substr(0, colon);
  if (piece.text.empty()) return "has a place without a name";
  if (colon != std::string_view::npos && !ParseFormat(place.substr(colon + 1), piece)) {
    return fmt::format("has '{{{}}}', which should be like {{{}:04}} or {{{}:06.2}}", place,
                       piece.text, piece.text);
  }
  return "";
}

// Returns nothing for a value that is not a number.
std::optional<std::string> Padded(const std::string& value, const NamePiece& piece) {
  std::int64_t whole = 0;
  const char* const end = value.data() + value.size();
  if (const auto [stop, error] = std::from_chars(value.data(), end, whole);
      error == std::errc() && stop == end && piece.digits < 0) {
    return fmt::format("{:0{}}", whole, piece.width);
  }
  double number = 0;
  if (const auto [stop, error] = std::from_chars(value.data(), end, number);
      error != std::errc() || stop != end || !std::isfinite(number)) {
    return std::nullopt;
  }
  if (piece.digits >= 0) return fmt::format("{:0{}.{}f}", number, piece.width, piece.digits);
  return fmt::format("{:0{}}", number, piece.width);
}

}  // namespace

std::string ParseNamePattern(std::string_view pattern, std::vector<NamePiece>& pieces) {
  pieces.clear();
  std::string text;
  const auto end_text = [&] {
    if (!text.empty()) pieces.push_back({.text = text});
    text.clear();
  };
  for (std::size_t i = 0; i < pattern.size(); ++i) {
    const char c = pattern[i];
    const bool doubled = i + 1 < pattern.size() && pattern[i + 1] == c;
    if (c != '{' && c != '}') {
      text += c;
    } else if (doubled) {
      text += c, ++i;
    } else if (c == '}') {
      return "has a } without a {; write }} for the character";
    } else {
      const std::size_t close = pattern.find_first_of("{}", i + 1);
      if (close == std::string_view::npos || pattern[close] == '{') {
        return "has a { without a }; write {{ for the character";
      }
      end_text();
      NamePiece piece;
      const std::string problem = ParsePlace(pattern.substr(i + 1, close - i - 1), piece);
      if (!problem.empty()) return problem;
      pieces.push_back(piece);
      i = close;
    }
  }
  end_text();
  return "";
}

std::string FillName(const std::vector<NamePiece>& pieces,
                     const std::function<std::optional<std::string>(const std::string&)>& value_of,
                     std::string& name) {
  name.clear();
  for (const NamePiece& piece : pieces) {
    if (!piece.place) {
      name += piece.text;
      continue;
    }
    const std::optional<std::string> value = value_of(piece.text);
    if (!value) return fmt::format("has {{{}}}, for which there is no value", piece.text);
    const bool plain = piece.width == 0 && piece.digits < 0;
    const std::optional<std::string> text = plain ? value : Padded(*value, piece);
    if (!text) {
      return fmt::format("pads the number {{{}}}, and '{}' is not a number", piece.text, *value);
    }
    name += SafeInFileName(*text);
  }
  return "";
}

std::string SafeInFileName(std::string_view value) {
  std::string safe(value);
  for (char& c : safe) {
    const auto byte = static_cast<unsigned char>(c);
    const bool kept =
        byte >= 0x80 || std::isalnum(byte) != 0 || (c != 0 && std::strchr("_-+=,.@", c) != nullptr);
    if (!kept) c = '_';
  }
  // "." and ".." are folders.
  if (safe.find_first_not_of('.') == std::string::npos) safe.assign(safe.size(), '_');
  return safe;
}

}  // namespace skywave
