// A table of texts, for terminals.
#pragma once

#include <string>
#include <vector>

namespace skywave {

// Rows of cells; the first row is the heading.
using TextTable = std::vector<std::vector<std::string>>;

// Returns the table with its columns aligned by spaces.
std::string Text(const TextTable& table);

}  // namespace skywave
