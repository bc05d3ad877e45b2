// A worker is what one thread owns: the tables of its wave, and what it counts. The thread itself
// allocates and first touches it before its first wave; nothing is allocated after that.
#pragma once

#include <cassert>
#include <cstdint>
#include <memory>

#include "kernels/bsdf/bsdf.h"
#include "kernels/columns.h"
#include "wavefront/frame.h"
#include "wavefront/scratch.h"
#include "wavefront/slots.h"
#include "wavefront/soa.h"
#include "wavefront/stats.h"

namespace skywave {

// Bits of HistoryColumns::met.
inline constexpr std::uint32_t kMetDense = 1, kMetDelta = 2;

// One row = one path of the wave.
struct HistoryColumns {
  std::uint32_t* met;  // the kinds of BSDFs that it has met, where somebody asks (RememberSurfaces)

  template <class Self, class F>
  static constexpr void ForEachColumn(Self& self, F f) {
    f(self.met);
  }
};

// One row = one path of the wave.
struct RadianceColumns {
  float *r, *g, *b;  // [scene radiance]

  template <class Self, class F>
  static constexpr void ForEachColumn(Self& self, F f) {
    f(self.r), f(self.g), f(self.b);
  }
};

struct Worker {
  explicit Worker(std::uint32_t wave);

  soa::Table<PathColumns> paths;
  soa::Table<RayColumns> rays[2];  // this bounce's and the next one's, taking turns
  soa::Table<HitColumns> hits;
  soa::Table<EscapeColumns> escaped;
  soa::Table<SurfaceColumns> surfaces;
  SurfaceRanges ranges;  // rows of each BSDF in `surfaces`
  soa::Table<LightColumns> lights;
  soa::Table<HistoryColumns> history;
  Scratch scratch;
  RenderStats stats;

  TableSlots tables;  // of the integrator and of policies, by type (MakeWorker)

  // Returns the tables of a type, which the integrator or a policy has added.
  template <class Tables>
  Tables& of() const {
    Tables* const found = tables.find<Tables>();
    assert(found != nullptr);
    return *found;
  }
};

// Makes a worker with the tables that the integrator of `options` needs, for waves of its size. The
// thread that will use the worker calls this.
std::unique_ptr<Worker> MakeWorker(const RenderOptions& options);

inline constexpr std::size_t kWorkerBytesPerRow =
    soa::BytesPerRow<PathColumns>() + 2 * soa::BytesPerRow<RayColumns>() +
    soa::BytesPerRow<HitColumns>() + soa::BytesPerRow<EscapeColumns>() +
    soa::BytesPerRow<SurfaceColumns>() + soa::BytesPerRow<LightColumns>() +
    soa::BytesPerRow<HistoryColumns>() + Scratch::kBytesPerRow;
// A wave of the default size must stay within 3/4 of a second-level cache of 1 MiB. The columns
// that only Varying::kLayers has are in no cache where no surface has it.
inline constexpr std::size_t kLayerBytesPerRow = 2 * sizeof(float);
static_assert((kWorkerBytesPerRow - kLayerBytesPerRow) * 2048 <= 768 * 1024);

}  // namespace skywave
