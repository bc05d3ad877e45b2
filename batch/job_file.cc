#include "batch/job_file.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <tuple>

#include "base/error.h"
#include "job/option.h"

// toml++ 3.3 asserts that no value begins with a terminator, but a malformed file has such values;
// without the assertion its parser reports them. With NDEBUG the assertion becomes an assumption.
#pragma push_macro("NDEBUG")
#undef NDEBUG
#define TOML_ASSERT(expr) static_assert(true)
#define TOML_HEADER_ONLY 1
#define TOML_EXCEPTIONS 1
#define TOML_ENABLE_FORMATTERS 0
#include <toml++/toml.h>
#pragma pop_macro("NDEBUG")

namespace skywave {
namespace {

JobValue ValueOf(const toml::node& node);

JobValue TableOf(const toml::table& table) {
  JobValue value;
  std::vector<std::pair<toml::source_position, JobEntry>> entries;
  for (const auto& [key, node] : table) {
    const toml::source_position position = key.source().begin;
    entries.emplace_back(position, JobEntry{std::string(key.str()), position.line, ValueOf(node)});
  }
  // toml++ sorts tables by name.
  std::sort(entries.begin(), entries.end(), [](const auto& a, const auto& b) {
    return std::tie(a.first.line, a.first.column) < std::tie(b.first.line, b.first.column);
  });
  for (auto& [position, entry] : entries) value.table.push_back(std::move(entry));
  return value;
}

JobValue ValueOf(const toml::node& node) {
  using Kind = JobValue::Kind;
  JobValue value;
  if (const toml::table* table = node.as_table()) {
    value = TableOf(*table);
  } else if (const toml::array* list = node.as_array()) {
    value.kind = Kind::kList;
    for (const toml::node& item : *list) value.list.push_back(ValueOf(item));
  } else if (const auto* text = node.as_string()) {
    value.kind = Kind::kText, value.text = text->get();
  } else if (const auto* whole = node.as_integer()) {
    value.kind = Kind::kWhole, value.text = fmt::format("{}", whole->get());
    value.number = double(whole->get());
  } else if (const auto* real = node.as_floating_point()) {
    value.kind = Kind::kReal, value.text = NumberText(real->get()), value.number = real->get();
  } else if (const auto* on = node.as_boolean()) {
    value.kind = Kind::kSwitch, value.text = on->get() ? "true" : "false";
  } else {
    value.kind = Kind::kOther;  // dates and times, which no option takes
  }
  value.line = node.source().begin.line;
  return value;
}

}  // namespace

bool JobValue::is_scalar() const {
  return kind == Kind::kText || kind == Kind::kWhole || kind == Kind::kReal ||
         kind == Kind::kSwitch;
}

std::string NumberText(double number) {
  constexpr double kMostWhole = 9007199254740992;  // 2^53: all of them are exact up to here
  if (number == std::floor(number) && std::abs(number) <= kMostWhole) {
    return fmt::format("{}", std::int64_t(number));
  }
  return fmt::format("{:.9g}", number);
}

JobValue ParseJobFile(const std::string& path, std::string_view bytes) {
  try {
    return TableOf(toml::parse(bytes, std::string_view(path)));
  } catch (const toml::parse_error& error) {
    throw InputError(InputPosition::Line(path, error.source().begin.line),
                     std::string(error.description()));
  }
}

const JobEntry* Find(const JobValue& table, std::string_view name) {
  const auto found = std::find_if(table.table.begin(), table.table.end(),
                                  [name](const JobEntry& entry) { return entry.name == name; });
  return found == table.table.end() ? nullptr : &*found;
}

void CheckNames(const std::string& path, const JobValue& table,
                const std::vector<std::string_view>& known, std::string_view what) {
  for (const JobEntry& entry : table.table) {
    if (std::find(known.begin(), known.end(), entry.name) != known.end()) continue;
    const std::string nearest = NearestName(entry.name, known);
    throw InputError(
        InputPosition::Line(path, entry.line),
        fmt::format("'{}' is no {}; {}", entry.name, what,
                    nearest.empty() ? fmt::format("there are {}", fmt::join(known, ", "))
                                    : fmt::format("did you mean '{}'?", nearest)));
  }
}

}  // namespace skywave
