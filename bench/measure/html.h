// What pages of reports have in common. They need no other file and no network.
#pragma once

#include <string>
#include <string_view>

namespace skywave {

// Returns the beginning of a page up to and with <body>.
std::string HtmlStart(std::string_view title, std::string_view style);

// Returns the end of a page.
std::string HtmlEnd();

// Returns an address that has the bytes of a file in it; `type` is "image/png" or the like.
std::string DataAddress(std::string_view type, std::string_view bytes);

// Returns an address for the relative name of a file; what addresses reserve is escaped.
std::string FileAddress(std::string_view name);

}  // namespace skywave
