// Prints the output of commands. Nothing here throws if a stream fails: after the command has done
// its work, RunCommandLine checks that standard output has taken everything. What standard error
// does not take is lost.
#pragma once

#include <fmt/format.h>

#include <cstdio>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

namespace skywave {

class RenderJob;

// Prints through the buffer of `file`.
void PutText(std::FILE* file, std::string_view text);

// Prints at once. A closed pipe, which nobody reads any more, is not an error.
void Put(std::FILE* file, const std::string& text);

// Does what fmt::print does, but throws nothing.
template <class... Values>
void Print(std::FILE* file, fmt::format_string<Values...> format, Values&&... values) {
  PutText(file, fmt::format(format, std::forward<Values>(values)...));
}

// Prints each note as a line of standard error.
void PrintNotes(const std::vector<std::string>& notes);
// Prints what is not rendered as the scene asks, and what was assumed.
void PrintWarnings(const std::vector<std::string>& warnings);
void PrintRemarks(const RenderJob& job);

}  // namespace skywave
