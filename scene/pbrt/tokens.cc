#include "scene/pbrt/tokens.h"

#include <fmt/format.h>

#include <charconv>
#include <cmath>
#include <cstdlib>
#include <filesystem>
#include <limits>

namespace skywave {
namespace {

bool IsSpace(char c) { return c == ' ' || c == '\t' || c == '\r' || c == '\n' || c == '\f'; }

bool EndsWord(char c) { return IsSpace(c) || c == '"' || c == '[' || c == ']' || c == '#'; }

// Messages show this much of a token, because a token may be a whole file.
std::string Excerpt(std::string_view text) {
  constexpr std::size_t kLongest = 40;
  return text.size() <= kLongest ? std::string(text)
                                 : std::string(text.substr(0, kLongest)) + "...";
}

PbrtToken ScanToken(const PbrtSource& source, std::size_t& next, std::size_t& line) {
  const std::string_view text = source.text;
  while (next < text.size()) {
    const char c = text[next];
    if (c == '#') {
      while (next < text.size() && text[next] != '\n') ++next;
    } else if (IsSpace(c)) {
      line += c == '\n';
      ++next;
    } else {
      break;
    }
  }
  if (next == text.size()) return {PbrtTokenKind::kEnd, {}, line};

  const std::size_t begin = next++;
  if (text[begin] == '[') return {PbrtTokenKind::kOpen, text.substr(begin, 1), line};
  if (text[begin] == ']') return {PbrtTokenKind::kClose, text.substr(begin, 1), line};
  if (text[begin] != '"') {
    while (next < text.size() && !EndsWord(text[next])) ++next;
    return {PbrtTokenKind::kWord, text.substr(begin, next - begin), line};
  }
  while (next < text.size() && text[next] != '"' && text[next] != '\n') {
    next += text[next] == '\\' && next + 1 < text.size() ? 2 : 1;
  }
  if (next >= text.size() || text[next] != '"') {
    throw InputError(InputPosition::Line(source.path, line),
                     "string without closing quote: \"" + Excerpt(text.substr(begin + 1)));
  }
  ++next;
  return {PbrtTokenKind::kString, text.substr(begin + 1, next - begin - 2), line};
}

}  // namespace

PbrtToken NextToken(PbrtSource& source) { return ScanToken(source, source.next, source.line); }

PbrtToken PeekToken(const PbrtSource& source) {
  std::size_t next = source.next, line = source.line;
  return ScanToken(source, next, line);
}

InputPosition PositionOf(const PbrtSource& source, const PbrtToken& token) {
  return InputPosition::Line(source.path, token.line);
}

std::string Unescape(const PbrtSource& source, const PbrtToken& token) {
  std::string plain;
  for (std::size_t i = 0; i < token.text.size(); ++i) {
    char c = token.text[i];
    if (c == '\\') {
      constexpr std::string_view kCodes = "ntrbf\\'\"", kMeanings = "\n\t\r\b\f\\'\"";
      const std::size_t code =
          i + 1 < token.text.size() ? kCodes.find(token.text[i + 1]) : std::string_view::npos;
      if (code == std::string_view::npos) {
        throw InputError(PositionOf(source, token),
                         "unknown escape in the string \"" + Excerpt(token.text) + "\"");
      }
      c = kMeanings[code];
      ++i;
    }
    plain += c;
  }
  return plain;
}

std::string ExpectString(PbrtSource& source, std::string_view what) {
  const PbrtToken token = NextToken(source);
  if (token.kind != PbrtTokenKind::kString) {
    throw InputError(PositionOf(source, token),
                     fmt::format("{} in quotes is expected, not {}", what, Describe(token)));
  }
  return Unescape(source, token);
}

double ParseNumber(const PbrtSource& source, const PbrtToken& token) {
  std::string_view text = token.text;
  if (text.size() > 1 && text[0] == '+' && text[1] != '-') text.remove_prefix(1);
  if (source.lenient != nullptr && text.size() > 1 && text.back() == ',') {
    AddWarning(*source.lenient, PositionOf(source, token), "a comma after a number: not read");
    text.remove_suffix(1);
  }
  double value = 0;
  const auto [end, error] = std::from_chars(text.data(), text.data() + text.size(), value);
  if (token.kind != PbrtTokenKind::kWord || end != text.data() + text.size() ||
      error == std::errc::invalid_argument) {
    throw InputError(PositionOf(source, token), "a number is expected, not " + Describe(token));
  }
  // Beyond the range of double, from_chars does not distinguish overflow from underflow.
  if (error == std::errc::result_out_of_range)
    value = std::strtod(std::string(text).c_str(), nullptr);
  if (!(std::abs(value) <= std::numeric_limits<float>::max())) {
    throw InputError(PositionOf(source, token),
                     "the number " + Excerpt(token.text) + " is not finite in single precision");
  }
  return value;
}

std::string FindPbrtFile(const PbrtSource& source, const std::string& name) {
  std::error_code ignored;
  for (const std::string* beside : {&source.path, &source.main_path}) {
    const std::filesystem::path path = std::filesystem::path(*beside).parent_path() / name;
    if (std::filesystem::exists(path, ignored)) return path.string();
  }
  return "";
}

void ExpectNumbers(PbrtSource& source, std::string_view what, std::size_t count, double* numbers) {
  const bool brackets = PeekToken(source).kind == PbrtTokenKind::kOpen;
  if (brackets) NextToken(source);
  for (std::size_t i = 0; i < count; ++i) {
    const PbrtToken token = NextToken(source);
    if (token.kind != PbrtTokenKind::kWord) {
      throw InputError(
          PositionOf(source, token),
          fmt::format("{} takes {} numbers; after {} comes {}", what, count, i, Describe(token)));
    }
    numbers[i] = ParseNumber(source, token);
  }
  if (!brackets) return;
  const PbrtToken token = NextToken(source);
  if (token.kind != PbrtTokenKind::kClose) {
    throw InputError(
        PositionOf(source, token),
        fmt::format("{} takes {} numbers: ']' is expected, not {}", what, count, Describe(token)));
  }
}

std::string Describe(const PbrtToken& token) {
  switch (token.kind) {
    case PbrtTokenKind::kEnd:
      return "the end of the file";
    case PbrtTokenKind::kString:
      return "\"" + Excerpt(token.text) + "\"";
    default:
      return "'" + Excerpt(token.text) + "'";
  }
}

}  // namespace skywave
