// Finds the name that somebody meant, for error messages.
#pragma once

#include <string>
#include <string_view>
#include <vector>

namespace skywave {

// Returns the name among `names` that is most like `name`; empty where none is near.
std::string NearestName(std::string_view name, const std::vector<std::string_view>& names);

// Returns "a, b, c": the names from the one that is most like `name` to the one that is least, in
// their own order where they are alike; at most `most` of them, and "..." where there are more.
std::string NearestFirst(std::string_view name, const std::vector<std::string_view>& names,
                         std::size_t most = 20);

}  // namespace skywave
