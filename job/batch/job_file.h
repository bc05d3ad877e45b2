// A job file as plain data: the values of a TOML file in its own order, each with its line.
#pragma once

#include <cstddef>
#include <string>
#include <string_view>
#include <vector>

namespace skywave {

struct JobEntry;

struct JobValue {
  enum class Kind { kText, kWhole, kReal, kSwitch, kOther, kList, kTable };
  Kind kind = Kind::kTable;
  std::string text = {};            // of a scalar, as an option takes it
  double number = 0;                // of kWhole and kReal
  std::vector<JobValue> list = {};  // of kList
  std::vector<JobEntry> table;      // of kTable, in the order of the file
  std::size_t line = 0;             // from 1

  bool is_scalar() const;  // text, a number or a switch: an option's value
};

struct JobEntry {
  std::string name;
  std::size_t line = 0;
  JobValue value;
};

// Returns the table of the TOML text `bytes`; `path` names it in errors. Throws InputError with the
// line.
JobValue ParseJobFile(const std::string& path, std::string_view bytes);

// `number` as an option takes it: whole numbers without a point, others with nine digits, which are
// enough for a float.
std::string NumberText(double number);

// Returns the value of `name` in a table, or null.
const JobEntry* Find(const JobValue& table, std::string_view name);

// Throws InputError unless each name of `table` is one of `known`; suggests the nearest. `what` is
// what such a name is called, "table" or "key of [output]".
void CheckNames(const std::string& path, const JobValue& table,
                const std::vector<std::string_view>& known, std::string_view what);

}  // namespace skywave
