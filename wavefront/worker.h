// What one thread owns: the tables of its wave, and what it counts. Allocated and first touched by
// the thread itself before its first wave; nothing is allocated after that.
#pragma once

#include <cstdint>

#include "kernels/columns.h"
#include "wavefront/light_groups.h"
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

struct Worker {
  explicit Worker(std::uint32_t wave)
      : paths(wave),
        rays{soa::Table<RayColumns>(wave), soa::Table<RayColumns>(wave)},
        hits(wave),
        queue(wave),
        escaped(wave),
        surfaces(wave),
        lights(wave),
        uniforms(wave),
        lobe(wave) {}

  soa::Table<PathColumns> paths;
  soa::Table<RayColumns> rays[2];  // this bounce's and the next one's, taking turns
  soa::Table<HitColumns> hits;
  soa::Table<QueueColumns> queue;
  soa::Table<EscapeColumns> escaped;
  soa::Table<SurfaceColumns> surfaces;
  SurfaceRanges ranges;  // rows of each BSDF in `surfaces`
  soa::Table<LightColumns> lights;
  soa::Table<UniformColumns> uniforms, lobe;
  soa::Table<GroupColumns> groups;  // without rows until a frame asks for groups of lights
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
