#include "scene/obj/lines.h"

#include <fmt/format.h>

#include <algorithm>
#include <charconv>
#include <cmath>
#include <limits>
#include <optional>

#include "base/files.h"

namespace skywave {
namespace {

bool IsSpace(char c) { return c == ' ' || c == '\t'; }

// Returns whether the statement that the words begin has a name, which may hold the sign of a
// comment ("Material #25").
bool HasName(const std::vector<std::string_view>& words) {
  if (words.empty()) return false;
  for (const std::string_view word :
       {"usemtl", "newmtl", "mtllib", "o", "g", "bump", "disp", "decal", "refl", "norm"}) {
    if (words[0] == word) return true;
  }
  return words[0].starts_with("map_");
}

void CheckCount(const ObjLines& lines, const std::vector<std::string_view>& words,
                std::size_t least, std::size_t most) {
  const std::size_t count = words.size() - 1;
  if (count >= least && count <= most) return;
  const std::string wanted =
      least == most ? fmt::format("{}", least) : fmt::format("{} to {}", least, most);
  throw InputError(PositionOf(lines),
                   fmt::format("'{}' takes {} numbers, not {}", words[0], wanted, count));
}

// Returns a number, which may be infinite, or nothing if the word is none.
std::optional<double> NumberOf(std::string_view word) {
  std::string_view digits = word;
  if (digits.starts_with('+')) digits.remove_prefix(1);
  double value = 0;
  const auto [stop, error] = std::from_chars(digits.data(), digits.data() + digits.size(), value);
  if (stop != digits.data() + digits.size() || error == std::errc::invalid_argument) {
    return std::nullopt;
  }
  if (error == std::errc()) return value;
  const bool tiny = digits.find("e-") != digits.npos || digits.find("E-") != digits.npos;
  return tiny ? 0 : std::numeric_limits<double>::infinity();
}

}  // namespace

ObjLines MakeObjLines(std::string text, std::string path) {
  ObjLines lines{.path = std::move(path), .text = std::move(text)};
  std::string& t = lines.text;
  RefuseUtf16(t, lines.path);
  if (t.starts_with(kByteOrderMark))
    t.replace(0, kByteOrderMark.size(), kByteOrderMark.size(), ' ');
  for (std::size_t i = t.find('\r'); i != std::string::npos; i = t.find('\r', i + 1)) {
    t[i] = i + 1 < t.size() && t[i + 1] == '\n' ? ' ' : '\n';
  }
  for (std::size_t i = t.find('\\'); i != std::string::npos; i = t.find('\\', i + 1)) {
    std::size_t end = i + 1;
    while (end < t.size() && IsSpace(t[end])) ++end;
    if (end >= t.size() || t[end] != '\n') continue;
    t[i] = t[end] = ' ';
    lines.joined.push_back(end);
  }
  return lines;
}

bool NextStatement(ObjLines& lines, std::vector<std::string_view>& words) {
  const std::string_view text = lines.text;
  while (lines.next < text.size()) {
    const std::size_t end = std::min(text.find('\n', lines.next), text.size());
    lines.line = lines.next_line++;
    while (lines.joins_read < lines.joined.size() && lines.joined[lines.joins_read] < end) {
      ++lines.joins_read, ++lines.next_line;
    }
    words.clear();
    for (std::size_t i = lines.next; i < end;) {
      while (i < end && IsSpace(text[i])) ++i;
      const std::size_t begin = i;
      while (i < end && !IsSpace(text[i])) ++i;
      if (i > begin && text[begin] == '#' && !HasName(words)) {
        std::fill(&lines.text[begin], &lines.text[end], ' ');
        break;
      }
      if (i > begin) words.push_back(text.substr(begin, i - begin));
    }
    lines.next = end + 1;
    if (!words.empty()) return true;
  }
  return false;
}

void BlankOut(ObjLines& lines, std::string_view part) {
  const auto at = std::size_t(part.data() - lines.text.data());
  std::fill_n(lines.text.begin() + std::ptrdiff_t(at), part.size(), ' ');
}

std::string RestOfStatement(const std::vector<std::string_view>& words) {
  if (words.size() < 2) return "";
  return std::string(words[1].data(), words.back().data() + words.back().size());
}

InputPosition PositionOf(const ObjLines& lines) {
  return InputPosition::Line(lines.path, lines.line);
}

bool IsObjNumberNotFinite(std::string_view word) {
  const std::string_view unsigned_word =
      word.substr(std::min(word.find_first_not_of("+-"), word.size()));
  if (unsigned_word.starts_with("1.#")) return true;
  const std::optional<double> number = NumberOf(word);
  return number && !std::isfinite(float(*number));
}

double ParseObjNumber(const ObjLines& lines, std::string_view word) {
  const std::optional<double> number = NumberOf(word);
  if (!number) {
    throw InputError(PositionOf(lines), fmt::format("'{}' is not a number", word.substr(0, 40)));
  }
  if (!std::isfinite(float(*number))) {
    throw InputError(PositionOf(lines), fmt::format("'{}' is not finite", word.substr(0, 40)));
  }
  return *number;
}

std::vector<float> ParseObjNumbers(const ObjLines& lines,
                                   const std::vector<std::string_view>& words, std::size_t least,
                                   std::size_t most) {
  CheckCount(lines, words, least, most);
  std::vector<float> numbers;
  for (std::size_t i = 1; i < words.size(); ++i) {
    numbers.push_back(float(ParseObjNumber(lines, words[i])));
  }
  return numbers;
}

void CheckObjNumbers(const ObjLines& lines, const std::vector<std::string_view>& words,
                     std::size_t least, std::size_t most) {
  CheckCount(lines, words, least, most);
  for (std::size_t i = 1; i < words.size(); ++i) ParseObjNumber(lines, words[i]);
}

}  // namespace skywave
