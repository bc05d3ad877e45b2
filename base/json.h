// Text becomes JSON and JSON text here alone, because the reader and the writer are most of what
// nlohmann's library compiles to.
#pragma once

#include <nlohmann/json_fwd.hpp>
#include <string>
#include <string_view>

namespace skywave {

// Throw nlohmann::json::exception for text that is not JSON. The second one keeps the members of
// objects in the order of the text.
nlohmann::json ParseJson(std::string_view text);
nlohmann::ordered_json ParseOrderedJson(std::string_view text);

// What characters of strings become in a text.
enum class JsonCharacters { kUtf8, kAscii };

// Returns `json` as text: in one line, or with `indent` blanks for each level. Bytes of strings
// that are not UTF-8 become U+FFFD.
std::string JsonText(const nlohmann::json& json, int indent = -1);
std::string JsonText(const nlohmann::ordered_json& json, int indent = -1,
                     JsonCharacters characters = JsonCharacters::kUtf8);

}  // namespace skywave
