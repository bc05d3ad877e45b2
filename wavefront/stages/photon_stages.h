// The stages of photons: they are stored where light paths arrive, and looked up where camera paths
// do.
#pragma once

#include <cstdint>
#include <vector>

#include "kernels/light_paths/point_tree.h"
#include "wavefront/frame.h"
#include "wavefront/records/photon_map.h"
#include "wavefront/stages/photon_cover.h"
#include "wavefront/worker.h"

namespace skywave {

// Photons need these tables.
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

// The photons of a wave of light paths for one map. They are in the order of surfaces while paths
// are traced, and then in that of paths.
struct PhotonList {
  std::vector<Photon> photons;
  std::vector<std::uint32_t> path;     // row of each photon's path in the wave
  std::vector<PhotonSubpath> subpath;  // sub-path of each, where paths are merged; else empty

  void SortByPath(std::uint32_t paths);
};

struct PhotonLists {
  PhotonList caustic, indirect;
};

// Which maps still want photons; for a final gather the indirect one has all light.
struct WantedPhotons {
  bool caustic = false, indirect = false, all_light = false;
};

// Returns the photon that arrived at a surface, which is the `depth`-th of its path.
Photon PhotonAt(const SurfaceColumns& surfaces, std::uint32_t row, std::uint32_t depth);

// Stores photons at the surfaces of bounce `depth` of light paths that have a density, in the lists
// that want them, and remembers the surfaces.
void StorePhotons(const WantedPhotons& wanted, std::uint32_t depth, Worker& w, PhotonLists& lists,
                  StageClock& clock);

// Adds the radiance that the current surfaces reflect of photons to their paths: of photons that
// have hit at most `max_depth` surfaces, the current one included. Photons are divided by the area
// of the part of their disk that is surface; rays measure it where the photons leave it in doubt.
void AddPhotons(const FrameView& frame, const PhotonMap& map, std::uint32_t max_depth, Worker& w,
                StageClock& clock);

}  // namespace skywave
