#include "job/batch/draws.h"

#include <fmt/format.h>
#include <xxhash.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <map>
#include <numbers>
#include <string_view>
#include <utility>

#include "base/error.h"

namespace skywave {
namespace {

using Point = std::array<double, 3>;

// A part of the file that is read, for errors.
struct Place {
  const std::string& path;
  const std::string& option;

  [[noreturn]] void Refuse(std::size_t line, const std::string& why) const {
    throw InputError(InputPosition::Line(path, line), fmt::format("{}: {}", option, why));
  }
};

double NumberIn(const Place& place, const JobValue& value) {
  if (value.kind != JobValue::Kind::kWhole && value.kind != JobValue::Kind::kReal) {
    place.Refuse(value.line, fmt::format("'{}' is not a number", value.text));
  }
  return value.number;
}

Point PointIn(const Place& place, const JobValue& value) {
  if (value.kind != JobValue::Kind::kList || value.list.size() != 3) {
    place.Refuse(value.line, "a point has three numbers, as in [0, 1.5, 0]");
  }
  return {NumberIn(place, value.list[0]), NumberIn(place, value.list[1]),
          NumberIn(place, value.list[2])};
}

const JobValue& Required(const Place& place, const JobValue& table, std::string_view name) {
  const JobEntry* const entry = Find(table, name);
  if (entry == nullptr) place.Refuse(table.line, fmt::format("'{}' is missing", name));
  return entry->value;
}

// A number, or one between two.
struct Range {
  double from = 0, to = 0;
  double At(double u) const { return from + (to - from) * u; }
};

Range RangeIn(const Place& place, const JobValue& value) {
  if (value.kind != JobValue::Kind::kTable) {
    const double number = NumberIn(place, value);
    return {number, number};
  }
  CheckNames(place.path, value, {"from", "to"}, "key of a range, which has from and to");
  return {NumberIn(place, Required(place, value, "from")),
          NumberIn(place, Required(place, value, "to"))};
}

std::string PointText(const Point& point) {
  return fmt::format("{},{},{}", NumberText(point[0]), NumberText(point[1]), NumberText(point[2]));
}

// Points in a box whose corners are `from` and `to`.
Distribution BoxOf(const Place& place, const JobValue& table) {
  CheckNames(place.path, table, {"from", "to"}, "key of a box, which has from and to");
  const Point from = PointIn(place, Required(place, table, "from")),
              to = PointIn(place, Required(place, table, "to"));
  return [from, to](DrawNumbers& numbers) {
    Point point;
    for (std::size_t i = 0; i < 3; ++i) point[i] = from[i] + (to[i] - from[i]) * numbers.Next();
    return PointText(point);
  };
}

// Numbers between `from` and `to`; whole ones may be both.
Distribution UniformOf(const Place& place, const JobValue& table) {
  CheckNames(place.path, table, {"from", "to", "scale", "whole"},
             "key of numbers, which have from, to, scale and whole");
  const Range range = {NumberIn(place, Required(place, table, "from")),
                       NumberIn(place, Required(place, table, "to"))};
  const JobEntry* const scale = Find(table, "scale");
  if (scale != nullptr && scale->value.text != "log" && scale->value.text != "linear") {
    place.Refuse(scale->line, "scale is \"linear\" or \"log\"");
  }
  const JobEntry* const whole = Find(table, "whole");
  if (whole != nullptr && whole->value.kind != JobValue::Kind::kSwitch) {
    place.Refuse(whole->line, "whole is true or false");
  }
  if (whole != nullptr && whole->value.text == "true") {
    if (range.from != std::floor(range.from) || !(range.to >= range.from)) {
      place.Refuse(table.line, "whole numbers go from a whole number to one that is not smaller");
    }
    return [range](DrawNumbers& numbers) {
      return NumberText(
          std::floor(range.from + numbers.Next() * (std::floor(range.to) - range.from + 1)));
    };
  }
  if (scale == nullptr || scale->value.text == "linear") {
    return [range](DrawNumbers& numbers) { return NumberText(range.At(numbers.Next())); };
  }
  if (!(range.from > 0 && range.to > 0)) {
    place.Refuse(table.line, "a range with scale = \"log\" is above 0");
  }
  const Range logs = {std::log(range.from), std::log(range.to)};
  return [logs](DrawNumbers& numbers) { return NumberText(std::exp(logs.At(numbers.Next()))); };
}

// The normal distribution (Box and Muller 1958).
Distribution NormalOf(const Place& place, const JobValue& table) {
  CheckNames(place.path, table, {"mean", "deviation"},
             "key of a normal distribution, which has mean and deviation");
  const double mean = NumberIn(place, Required(place, table, "mean")),
               deviation = NumberIn(place, Required(place, table, "deviation"));
  return [mean, deviation](DrawNumbers& numbers) {
    const double radius = std::sqrt(-2 * std::log1p(-numbers.Next()));
    return NumberText(mean + deviation * radius * std::cos(2 * std::numbers::pi * numbers.Next()));
  };
}

// Points around another one: uniform by area on the part of a sphere between two elevations [deg].
Distribution AroundOf(const Place& place, const JobValue& table) {
  CheckNames(
      place.path, table, {"around", "distance", "elevation", "azimuth", "up"},
      "key of points around another, which have around, distance, elevation, azimuth and up");
  const auto range = [&](std::string_view name, Range other) {
    const JobEntry* const entry = Find(table, name);
    return entry != nullptr ? RangeIn(place, entry->value) : other;
  };
  const Point middle = PointIn(place, Required(place, table, "around"));
  const Range distance = RangeIn(place, Required(place, table, "distance"));
  const Range elevation = range("elevation", {0, 90}), azimuth = range("azimuth", {0, 360});
  const JobEntry* const named = Find(table, "up");
  const std::string up = named != nullptr ? named->value.text : "y";
  if (up != "x" && up != "y" && up != "z") place.Refuse(named->line, "up is x, y or z");
  for (const double degrees : {elevation.from, elevation.to}) {
    if (!(std::abs(degrees) <= 90)) place.Refuse(table.line, "elevations are in [-90, 90] degrees");
  }
  const auto radians = [](double degrees) { return degrees * std::numbers::pi / 180; };
  const Range heights = {std::sin(radians(elevation.from)), std::sin(radians(elevation.to))};
  const std::size_t axis = std::size_t(up[0] - 'x');
  return [=](DrawNumbers& numbers) {
    const double far = distance.At(numbers.Next()), height = heights.At(numbers.Next()),
                 turn = radians(azimuth.At(numbers.Next())),
                 level = std::sqrt(std::max(0.0, 1 - height * height));
    Point point = middle;
    point[axis] += far * height;
    point[(axis + 1) % 3] += far * level * std::sin(turn);
    point[(axis + 2) % 3] += far * level * std::cos(turn);
    return PointText(point);
  };
}

// One of several values, with weights or without. The files of a pattern share its weight.
Distribution ChoiceOf(const Place& place, const JobValue& list, const JobValue* weights,
                      const ValuesOfText& values) {
  if (list.list.empty()) place.Refuse(list.line, "there is nothing to choose from");
  if (weights != nullptr && weights->list.size() != list.list.size()) {
    place.Refuse(weights->line, fmt::format("there are {} values and {} weights", list.list.size(),
                                            weights->list.size()));
  }
  std::vector<std::pair<double, std::string>> until;  // sums of weights, and the values up to there
  double sum = 0;
  for (std::size_t i = 0; i < list.list.size(); ++i) {
    const JobValue& value = list.list[i];
    if (!value.is_scalar()) place.Refuse(value.line, "a value is a text, a number or a switch");
    const double weight = weights != nullptr ? NumberIn(place, weights->list[i]) : 1;
    if (!(weight >= 0) || !std::isfinite(weight))
      place.Refuse(value.line, "weights are at least 0");
    const std::vector<std::string> texts = values(value);
    for (const std::string& text : texts) {
      sum += weight / double(texts.size());
      until.emplace_back(sum, text);
    }
  }
  if (!(sum > 0)) place.Refuse(list.line, "all weights are 0");
  return [until, sum](DrawNumbers& numbers) {
    const double at = sum * numbers.Next();
    const auto found = std::find_if(until.begin(), until.end(),
                                    [&](const auto& entry) { return at < entry.first; });
    return found != until.end() ? found->second : until.back().second;
  };
}

// A text with places {NAME}, each of which has a distribution of its own.
Distribution TextOf(const Place& place, const JobValue& table, const ValuesOfText& values) {
  const std::string text = Required(place, table, "text").text;
  std::map<std::string, Distribution> parts;
  for (const JobEntry& entry : table.table) {
    if (entry.name == "text") continue;
    if (text.find("{" + entry.name + "}") == std::string::npos) {
      place.Refuse(entry.line, fmt::format("the text has no {{{}}}", entry.name));
    }
    parts.emplace(entry.name, ReadDistribution(place.path, entry, values));
  }
  for (std::size_t at = text.find('{'); at != std::string::npos; at = text.find('{', at + 1)) {
    const std::string name = text.substr(at + 1, text.find('}', at) - at - 1);
    if (!parts.contains(name)) {
      place.Refuse(table.line, fmt::format("the text has {{{}}}, which nothing draws", name));
    }
  }
  return [text, parts](DrawNumbers& numbers) {
    std::string filled = text;
    for (const auto& [name, draw] : parts) {
      const std::string value = draw(numbers), in_place = "{" + name + "}";
      for (std::size_t at = filled.find(in_place); at != std::string::npos;
           at = filled.find(in_place, at + value.size())) {
        filled.replace(at, in_place.size(), value);
      }
    }
    return filled;
  };
}

}  // namespace

DrawNumbers::DrawNumbers(std::uint64_t seed, std::uint64_t draw, const std::string& name)
    : name_(fmt::format("{}/{}/{}", seed, draw, name)) {}

double DrawNumbers::Next() {
  const std::uint64_t bits = XXH64(name_.data(), name_.size(), count_++);
  return double(bits >> 11) * 0x1p-53;
}

Distribution ReadDistribution(const std::string& path, const JobEntry& entry,
                              const ValuesOfText& values) {
  const Place place = {path, entry.name};
  const JobValue& value = entry.value;
  if (value.kind == JobValue::Kind::kList) return ChoiceOf(place, value, nullptr, values);
  if (value.kind == JobValue::Kind::kText) {  // the files of a pattern
    const JobValue list = {
        .kind = JobValue::Kind::kList, .list = {value}, .table = {}, .line = value.line};
    return ChoiceOf(place, list, nullptr, values);
  }
  if (value.kind != JobValue::Kind::kTable) {
    place.Refuse(entry.line, "always has this value: move it to [base]");
  }
  if (Find(value, "text") != nullptr) return TextOf(place, value, values);
  if (Find(value, "around") != nullptr) return AroundOf(place, value);
  if (Find(value, "mean") != nullptr) return NormalOf(place, value);
  if (const JobEntry* const of = Find(value, "of")) {
    CheckNames(path, value, {"of", "weights"}, "key of a choice, which has of and weights");
    const JobEntry* const weights = Find(value, "weights");
    return ChoiceOf(place, of->value, weights != nullptr ? &weights->value : nullptr, values);
  }
  const JobEntry* const from = Find(value, "from");
  if (from == nullptr) {
    place.Refuse(entry.line,
                 "is drawn from numbers (from, to), a normal distribution (mean, deviation), "
                 "values (of), points (around) or a text with such places");
  }
  return from->value.kind == JobValue::Kind::kList ? BoxOf(place, value) : UniformOf(place, value);
}

}  // namespace skywave
