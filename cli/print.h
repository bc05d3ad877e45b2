// Prints what the commands have to say. Nothing here throws where a stream fails: a command first
// does its work, then RunCommandLine looks whether standard output has taken everything, and what
// standard error does not take is lost.
#pragma once

#include <fmt/format.h>

#include <cstdio>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

namespace skywave {

// Prints through the buffer of `file`.
void PutText(std::FILE* file, std::string_view text);

// Prints at once. That nobody reads it any more (a closed pipe) is no error.
void Put(std::FILE* file, const std::string& text);

// Does what fmt::print does, but throws nothing.
template <class... Values>
void Print(std::FILE* file, fmt::format_string<Values...> format, Values&&... values) {
  PutText(file, fmt::format(format, std::forward<Values>(values)...));
}

// Prints each note as a line of standard error.
void PrintNotes(const std::vector<std::string>& notes);

}  // namespace skywave
