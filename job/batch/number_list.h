// Lists of whole numbers in a text, as farms write frames: "1-3,5,7-20:2".
#pragma once

#include <cstddef>
#include <cstdint>
#include <string>
#include <string_view>
#include <vector>

namespace skywave {

// Puts the numbers that `text` lists into `numbers`: single numbers and ranges, separated by
// commas. Both ends of a range are included, FIRST may be larger than LAST, either may be negative,
// and a step follows after a colon: "10-1:3" is 10, 7, 4, 1. Blanks around an item are ignored.
// Returns what is wrong as half a sentence, or nothing; more than `most` numbers are wrong, and are
// counted before any is made.
std::string ParseNumberList(std::string_view text, std::size_t most,
                            std::vector<std::int64_t>& numbers);

}  // namespace skywave
