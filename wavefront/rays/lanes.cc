#include "wavefront/rays/lanes.h"

#include <algorithm>
#include <string_view>

#include "kernels/bsdf/bsdf.h"

namespace skywave {
namespace {

LaneCount& Of(LaneCounts& lanes, Kernel kernel, std::uint32_t kind = 0) {
  return lanes[std::uint32_t(kernel) + kind];
}

}  // namespace

std::string ToString(Kernel kernel) {
  const auto of_bsdf = [&](std::string_view name, Kernel first) {
    const std::uint32_t kind = std::uint32_t(kernel) - std::uint32_t(first);
    return std::string(name) + " " + std::string(Bsdfs()[kind].name);
  };
  if (kernel >= Kernel::kFilm) return "film";
  if (kernel >= Kernel::kScatter) return of_bsdf("scatter", Kernel::kScatter);
  if (kernel >= Kernel::kAccumulate) return "accumulate";
  if (kernel >= Kernel::kShadow) return "shadow";
  if (kernel >= Kernel::kEvaluate) return of_bsdf("evaluate", Kernel::kEvaluate);
  constexpr std::string_view kNames[] = {"generate", "intersect", "classify", "move escaped",
                                         "escape",   "move hits", "surface",  "light sample"};
  return std::string(kNames[std::uint32_t(kernel)]);
}

LaneCount& LaneCount::operator+=(const LaneCount& other) {
  active += other.active;
  for (std::size_t i = 0; i < issued.size(); ++i) issued[i] += other.issued[i];
  return *this;
}

double LaneCount::utilisation(std::uint32_t width) const {
  const auto at = std::find(kLaneWidths.begin(), kLaneWidths.end(), width) - kLaneWidths.begin();
  return issued[std::size_t(at)] > 0 ? double(active) / double(issued[std::size_t(at)]) : 0;
}

void CountTracing(std::uint32_t n, LaneCounts& lanes) {
  Of(lanes, Kernel::kIntersect).Add(n, n);
  Of(lanes, Kernel::kClassify).Add(n, n);
}

void CountEscaping(std::uint32_t n, std::uint32_t escaped, LaneCounts& lanes) {
  Of(lanes, Kernel::kMoveEscaped).Add(escaped, n);
  Of(lanes, Kernel::kEscape).Add(escaped, escaped);
}

void CountHits(std::uint32_t n, const SurfaceRanges& ranges, LaneCounts& lanes) {
  ForEachBsdf(ranges, kAllBsdfs, [&](const BsdfKernels&, const BsdfRows& rows) {
    Of(lanes, Kernel::kMoveHits).Add(rows.n, n);
  });
  Of(lanes, Kernel::kSurface).Add(ranges.total(), ranges.total());
}

void CountLighting(const SurfaceRanges& ranges, std::uint32_t open, std::uint32_t arrived,
                   LaneCounts& lanes) {
  const std::uint32_t n = ranges.light_sampled();
  Of(lanes, Kernel::kLightSample).Add(n, n);
  ForEachBsdf(ranges, kDenseBsdfs, [&](const BsdfKernels&, const BsdfRows& rows) {
    Of(lanes, Kernel::kEvaluate, rows.kind).Add(rows.n, rows.n);
  });
  Of(lanes, Kernel::kShadow).Add(open, n);
  Of(lanes, Kernel::kAccumulate).Add(arrived, n);
}

void CountScattering(const SurfaceRanges& ranges, std::uint32_t first_kind, LaneCounts& lanes) {
  const BsdfSpan bsdfs = {.first = first_kind, .end = kBsdfKinds};
  ForEachBsdf(ranges, bsdfs, [&](const BsdfKernels&, const BsdfRows& rows) {
    Of(lanes, Kernel::kScatter, rows.kind).Add(rows.n, rows.n);
  });
}

}  // namespace skywave
