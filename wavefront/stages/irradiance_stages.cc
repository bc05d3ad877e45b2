#include "wavefront/stages/irradiance_stages.h"

#include <algorithm>
#include <array>
#include <bit>
#include <numbers>
#include <type_traits>

#include "wavefront/records/irradiance_cache.h"

namespace skywave {
namespace {

// Copies a row of one table of rays to a row of another one.
void CopyRay(const RayColumns& from, std::uint32_t row, const RayColumns& to, std::uint32_t copy) {
  std::array<std::uint32_t, soa::CountColumns<RayColumns>()> words;
  std::uint32_t* word = words.data();
  RayColumns::ForEachColumn(
      from, [&](const auto* column) { *word++ = std::bit_cast<std::uint32_t>(column[row]); });
  word = words.data();
  RayColumns::ForEachColumn(to, [&](auto* column) {
    column[copy] = std::bit_cast<std::remove_reference_t<decltype(*column)>>(*word++);
  });
}

}  // namespace

void AddCachedIrradiance(const FrameView& frame, Worker& w, StageClock& clock) {
  constexpr auto kDiffuse = std::uint32_t(BsdfKind::kLambert);
  const SurfaceColumns& s = w.surfaces;
  std::uint32_t* const found = w.of<IrradianceTables>().found->index;
  std::fill_n(found, w.ranges.total(), 0u);
  const auto* const cache = frame.find<IrradianceCache>();
  if (cache == nullptr) return;
  const std::uint32_t begin = w.ranges.begin[kDiffuse];
  for (std::uint32_t row = begin; row < begin + w.ranges.count(kDiffuse); ++row) {
    Triple irradiance;
    if (!cache->Interpolate({s.org_x[row], s.org_y[row], s.org_z[row]},
                            {s.ns_x[row], s.ns_y[row], s.ns_z[row]}, irradiance)) {
      continue;
    }
    found[row] = 1;
    const std::uint32_t path = s.path[row];
    const auto add = [&](float throughput, float color, float light, float& sum) {
      sum += throughput * (color * std::numbers::inv_pi_v<float> * light);
    };
    add(s.throughput_r[row], s.color_r[row], irradiance[0], w.paths->r[path]);
    add(s.throughput_g[row], s.color_g[row], irradiance[1], w.paths->g[path]);
    add(s.throughput_b[row], s.color_b[row], irradiance[2], w.paths->b[path]);
  }
  clock.Lap(Stage::kPhotons);
}

std::uint32_t EndCachedPaths(const RayColumns& rays, std::uint32_t n, Worker& w,
                             std::uint32_t& ended) {
  const std::uint32_t* const found = w.of<IrradianceTables>().found->index;
  std::uint32_t going_on = 0;
  ended = 0;
  for (std::uint32_t i = 0; i < n; ++i) {
    if (found[rays.from[i]] != 0) {
      CopyRay(rays, i, w.of<IrradianceTables>().ended, ended++);
    } else {
      CopyRay(rays, i, rays, going_on++);
    }
  }
  return going_on;
}

}  // namespace skywave
