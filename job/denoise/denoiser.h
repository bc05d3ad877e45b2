// The ways to make a picture clean, by name.
#pragma once

#include "base/names.h"

namespace skywave {

enum class Denoiser {
  kNone,
  kStatistics,  // by the statistics of its samples alone (kernels/cross_filter.h)
  kOidn,        // by Open Image Denoise (job/denoise/oidn.h)
  kQuick,       // the same picture, without its error, for which the halves are cleaned as well
  kBest,        // by both, and nothing where that is better, pixel by pixel
  kAuto         // kBest where Open Image Denoise is there, else kStatistics
};
template <>
inline constexpr auto kEnumNames<Denoiser> =
    std::to_array<Named<Denoiser>>({{Denoiser::kNone, "none"},
                                    {Denoiser::kStatistics, "statistics"},
                                    {Denoiser::kOidn, "oidn"},
                                    {Denoiser::kQuick, "quick"},
                                    {Denoiser::kBest, "best"},
                                    {Denoiser::kAuto, "auto"}});

// The words of those that an option names besides the first two.
inline constexpr char kDenoiserWords[] = "oidn|quick|best|auto";

}  // namespace skywave
