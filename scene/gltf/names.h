// Names by which things of a glTF file can be asked for, although the file may give several things
// one name or none.
#pragma once

#include <cstddef>
#include <set>
#include <string>

namespace skywave {

// Returns `name`, or where that is empty or in `taken`, "name#index", and adds what it returns to
// `taken`.
std::string NameOnce(const std::string& name, std::size_t index, std::set<std::string>& taken);

}  // namespace skywave
