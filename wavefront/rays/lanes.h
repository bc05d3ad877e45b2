// SIMD lanes of the kernels: those that are issued, and those that have a row to work on. Counted
// from rows and queues, so they are exact and the same for any number of threads.
#pragma once

#include <array>
#include <cstdint>
#include <string>

#include "kernels/columns.h"

namespace skywave {

// Kernels that walk rows, in the order in which a path meets them; one for each BSDF where each
// has its own. Kernels of textures are left out: which rows have one is known inside of them only.
enum class Kernel : std::uint32_t {
  kGenerate,
  kIntersect,  // Embree's, as kShadow
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
// "generate", "evaluate lambert", ...
std::string ToString(Kernel kernel);

// The widths that lanes are counted for: AVX2's and AVX-512's.
inline constexpr std::array<std::uint32_t, 2> kLaneWidths = {8, 16};

// Lanes of a kernel over all its calls. A call walks whole vectors. A lane is active if its row is
// one that the call is for; what is masked off inside (a lobe, a side) counts as active.
struct LaneCount {
  std::uint64_t active = 0;
  std::array<std::uint64_t, kLaneWidths.size()> issued = {};

  // A call that walks rows [0, rows), `with_work` of which it is for.
  void Add(std::uint64_t with_work, std::uint64_t rows) {
    active += with_work;
    for (std::size_t i = 0; i < issued.size(); ++i) {
      issued[i] += (rows + kLaneWidths[i] - 1) / kLaneWidths[i] * kLaneWidths[i];
    }
  }
  LaneCount& operator+=(const LaneCount& other);
  // Of vectors of `width` lanes, one of kLaneWidths; 0: the kernel did not run.
  double utilisation(std::uint32_t width) const;
};

using LaneCounts = std::array<LaneCount, kKernels>;

// From rays to surfaces: `n` rays were traced, of which `escaped` hit nothing.
void CountMeeting(std::uint32_t n, std::uint32_t escaped, const SurfaceRanges& ranges,
                  LaneCounts& lanes);
// One light sample for every surface: `open` shadow rays, of which `arrived` met nothing.
void CountLighting(const SurfaceRanges& ranges, std::uint32_t open, std::uint32_t arrived,
                   LaneCounts& lanes);
// Surfaces of BSDFs [first_kind, kBsdfKinds) scattered.
void CountScattering(const SurfaceRanges& ranges, std::uint32_t first_kind, LaneCounts& lanes);

}  // namespace skywave
