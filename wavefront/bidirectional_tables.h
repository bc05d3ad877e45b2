// What integrators that join or merge sub-paths from the eye and from lights keep besides the
// tables of all.
#pragma once

#include <cstdint>
#include <vector>

#include "kernels/columns.h"
#include "kernels/light_paths/bidirectional.h"
#include "kernels/light_paths/point_tree.h"
#include "wavefront/soa.h"

namespace skywave {

// Deepest path whose sub-paths are joined: a worker keeps the light vertices of every bounce.
inline constexpr std::uint32_t kMaxBidirectionalDepth = 64;

struct IndexColumns {
  std::uint32_t* index;

  template <class Self, class F>
  static constexpr void ForEachColumn(Self& self, F f) {
    f(self.index);
  }
};

// One row = one light sample, or one ray that met light.
struct ArrivalColumns {
  float* pdf;  // see kernels/light_paths/arrival.h [1/length^2]

  template <class Self, class F>
  static constexpr void ForEachColumn(Self& self, F f) {
    f(self.pdf);
  }
};

// Both directions of a surface and another point, as its BSDF sees them.
struct BothDirections {
  explicit BothDirections(std::uint32_t wave) : forward(wave), backward(wave) {}
  soa::Table<BsdfValueColumns> forward, backward;  // of dir given wo; of wo given dir
};

// The surfaces of one bounce of the light sub-paths of a wave.
struct LightVertices {
  explicit LightVertices(std::uint32_t wave) : surfaces(wave), at(wave), row_of_path(wave) {}
  VertexView view() const { return {surfaces, at, row_of_path->index}; }

  soa::Table<SurfaceColumns> surfaces;
  SurfaceRanges ranges;  // rows of each BSDF in `surfaces`
  soa::Table<SubpathColumns> at;
  soa::Table<IndexColumns> row_of_path;  // a path's row in `surfaces`, or kNoRow
};

struct BidirectionalTables {
  // `depth`: surfaces of the longest path.
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
  soa::Table<SubpathColumns> eye, light;  // on their way, one row a path
  soa::Table<SubpathColumns> at;          // of the eye's surfaces at hand
  soa::Table<ArrivalColumns> arrival;     // of the light's own sub-paths
  soa::Table<LightColumns> to_eye;        // from light vertices
  soa::Table<IndexColumns> partner;       // of the eye's surfaces
  soa::Table<TurnedColumns> turned;       // while surfaces are evaluated backwards
  BothDirections seen, seen_by_light;     // ends of connections
};

// Pairs of vertices that are merged: of a surface of the eye and a vertex of a light sub-path.
struct MergeTables {
  static constexpr std::uint32_t kRows = 512;
  soa::Table<NeighborColumns> found{kRows};    // rows of the light vertices
  soa::Table<LightColumns> lights{kRows};      // what arrives there
  soa::Table<SurfaceColumns> surfaces{kRows};  // copies of the eye's
  soa::Table<SubpathColumns> at{kRows};        // and of its sub-paths
  soa::Table<TurnedColumns> turned{kRows};     // while they are evaluated backwards
  BothDirections seen{kRows};
};

}  // namespace skywave
