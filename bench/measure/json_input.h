// Reads JSON that others may have written or cut short: what is wrong with a file is an InputError
// that names the file and the place in it.
#pragma once

#include <cstdint>
#include <nlohmann/json_fwd.hpp>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

namespace skywave {

// A value of a JSON file and its place there, as a JSON pointer (RFC 6901): "/scenes/0/name". The
// document must outlive it.
class JsonInput {
 public:
  JsonInput(const nlohmann::json& document, std::string file)
      : value_(&document), file_(std::move(file)) {}

  const std::string& file() const { return file_; }
  bool is_null() const;
  bool has(std::string_view key) const;
  // Returns a member; fails if there is none.
  JsonInput at(std::string_view key) const;
  // Return the elements of an array, and the members of an object with their names.
  std::vector<JsonInput> items() const;
  std::vector<std::pair<std::string, JsonInput>> members() const;
  std::string text() const;
  double number() const;
  // Returns a whole number in [low, high]; neither is above kMostWhole.
  std::uint64_t whole_number(std::uint64_t low, std::uint64_t high) const;
  static constexpr std::uint64_t kMostWhole = std::uint64_t{1} << 53;  // a double holds all of them
  // Returns an array of numbers above 0 that is not empty.
  std::vector<double> positive_numbers() const;
  // Fails unless the member "schema" is one of `known`, which it returns. `what` says what has such
  // schemas: "a result of skywave bench".
  std::string schema(const std::vector<std::string_view>& known, std::string_view what) const;
  // Throws InputError for this place.
  [[noreturn]] void Fail(const std::string& reason) const;

 private:
  JsonInput Child(const nlohmann::json& value, const std::string& name) const;

  const nlohmann::json* value_;
  std::string file_, pointer_;
};

// Throws InputError if the file cannot be read or is not JSON, with the line where it stops being
// valid.
nlohmann::json ReadJson(const std::string& path);

// The same from memory; `path` is for messages.
nlohmann::json ParseJson(std::string_view text, const std::string& path);

}  // namespace skywave
