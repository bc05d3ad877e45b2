// What a reader has to say of a file, one line a kind: a thousand equal remarks are one remark.
#pragma once

#include <cstddef>
#include <string>
#include <unordered_map>
#include <vector>

#include "base/error.h"

namespace skywave {

struct Warnings {
  struct Entry {
    InputPosition first;
    std::string text;
    std::size_t count = 0;
  };
  std::vector<Entry> entries;  // in the order of their first appearance
  std::unordered_map<std::string, std::size_t> by_text;
  bool strict = false;  // refuse where there would be a warning
};

// The picture is not what the file describes: `text` says what was met and what is done instead.
// Throws it as an InputError if warnings are refused.
void AddWarning(Warnings& warnings, const InputPosition& position, const std::string& text);

// The picture is what the file describes, though something in the file has no effect: never
// refused.
void AddNote(Warnings& warnings, const InputPosition& position, const std::string& text);

// "file:line: text", and " (N times)" where it was met more than once.
std::vector<std::string> WarningLines(const Warnings& warnings);

}  // namespace skywave
