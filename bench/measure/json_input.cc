#include "bench/measure/json_input.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <nlohmann/json.hpp>

#include "base/error.h"
#include "base/files.h"
#include "base/json.h"

namespace skywave {
namespace {

constexpr std::size_t kMostJsonBytes = std::size_t{1} << 28;

}  // namespace

void JsonInput::Fail(const std::string& reason) const {
  throw InputError(InputPosition::File(file_),
                   pointer_.empty() ? reason : fmt::format("{}: {}", pointer_, reason));
}

JsonInput JsonInput::Child(const nlohmann::json& value, const std::string& name) const {
  JsonInput child(value, file_);
  child.pointer_ = pointer_ + "/" + name;
  return child;
}

bool JsonInput::is_null() const { return value_->is_null(); }

bool JsonInput::has(std::string_view key) const {
  return value_->is_object() && value_->contains(key);
}

JsonInput JsonInput::at(std::string_view key) const {
  if (!value_->is_object()) Fail("is not an object");
  const auto found = value_->find(key);
  if (found == value_->end()) Fail(fmt::format("has no key \"{}\"", key));
  return Child(*found, std::string(key));
}

std::vector<JsonInput> JsonInput::items() const {
  if (!value_->is_array()) Fail("is not an array");
  std::vector<JsonInput> items;
  for (std::size_t i = 0; i < value_->size(); ++i) {
    items.push_back(Child((*value_)[i], std::to_string(i)));
  }
  return items;
}

std::vector<std::pair<std::string, JsonInput>> JsonInput::members() const {
  if (!value_->is_object()) Fail("is not an object");
  std::vector<std::pair<std::string, JsonInput>> members;
  for (const auto& [name, value] : value_->items()) members.emplace_back(name, Child(value, name));
  return members;
}

std::string JsonInput::text() const {
  if (!value_->is_string()) Fail("is not a text");
  return value_->get<std::string>();
}

double JsonInput::number() const {
  if (!value_->is_number()) Fail("is not a number");
  return value_->get<double>();
}

std::uint64_t JsonInput::whole_number(std::uint64_t low, std::uint64_t high) const {
  const double value = number();
  if (!(value >= double(low) && value <= double(high) && value == std::floor(value))) {
    Fail(fmt::format("is not a whole number from {} to {}", low, high));
  }
  return std::uint64_t(value);
}

std::vector<double> JsonInput::positive_numbers() const {
  std::vector<double> numbers;
  for (const JsonInput& item : items()) {
    numbers.push_back(item.number());
    if (!(numbers.back() > 0)) item.Fail("is not above 0");
  }
  if (numbers.empty()) Fail("is empty");
  return numbers;
}

std::string JsonInput::schema(const std::vector<std::string_view>& known,
                              std::string_view what) const {
  const bool there = has("schema") && at("schema").value_->is_string();
  const std::string found = there ? at("schema").text() : "";
  if (std::find(known.begin(), known.end(), found) != known.end()) return found;
  Fail(fmt::format("is not {} (schema {}{})", what, fmt::join(known, " or "),
                   found.empty() ? "" : ", not " + found));
}

nlohmann::json ReadJson(const std::string& path) {
  return ParseJson(ReadFile(path, kMostJsonBytes), path);
}

nlohmann::json ParseJson(std::string_view text, const std::string& path) {
  try {
    return ParseJson(text);
  } catch (const nlohmann::json::parse_error& error) {
    const std::size_t end = std::min(error.byte, text.size());
    const auto line = std::count(text.begin(), text.begin() + std::ptrdiff_t(end), '\n');
    throw InputError(InputPosition::Line(path, std::size_t(line) + 1),
                     error.byte > text.size() ? "ends within JSON" : "is not JSON from here on");
  } catch (const nlohmann::json::exception&) {
    throw InputError(InputPosition::File(path), "is JSON with a number that is too large");
  }
}

}  // namespace skywave
