// Patterns of the names of outputs, "out/{env}_{frame:04}.exr".
#pragma once

#include <cstddef>
#include <functional>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

namespace skywave {

// A piece of a pattern: text, or a place for a value.
struct NamePiece {
  std::string text;  // of the text, or the name of the value
  bool place = false;
  int width = 0;    // a number is padded by zeros to this; 0: it is not
  int digits = -1;  // after the point; -1: as many as it has
};

// Splits `pattern` into pieces: {name}, {name:04}, {name:06.2}, and {{ and }} for braces. Returns
// what is wrong with it as half a sentence, or nothing.
std::string ParseNamePattern(std::string_view pattern, std::vector<NamePiece>& pieces);

// Puts the name with `value_of(name)` in its places into `name`. Returns what is wrong as half a
// sentence, or nothing: a name without a value, or a width for a value that is not a number.
std::string FillName(const std::vector<NamePiece>& pieces,
                     const std::function<std::optional<std::string>(const std::string&)>& value_of,
                     std::string& name);

// `value` for use inside the name of a file: letters, digits, _ - + = , . @ and bytes beyond ASCII
// stay, everything else, so also a separator of folders, becomes an underscore.
std::string SafeInFileName(std::string_view value);

}  // namespace skywave
