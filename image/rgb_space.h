// The spaces of red, green and blue in which pictures may be rendered and written.
#pragma once

#include <cstdint>

#include "base/names.h"

namespace skywave {

enum class RgbSpace : std::uint8_t {
  kRec709,   // ITU-R BT.709, the primaries of sRGB
  kRec2020,  // ITU-R BT.2020
  kAcescg    // AP1 (Academy S-2014-004)
};
template <>
inline constexpr auto kEnumNames<RgbSpace> =
    std::to_array<Named<RgbSpace>>({{RgbSpace::kRec709, "rec709"},
                                    {RgbSpace::kRec2020, "rec2020"},
                                    {RgbSpace::kAcescg, "acescg"}});

}  // namespace skywave
