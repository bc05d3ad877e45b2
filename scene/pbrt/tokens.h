// The words of a pbrt file: a cursor over one text in memory.
#pragma once

#include <cstddef>
#include <string>
#include <string_view>

#include "base/error.h"

namespace skywave {

enum class PbrtTokenKind { kEnd, kWord, kString, kOpen, kClose };  // kOpen, kClose: brackets

struct PbrtToken {
  PbrtTokenKind kind = PbrtTokenKind::kEnd;
  std::string_view text;  // without quotes, escapes as written; lives as long as the source
  std::size_t line = 0;
};

struct PbrtSource {
  std::string path;
  std::string main_path;  // of the file that includes it, or includes what does; or `path`
  std::string text;
  std::size_t next = 0;  // first byte not yet read
  std::size_t line = 1;  // the line it is on
};

// The next token, skipping white space and # comments; kEnd at the end, as often as asked. Throws
// InputError on a string that does not end on its line.
PbrtToken NextToken(PbrtSource& source);
PbrtToken PeekToken(const PbrtSource& source);

InputPosition PositionOf(const PbrtSource& source, const PbrtToken& token);

// The next token, which has to be a quoted string: its text with \n, \t, \r, \b, \f, \\, \' and \"
// resolved. `what` names it in the message.
std::string ExpectString(PbrtSource& source, std::string_view what);

// The path of a file that the scene names: absolute, or beside `source`, or (as pbrt has it) beside
// the main file. Empty if there is none.
std::string FindPbrtFile(const PbrtSource& source, const std::string& name);

// The string a string token stands for. Throws InputError on an unknown escape.
std::string Unescape(const PbrtSource& source, const PbrtToken& token);

// A word as a number. Throws InputError unless all of it is a number and finite as a float;
// underflow gives zero.
double ParseNumber(const PbrtSource& source, const PbrtToken& token);

// `count` numbers, with or without brackets around them.
void ExpectNumbers(PbrtSource& source, std::string_view what, std::size_t count, double* numbers);

// "Shape", "'[' " or "the end of the file", for messages.
std::string Describe(const PbrtToken& token);

}  // namespace skywave
