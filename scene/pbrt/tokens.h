// Splits a pbrt file into tokens: a cursor over one text in memory.
#pragma once

#include <cstddef>
#include <string>
#include <string_view>

#include "base/error.h"
#include "scene/warnings.h"

namespace skywave {

enum class PbrtTokenKind { kEnd, kWord, kString, kOpen, kClose };  // kOpen, kClose: brackets

struct PbrtToken {
  PbrtTokenKind kind = PbrtTokenKind::kEnd;
  std::string_view text;  // without quotes, with escapes as written; lives as long as the source
  std::size_t line = 0;
};

struct PbrtSource {
  std::string path;
  std::string main_path;  // the outermost file that includes this one; or `path`
  std::string text;
  std::size_t next = 0;            // first byte not yet read
  std::size_t line = 1;            // the line of that byte
  bool imported = false;           // by Import, which keeps the state of the file that it stands in
  PbrtSource* includer = nullptr;  // by Include: the file that goes on where this one ends
  // Of version 3, to which "0," is a number; where there is none, it is an error.
  Warnings* lenient = nullptr;
};

// Returns the next token, skipping white space and # comments; returns kEnd at the end, however
// often it is called. Throws InputError on a string that does not end on its line.
PbrtToken NextToken(PbrtSource& source);
PbrtToken PeekToken(const PbrtSource& source);

InputPosition PositionOf(const PbrtSource& source, const PbrtToken& token);

// Returns the text of the next token, which must be a quoted string, with \n, \t, \r, \b, \f, \\,
// \' and \" resolved. `what` names it in the message.
std::string ExpectString(PbrtSource& source, std::string_view what);

// Returns the path of a file that the scene names: absolute, relative to `source`, or (as in pbrt)
// relative to the main file. Returns an empty string if there is none.
std::string FindPbrtFile(const PbrtSource& source, const std::string& name);

// Returns the string that a string token stands for. Throws InputError on an unknown escape.
std::string Unescape(const PbrtSource& source, const PbrtToken& token);

// Returns a word as a number. Throws InputError unless the whole word, in version 3 but for a comma
// at its end, is a number that is finite as a float; underflow gives zero.
double ParseNumber(const PbrtSource& source, const PbrtToken& token);

// Reads `count` numbers, with or without brackets around them.
void ExpectNumbers(PbrtSource& source, std::string_view what, std::size_t count, double* numbers);

// Returns "Shape", "'[' " or "the end of the file", for messages.
std::string Describe(const PbrtToken& token);

}  // namespace skywave
