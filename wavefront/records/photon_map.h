// A photon map holds where light paths arrived, in an order in which neighbors are found.
//
// The photon pass hands over photons in the order (light path, surface), so a map depends on
// neither threads nor waves. A photon takes 36 bytes until the map is built, 41 in it, and 77 in
// between; where paths are merged (vcm), 44, 49 and 93.
#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include "kernels/light_paths/bidirectional.h"
#include "kernels/light_paths/photons.h"
#include "wavefront/records/point_tree.h"
#include "wavefront/soa.h"

namespace skywave {

// Options of photon mapping and of vertex connection and merging, whose light vertices count as
// indirect photons. As in pbrt, the counts are those of stored photons.
struct PhotonOptions {
  std::uint32_t indirect = 200000, caustic = 20000;
  std::uint32_t neighbors = 50;  // photons of a lookup, at most
  float distance = 0;            // largest of a lookup [world space]; 0: chosen by the photons
  PhotonKernel kernel = PhotonKernel::kEpanechnikov;
  // A surface sends this many rays of a final gather; 0: photons are looked up where it is seen.
  std::uint32_t gather = 1;
  // Several passes are progressive: each looks up everything within a radius that shrinks from pass
  // to pass. 0 means one pass, or one for each sample (IntegratorDescriptor::pass_each_sample).
  std::uint32_t passes = 0;
  float alpha = 2.0f / 3;  // how slowly the radius shrinks
  bool progressive() const { return passes > 1; }
};

// A photon is a row of PhotonColumns and its position in world space.
struct Photon {
  float position[3];
  float flux[3];
  std::uint32_t dir, normal, depth;
};

// This is a row of SubpathColumns.
struct PhotonSubpath {
  float d_vcm, d_vc;
};

// More photons do not fit an index of 31 bits together with those that a light path may add.
inline constexpr std::uint32_t kMostPhotons = 1000000000;

// Returns the memory of a photon while its map is built, of which half is kept [bytes].
constexpr std::uint64_t PhotonBytes(bool with_subpaths) {
  const std::size_t row = sizeof(Photon) + sizeof(PointTreeNode) / (kLeafPoints / 2) +
                          soa::BytesPerRow<TreeRowColumns>() + soa::BytesPerRow<PhotonColumns>();
  return row + (with_subpaths ? 2 * sizeof(PhotonSubpath) : 0);
}

struct PhotonMapView {
  PointTreeView tree;
  PhotonColumns photons;    // in the order of the tree's rows
  SubpathColumns subpaths;  // likewise, where paths are merged
  float radius2;            // largest squared distance of a lookup
};

class PhotonMap {
 public:
  PhotonMap() = default;
  // Builds the map of all photons of `light_paths` light paths, whose flux is divided by that
  // number, on the threads of the caller's arena. `subpaths` has one for every photon, or none.
  PhotonMap(std::span<const Photon> photons, std::uint64_t light_paths,
            std::span<const PhotonSubpath> subpaths = {});

  PhotonMapView view() const {
    return {.tree = tree_.view(),
            .photons = photons_.columns(),
            .subpaths = subpaths_.columns(),
            .radius2 = radius * radius};
  }
  std::uint32_t size() const { return photons_.rows(); }
  std::uint64_t light_paths() const { return light_paths_; }
  std::size_t bytes() const;
  // Returns the distance within which a photon has `neighbors` others (or all there are): the
  // median over some of them. It is 0 for an empty map.
  float TypicalDistance(std::uint32_t neighbors) const;

  float radius = 0;  // largest distance of a lookup
  float near = 0;    // the radius of a usual lookup, at most `radius`

 private:
  PointTree tree_;
  soa::Table<PhotonColumns> photons_;
  soa::Table<SubpathColumns> subpaths_;
  std::uint64_t light_paths_ = 0;
};

// The second pass looks these maps up.
struct PhotonMaps {
  // Light from mirrors and glass alone, which light samples cannot find.
  PhotonMap caustic;
  // All other light except direct light; for a final gather, which looks it up one surface further
  // on, all light. Where paths are merged, the vertices of the light sub-paths.
  PhotonMap indirect;
};

}  // namespace skywave
