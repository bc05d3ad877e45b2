// SIMD lanes of the kernels are counted: those that are issued, and those that have a row to work
// on. The counts come from rows and queues, so they are exact and the same for any number of
// threads.
#pragma once

#include <array>
#include <cstdint>
#include <string>

#include "kernels/columns.h"

namespace skywave {

// These kernels walk rows, in the order in which a path reaches them, with one for each BSDF where
// each has its own. Kernels of textures are left out: only they know which rows have one.
enum class Kernel : std::uint32_t {
  kGenerate,
  kIntersect,  // Embree's, like kShadow
  kClassify,
  kMoveEscaped,
  kEscape,
  kMoveHits,
  kSurface,
  kLightSample,
  kEvaluate,  // and one for every other BSDF that takes light samples
  kShadow = kEvaluate + kFirstDeltaBsdf,
  kAccumulate,
  kScatter,  // and one for every other BSDF
  kFilm = kScatter + kBsdfKinds
};
inline constexpr std::uint32_t kKernels = std::uint32_t(Kernel::kFilm) + 1;
// Returns "generate", "evaluate lambert", ...
std::string ToString(Kernel kernel);

// Lanes are counted for these widths: AVX2's and AVX-512's.
inline constexpr std::array<std::uint32_t, 2> kLaneWidths = {8, 16};

// This counts the lanes of a kernel over all its calls. A call walks whole vectors. A lane is
// active if the call is for its row; lanes that are masked off inside (a lobe, a side) count as
// active.
struct LaneCount {
  std::uint64_t active = 0;
  std::array<std::uint64_t, kLaneWidths.size()> issued = {};

  // Adds a call that walks rows [0, rows) and is for `with_work` of them.
  void Add(std::uint64_t with_work, std::uint64_t rows) {
    active += with_work;
    for (std::size_t i = 0; i < issued.size(); ++i) {
      issued[i] += (rows + kLaneWidths[i] - 1) / kLaneWidths[i] * kLaneWidths[i];
    }
  }
  LaneCount& operator+=(const LaneCount& other);
  // Returns the share of active lanes in vectors of `width` lanes, one of kLaneWidths, or 0 if the
  // kernel did not run.
  double utilisation(std::uint32_t width) const;
};

using LaneCounts = std::array<LaneCount, kKernels>;

// Counts the kernels from rays to surfaces: `n` rays were traced, `escaped` of them see the
// environment, and some have hit surfaces that are shaded.
void CountTracing(std::uint32_t n, LaneCounts& lanes);
void CountEscaping(std::uint32_t n, std::uint32_t escaped, LaneCounts& lanes);
void CountHits(std::uint32_t n, const SurfaceRanges& ranges, LaneCounts& lanes);
// Counts those of one light sample for every surface: there were `open` shadow rays, of which
// `arrived` hit nothing.
void CountLighting(const SurfaceRanges& ranges, std::uint32_t open, std::uint32_t arrived,
                   LaneCounts& lanes);
// Counts the scattering of surfaces of BSDFs [first_kind, kBsdfKinds).
void CountScattering(const SurfaceRanges& ranges, std::uint32_t first_kind, LaneCounts& lanes);

}  // namespace skywave
