// What one thread owns: the tables of its wave, and what it counts. Allocated and first touched by
// the thread itself before its first wave; nothing is allocated after that.
#pragma once

#include <cstdint>
#include <optional>

#include "kernels/bsdf.h"
#include "kernels/camera_connection.h"
#include "kernels/columns.h"
#include "kernels/emission.h"
#include "wavefront/bidirectional_tables.h"
#include "wavefront/soa.h"
#include "wavefront/stats.h"

namespace skywave {

struct QueueColumns {
  // Of each ray after partition, see kernels/partition.h. While rays are traced in scenes with
  // holes, the queue being of no use then: their keys.
  std::uint32_t* queue;

  template <class Self, class F>
  static constexpr void ForEachColumn(Self& self, F f) {
    f(self.queue);
  }
};

// What light paths need beside; integrators without them have none.
struct LightPathTables {
  explicit LightPathTables(std::uint32_t wave) : emission(wave), values(wave), cameras(wave) {}
  soa::Table<EmissionColumns> emission;
  soa::Table<BsdfValueColumns> values;
  soa::Table<CameraColumns> cameras;
};

struct Worker {
  // `joined_depth`: surfaces of the longest path whose sub-paths are joined; unset: none are.
  explicit Worker(std::uint32_t wave, bool has_light_paths = false,
                  std::optional<std::uint32_t> joined_depth = std::nullopt)
      : paths(wave),
        rays{soa::Table<RayColumns>(wave), soa::Table<RayColumns>(wave)},
        hits(wave),
        queue(wave),
        escaped(wave),
        surfaces(wave),
        lights(wave),
        uniforms(wave),
        lobe(wave) {
    if (has_light_paths) light.emplace(wave);
    if (joined_depth) bidirectional.emplace(wave, *joined_depth);
  }

  soa::Table<PathColumns> paths;
  soa::Table<RayColumns> rays[2];  // this bounce's and the next one's, taking turns
  soa::Table<HitColumns> hits;
  soa::Table<QueueColumns> queue;
  soa::Table<EscapeColumns> escaped;
  soa::Table<SurfaceColumns> surfaces;
  SurfaceRanges ranges;  // rows of each BSDF in `surfaces`
  soa::Table<LightColumns> lights;
  soa::Table<UniformColumns> uniforms, lobe;
  std::optional<LightPathTables> light;
  std::optional<BidirectionalTables> bidirectional;
  RenderStats stats;
};

inline constexpr std::size_t kWorkerBytesPerRow =
    soa::BytesPerRow<PathColumns>() + 2 * soa::BytesPerRow<RayColumns>() +
    soa::BytesPerRow<HitColumns>() + soa::BytesPerRow<QueueColumns>() +
    soa::BytesPerRow<EscapeColumns>() + soa::BytesPerRow<SurfaceColumns>() +
    soa::BytesPerRow<LightColumns>() + 2 * soa::BytesPerRow<UniformColumns>();
// Columns crept in: a wave of 1024 rows must stay within 3/4 of a second-level cache of 512 KiB.
static_assert(kWorkerBytesPerRow * 1024 <= 384 * 1024);

}  // namespace skywave
