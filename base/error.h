// The only mechanism for reporting bad input: a file, flag or map of the user that cannot be used.
//
// Readers and table builders throw InputError; the command line catches it, prints "path:line:
// reason" and exits with kExitBadInput. Broken invariants of the program itself are asserts, never
// InputErrors. Nothing in kernels/ throws; wavefront/ throws only when it checks options, and
// RenderCanceled.
#pragma once

#include <cstddef>
#include <stdexcept>
#include <string>
#include <vector>

namespace skywave {

inline constexpr int kExitUsage = 64;     // a flag or argument that makes no sense (EX_USAGE)
inline constexpr int kExitBadInput = 65;  // a file that cannot be used (EX_DATAERR)
inline constexpr int kExitIo = 74;        // a file that cannot be read or written (EX_IOERR)
inline constexpr int kExitTryAgain = 75;  // stopped with a checkpoint to go on from (EX_TEMPFAIL)

// The position of an error in the input. Text formats give a line, binary formats a byte offset.
struct InputPosition {
  std::string path;
  std::size_t line = 0;    // 1-based; 0: unknown
  std::size_t offset = 0;  // [bytes] from the start; used when line == 0 and has_offset
  bool has_offset = false;

  static InputPosition File(std::string path) { return {.path = std::move(path)}; }
  static InputPosition Line(std::string path, std::size_t line) {
    return {.path = std::move(path), .line = line};
  }
  static InputPosition Byte(std::string path, std::size_t offset) {
    return {.path = std::move(path), .offset = offset, .has_offset = true};
  }
};

// Returns the text with question marks for codes that a terminal obeys, which names in files may
// hold, line breaks among them, and for bytes that are not UTF-8. Messages with details keep their
// line breaks (InputError).
std::string WithoutControlCodes(std::string text);

// Returns "scene.pbrt:12", "map.hdr (byte 345)" or the plain path.
std::string ToString(const InputPosition& position);

class InputError : public std::runtime_error {
 public:
  // `reason` names the error and, where it is not obvious, the remedy; details stand on lines of
  // their own, "\n  ...". It reaches terminals without other control codes.
  InputError(const InputPosition& position, const std::string& reason,
             int exit_code = kExitBadInput);
  // Returns the error of a name at `position` which no file has.
  static InputError NoSuchFile(const InputPosition& position, const std::string& name);
  int exit_code() const { return exit_code_; }
  const std::string& place() const { return place_; }  // as ToString gives the position
  const std::string& reason() const { return reason_; }
  const std::string& missing_file() const { return missing_file_; }  // empty: of something else

 private:
  int exit_code_;
  std::string place_, reason_, missing_file_;
};

// An option by its bare name, and its value as the user gives it; empty: the option alone matters.
struct OptionValue {
  std::string name, value;
};

// An option that makes no sense as it is, or not together with others. How options are spelled is
// the business of whoever reads them: names here have no dashes, and `why` has mentions of options
// in backticks, as in "each pass needs a sample, and `spp` is 4". Ends with kExitUsage.
class OptionError : public InputError {
 public:
  OptionError(const std::string& name, const std::string& value, const std::string& why)
      : OptionError({{name, value}}, why) {}
  OptionError(std::vector<OptionValue> options, const std::string& why);
  const std::vector<OptionValue>& options() const { return options_; }
  const std::string& why() const { return why_; }

 private:
  std::vector<OptionValue> options_;
  std::string why_;
};

}  // namespace skywave
