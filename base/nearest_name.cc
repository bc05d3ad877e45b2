#include "base/nearest_name.h"

#include <algorithm>
#include <numeric>

namespace skywave {
namespace {

// Returns Levenshtein's distance, which is computed row by row.
std::size_t EditDistance(std::string_view name, std::string_view other) {
  std::vector<std::size_t> row(other.size() + 1);
  std::iota(row.begin(), row.end(), std::size_t{0});
  for (std::size_t i = 1; i <= name.size(); ++i) {
    std::size_t diagonal = row[0];
    row[0] = i;
    for (std::size_t j = 1; j <= other.size(); ++j) {
      const std::size_t replaced = diagonal + (name[i - 1] == other[j - 1] ? 0 : 1);
      diagonal = row[j];
      row[j] = std::min({row[j] + 1, row[j - 1] + 1, replaced});
    }
  }
  return row[other.size()];
}

}  // namespace

std::string NearestName(std::string_view name, const std::vector<std::string_view>& names) {
  std::string_view best;
  std::size_t least = std::max<std::size_t>(2, name.size() / 3) + 1;
  for (const std::string_view other : names) {
    if (const std::size_t d = EditDistance(name, other); d < least) least = d, best = other;
  }
  return std::string(best);
}

std::string NearestFirst(std::string_view name, const std::vector<std::string_view>& names,
                         std::size_t most) {
  std::vector<std::pair<std::size_t, std::string_view>> sorted;
  sorted.reserve(names.size());
  for (const std::string_view other : names) sorted.emplace_back(EditDistance(name, other), other);
  std::stable_sort(sorted.begin(), sorted.end(),
                   [](const auto& a, const auto& b) { return a.first < b.first; });
  std::string text;
  for (std::size_t i = 0; i < sorted.size(); ++i) {
    if (i > 0) text += ", ";
    if (i == most) return text + "...";
    text += sorted[i].second;
  }
  return text;
}

}  // namespace skywave
