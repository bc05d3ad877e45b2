#include "scene/pbrt/lens_file.h"

#include <fmt/format.h>

#include <charconv>
#include <cmath>
#include <sstream>

#include "base/error.h"

namespace skywave {

std::vector<LensInterface> ParsePbrtLens(const std::string& text, const std::string& path) {
  constexpr double kMeter = 1e-3;
  std::vector<double> numbers;
  std::istringstream lines(text);
  std::size_t line = 0;
  for (std::string row; std::getline(lines, row);) {
    ++line;
    std::istringstream words(row.substr(0, row.find('#')));
    for (std::string word; words >> word;) {
      double number = 0;
      const char* const end = word.data() + word.size();
      const auto [stop, error] = std::from_chars(word.data(), end, number);
      if (error != std::errc() || stop != end || !std::isfinite(number)) {
        throw InputError(InputPosition::Line(path, line),
                         fmt::format("a lens has numbers, not \"{}\"", word));
      }
      numbers.push_back(number);
    }
  }
  const auto refuse = [&](const std::string& why) {
    throw InputError(InputPosition::File(path), why);
  };
  if (numbers.empty() || numbers.size() % 4 != 0) {
    refuse(
        fmt::format("a lens has four numbers for each interface: radius, thickness, index and "
                    "diameter; these are {}",
                    numbers.size()));
  }
  constexpr std::size_t kMostInterfaces = 256;
  if (numbers.size() > 4 * kMostInterfaces) {
    refuse(fmt::format("a lens of {} interfaces; {} is the limit", numbers.size() / 4,
                       kMostInterfaces));
  }
  std::vector<LensInterface> lens;
  for (std::size_t i = 0; i < numbers.size(); i += 4) {
    const double* const n = &numbers[i];
    if (!(n[1] >= 0 && n[2] >= 0 && n[3] > 0) || (n[0] != 0 && n[3] > 2 * std::abs(n[0]))) {
      refuse(
          fmt::format("interface {} of the lens has radius {}, thickness {}, index {} and "
                      "diameter {}, which make none",
                      i / 4 + 1, n[0], n[1], n[2], n[3]));
    }
    lens.push_back({kMeter * n[0], kMeter * n[1], n[2], kMeter * n[3] / 2});
  }
  return lens;
}

}  // namespace skywave
