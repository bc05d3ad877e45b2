// Cuts a Wavefront text file (OBJ or MTL) into lines and words.
#pragma once

#include <cstddef>
#include <string>
#include <string_view>
#include <vector>

#include "base/error.h"

namespace skywave {

struct ObjLines {
  std::string path;
  std::string text;                 // every line ends in '\n' alone; continued lines are merged
  std::vector<std::size_t> joined;  // offsets of the line ends removed after a '\'
  std::size_t next = 0;             // first byte not yet read
  std::size_t line = 0;             // first line of the statement read last
  std::size_t next_line = 1;
  std::size_t joins_read = 0;
};

// Converts the line ends of `text` (\n, \r\n or \r) to \n and merges continued lines.
ObjLines MakeObjLines(std::string text, std::string path);

// Splits the next statement into words, skipping comments, which become blank, and empty lines.
// Returns false at the end. `words` is reused from call to call; its views live as long as `lines`.
bool NextStatement(ObjLines& lines, std::vector<std::string_view>& words);

// Makes a part of the text blank, such as a word.
void BlankOut(ObjLines& lines, std::string_view part);

// Returns everything between the first word and the end of the statement, because names may contain
// spaces.
std::string RestOfStatement(const std::vector<std::string_view>& words);

InputPosition PositionOf(const ObjLines& lines);

// Returns whether a word is a number that is not finite: "nan", "-inf", "1e39" or "1.#QNAN".
bool IsObjNumberNotFinite(std::string_view word);
// Returns a number that is finite as a float, 0 for one that is too small; throws InputError
// otherwise.
double ParseObjNumber(const ObjLines& lines, std::string_view word);

// Returns words[1], words[2], ... as numbers. Throws InputError unless there are `least` to `most`
// of them.
std::vector<float> ParseObjNumbers(const ObjLines& lines,
                                   const std::vector<std::string_view>& words, std::size_t least,
                                   std::size_t most);
// Checks numbers as above without storing them, for long tables.
void CheckObjNumbers(const ObjLines& lines, const std::vector<std::string_view>& words,
                     std::size_t least, std::size_t most);

}  // namespace skywave
