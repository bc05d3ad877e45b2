// A worker is what one thread owns: the tables of its wave, and what it counts. The thread itself
// allocates and first touches it before its first wave; nothing is allocated after that.
#pragma once

#include <cstdint>
#include <memory>
#include <optional>

#include "kernels/bsdf/bsdf.h"
#include "kernels/columns.h"
#include "kernels/light_paths/camera_connection.h"
#include "kernels/light_paths/emission.h"
#include "kernels/light_paths/flux.h"
#include "kernels/light_paths/point_tree.h"
#include "wavefront/bidirectional_tables.h"
#include "wavefront/film/light_groups.h"
#include "wavefront/frame.h"
#include "wavefront/scratch.h"
#include "wavefront/soa.h"
#include "wavefront/stats.h"

namespace skywave {

class Film;

// Light paths need these tables as well; integrators without light paths have none.
struct LightPathTables {
  explicit LightPathTables(std::uint32_t wave)
      : emission(wave), values(wave), cameras(wave), normals(wave) {}
  soa::Table<EmissionColumns> emission;
  soa::Table<BsdfValueColumns> values;
  soa::Table<CameraColumns> cameras;
  soa::Table<NormalColumns> normals;  // shading normals as the camera sees them
};

// Queries per batch.
inline constexpr std::uint32_t kLookupBlock = 16;

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

// Photons need these tables; other integrators have none.
struct PhotonTables {
  PhotonTables(std::uint32_t wave, std::uint32_t neighbors)
      : rays{soa::Table<RayColumns>(wave), soa::Table<RayColumns>(wave)},
        surfaces(wave),
        found(kLookupBlock * NearestRoom(neighbors)),
        repeated(NearestRoom(neighbors)),
        lights(NearestRoom(neighbors)),
        values(NearestRoom(neighbors)) {}
  // The final gather has rays of its own, and surfaces that they have left or meet.
  soa::Table<RayColumns> rays[2];
  soa::Table<SurfaceColumns> surfaces;
  SurfaceRanges ranges;
  soa::Table<NeighborColumns> found;
  // A surface is repeated, with what it reflects, for each photon near it.
  soa::Table<SurfaceColumns> repeated;
  soa::Table<LightColumns> lights;
  soa::Table<BsdfValueColumns> values;
};

// Virtual point lights need these tables; other integrators have none.
struct VirtualLightTables {
  explicit VirtualLightTables(std::uint32_t wave)
      : light(wave), to_eye(wave), partner(wave), turned(wave), seen(wave), seen_by_light(wave) {}
  LightVertices light;  // the current light, repeated for every surface that it shines on
  soa::Table<LightColumns> to_eye;
  soa::Table<IndexColumns> partner;
  soa::Table<TurnedColumns> turned;  // while the light is evaluated
  // Ends of connections; what only weights would need stays 0, as do sub-paths.
  BothDirections seen, seen_by_light;
};

// One row = one path of the wave.
struct RadianceColumns {
  float *r, *g, *b;  // [scene radiance]

  template <class Self, class F>
  static constexpr void ForEachColumn(Self& self, F f) {
    f(self.r), f(self.g), f(self.b);
  }
};

// The irradiance cache needs these tables; other integrators have none.
struct IrradianceTables {
  explicit IrradianceTables(std::uint32_t wave) : direct(wave), found(wave), ended(wave) {}
  soa::Table<RadianceColumns> direct;  // what the rays of records see at once
  soa::Table<IndexColumns> found;      // 1 for surfaces that have found records, else 0
  soa::Table<RayColumns> ended;        // rays of those, which see nothing but light
};

// Light that is kept apart by groups of lights goes here.
struct GroupTables {
  explicit GroupTables(std::uint32_t wave) : given(wave) {}
  soa::Table<GroupColumns> given;
  Film* film = nullptr;  // the one that the current wave is for
};

// A control variate needs these tables.
struct ControlTables {
  explicit ControlTables(std::uint32_t wave) : subtracted(wave), weights(wave) {}
  // What is subtracted from the current light samples, then from the rays that scatter.
  soa::Table<ControlColumns> subtracted;
  soa::Table<ControlWeightColumns> weights;  // of the current surfaces
};

struct Continuations;

struct Worker {
  explicit Worker(std::uint32_t wave);
  ~Worker();

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

  // Only integrators that need them have these (MakeWorker).
  std::optional<LightPathTables> light;
  std::optional<BidirectionalTables> bidirectional;
  std::optional<PhotonTables> photon;
  std::optional<MergeTables> merging;
  std::optional<VirtualLightTables> virtual_lights;
  std::optional<IrradianceTables> irradiance;
  std::optional<GroupTables> groups;
  std::optional<ControlTables> control;
  std::unique_ptr<Continuations> continuations;
};

// A worker needs these tables as well where paths split. A continuation has the row of its path:
// one wave follows the first continuation of every path, the next one the second, so the order in
// which a path gathers light is the same for every size of waves.
struct Continuations {
  explicit Continuations(std::uint32_t rows) : wave(rows), direct(rows) {}

  // The current continuations. The radiance of their paths is the sum over all so far, without what
  // their first rays see, which is in `direct`.
  Worker wave;
  soa::Table<RadianceColumns> direct;  // sums over the continuations of a path
};

// Makes a worker with the tables that the integrator of `options` needs, for waves of its size. The
// thread that will use the worker calls this.
std::unique_ptr<Worker> MakeWorker(const RenderOptions& options);

inline constexpr std::size_t kWorkerBytesPerRow =
    soa::BytesPerRow<PathColumns>() + 2 * soa::BytesPerRow<RayColumns>() +
    soa::BytesPerRow<HitColumns>() + soa::BytesPerRow<EscapeColumns>() +
    soa::BytesPerRow<SurfaceColumns>() + soa::BytesPerRow<LightColumns>() +
    soa::BytesPerRow<HistoryColumns>() + Scratch::kBytesPerRow;
// A wave of the default size must stay within 3/4 of a second-level cache of 1 MiB.
static_assert(kWorkerBytesPerRow * 2048 <= 768 * 1024);

}  // namespace skywave
