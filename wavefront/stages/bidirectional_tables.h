// Integrators that connect or merge sub-paths from the eye and from lights keep these tables in
// addition to the common ones.
#pragma once

#include <cstdint>
#include <vector>

#include "kernels/columns.h"
#include "kernels/light_paths/bidirectional.h"
#include "kernels/light_paths/point_tree.h"
#include "wavefront/soa.h"

namespace skywave {

// This is the depth limit of paths whose sub-paths are connected: a worker keeps the light vertices
// of every bounce.
inline constexpr std::uint32_t kMaxBidirectionalDepth = 64;

struct IndexColumns {
  std::uint32_t* index;

  template <class Self, class F>
  static constexpr void ForEachColumn(Self& self, F f) {
    f(self.index);
  }
};

// One row is one light sample, or one ray that hit light.
struct ArrivalColumns {
  float* pdf;  // see kernels/light_paths/arrival.h [1/length^2]

  template <class Self, class F>
  static constexpr void ForEachColumn(Self& self, F f) {
    f(self.pdf);
  }
};

// A BSDF is evaluated in both directions between its surface and another point.
struct BothDirections {
  explicit BothDirections(std::uint32_t wave) : forward(wave), backward(wave) {}
  soa::Table<BsdfValueColumns> forward, backward;  // of dir given wo; of wo given dir
};

// These are the surfaces of one bounce of the light sub-paths of a wave.
struct LightVertices {
  explicit LightVertices(std::uint32_t wave) : surfaces(wave), at(wave), row_of_path(wave) {}
  VertexView view() const { return {surfaces, at, row_of_path->index}; }

  soa::Table<SurfaceColumns> surfaces;
  SurfaceRanges ranges;  // rows of each BSDF in `surfaces`
  soa::Table<SubpathColumns> at;
  soa::Table<IndexColumns> row_of_path;  // a path's row in `surfaces`, or kNoRow
};

struct BidirectionalTables {
  // `depth` is the number of surfaces of the longest path.
  BidirectionalTables(std::uint32_t wave, std::uint32_t depth)
      : eye_rays(wave),
        eye(wave),
        light(wave),
        at(wave),
        arrival(wave),
        to_eye(wave),
        partner(wave),
        turned(wave),
        seen(wave),
        seen_by_light(wave) {
    vertices.reserve(depth);
    for (std::uint32_t i = 0; i < depth; ++i) vertices.emplace_back(wave);
  }

  std::vector<LightVertices> vertices;    // by bounce
  soa::Table<RayColumns> eye_rays;        // while light sub-paths are traced
  soa::Table<SubpathColumns> eye, light;  // between vertices, one row per path
  soa::Table<SubpathColumns> at;          // at the eye's current surfaces
  soa::Table<ArrivalColumns> arrival;     // at light samples, and at light that the eye hits
  soa::Table<LightColumns> to_eye;        // from light vertices
  soa::Table<IndexColumns> partner;       // light vertex of each surface of the eye
  soa::Table<TurnedColumns> turned;       // while surfaces are evaluated backwards
  BothDirections seen, seen_by_light;     // ends of connections
};

// A row is a pair of vertices that are merged: a surface of the eye and a vertex of a light
// sub-path.
struct MergeTables {
  static constexpr std::uint32_t kRows = 512;
  soa::Table<NeighborColumns> found{kRows};    // rows of the light vertices
  soa::Table<LightColumns> lights{kRows};      // light that arrives there
  soa::Table<SurfaceColumns> surfaces{kRows};  // copies of the eye's surfaces
  soa::Table<SubpathColumns> at{kRows};        // copies of its sub-paths
  soa::Table<TurnedColumns> turned{kRows};     // while they are evaluated backwards
  BothDirections seen{kRows};
};

}  // namespace skywave
