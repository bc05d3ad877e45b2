// The lines of a Wavefront text file (OBJ or MTL), cut into words.
#pragma once

#include <cstddef>
#include <string>
#include <string_view>
#include <vector>

#include "base/error.h"

namespace skywave {

struct ObjLines {
  std::string path;
  std::string text;                 // every line ends in '\n' alone; continued lines are one
  std::vector<std::size_t> joined;  // offsets of the line ends that a '\' before them took away
  std::size_t next = 0;             // first byte not yet read
  std::size_t line = 0;             // where the statement that was read last begins
  std::size_t next_line = 1;
  std::size_t joins_read = 0;
};

// Unifies the line ends of `text` (\n, \r\n or \r) and joins continued lines.
ObjLines MakeObjLines(std::string text, std::string path);

// The words of the next statement: comments and empty lines are skipped. False at the end. `words`
// is reused from call to call; its views live as long as `lines`.
bool NextStatement(ObjLines& lines, std::vector<std::string_view>& words);

// What follows the first word, up to the end of the statement: names may have spaces in them.
std::string RestOfStatement(const std::vector<std::string_view>& words);

InputPosition PositionOf(const ObjLines& lines);

// A finite float; InputError otherwise.
float ParseObjNumber(const ObjLines& lines, std::string_view word);

// words[1], words[2], ... as numbers. InputError if there are not `least` to `most` of them.
std::vector<float> ParseObjNumbers(const ObjLines& lines,
                                   const std::vector<std::string_view>& words, std::size_t least,
                                   std::size_t most);
// The same, checked and thrown away: for long tables.
void CheckObjNumbers(const ObjLines& lines, const std::vector<std::string_view>& words,
                     std::size_t least, std::size_t most);

}  // namespace skywave
