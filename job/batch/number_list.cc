#include "job/batch/number_list.h"

#include <fmt/format.h>

#include <charconv>

namespace skywave {
namespace {

struct NumberRange {
  std::int64_t first = 0, last = 0;
  std::uint64_t step = 1;

  // The distance of any two signed numbers fits, and is less than 2^64 - 1 for those that are read.
  std::uint64_t distance() const {
    return first < last ? std::uint64_t(last) - std::uint64_t(first)
                        : std::uint64_t(first) - std::uint64_t(last);
  }
  std::uint64_t count_minus_one() const { return distance() / step; }
};

std::string_view WithoutBlanks(std::string_view text) {
  const std::size_t first = text.find_first_not_of(" \t");
  if (first == std::string_view::npos) return {};
  return text.substr(first, text.find_last_not_of(" \t") - first + 1);
}

// Takes a number off the front of `text`.
template <class Number>
bool TakeNumber(std::string_view& text, Number& number) {
  const auto [stop, error] = std::from_chars(text.data(), text.data() + text.size(), number);
  if (error != std::errc()) return false;
  text.remove_prefix(std::size_t(stop - text.data()));
  return true;
}

bool TakeCharacter(std::string_view& text, char character) {
  if (!text.starts_with(character)) return false;
  text.remove_prefix(1);
  return true;
}

bool ParseRange(std::string_view text, NumberRange& range) {
  if (!TakeNumber(text, range.first)) return false;
  range.last = range.first;
  if (text.empty()) return true;
  if (!TakeCharacter(text, '-') || !TakeNumber(text, range.last)) return false;
  if (text.empty()) return true;
  return TakeCharacter(text, ':') && TakeNumber(text, range.step) && text.empty() && range.step > 0;
}

}  // namespace

std::string ParseNumberList(std::string_view text, std::size_t most,
                            std::vector<std::int64_t>& numbers) {
  numbers.clear();
  std::vector<NumberRange> ranges;
  std::size_t room = most;
  for (std::string_view rest = text;;) {
    const std::size_t comma = rest.find(',');
    const std::string_view item = WithoutBlanks(rest.substr(0, comma));
    NumberRange range;
    if (!ParseRange(item, range)) {
      return fmt::format("'{}' is neither N nor FIRST-LAST nor FIRST-LAST:STEP", item);
    }
    if (range.count_minus_one() >= room) {
      return fmt::format("'{}' lists more than {} numbers", text, most);
    }
    room -= std::size_t(range.count_minus_one()) + 1;
    ranges.push_back(range);
    if (comma == std::string_view::npos) break;
    rest.remove_prefix(comma + 1);
  }
  numbers.reserve(most - room);
  for (const NumberRange& range : ranges) {
    for (std::uint64_t i = 0; i <= range.count_minus_one(); ++i) {
      const std::uint64_t offset = i * range.step;
      // Unsigned arithmetic wraps around, as two's complement does.
      numbers.push_back(std::int64_t(range.first <= range.last
                                         ? std::uint64_t(range.first) + offset
                                         : std::uint64_t(range.first) - offset));
    }
  }
  return "";
}

}  // namespace skywave
