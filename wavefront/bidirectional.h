// What bidirectional integrators keep besides the tables of a worker, and the stages that they add:
// vertices of light sub-paths, and their connections with those of the eye.
#pragma once

#include <cstdint>
#include <vector>

#include "kernels/bidirectional.h"
#include "kernels/columns.h"
#include "wavefront/frame.h"
#include "wavefront/soa.h"
#include "wavefront/worker.h"

namespace skywave {

// Both directions of a surface and another point, as its BSDF sees them.
struct BothWays {
  explicit BothWays(std::uint32_t wave) : forward(wave), backward(wave) {}
  soa::Table<BsdfValueColumns> forward, backward;  // of dir given wo; of wo given dir
};

// The surfaces of one bounce of the light sub-paths of a wave.
struct LightVertices {
  explicit LightVertices(std::uint32_t wave) : surfaces(wave), at(wave), row_of_path(wave) {}
  VertexView view() const { return {surfaces, at, row_of_path->queue}; }

  soa::Table<SurfaceColumns> surfaces;
  SurfaceRanges ranges;  // rows of each BSDF in `surfaces`
  soa::Table<SubpathColumns> at;
  soa::Table<QueueColumns> row_of_path;  // a path's row in `surfaces`, or kNoRow
};

// Evaluates the BSDFs of surfaces in directions dir of `lights`, both ways: value and density of
// dir given wo, and of wo given dir as a path that comes from there sees the surface. Rows of delta
// BSDFs are left as they are. Origins of surfaces that transmit move to the side of dir
// (MoveToSide). `turned`: room.
void EvaluateBothWays(const MaterialView& materials, const SurfaceColumns& surfaces,
                      const SurfaceRanges& ranges, const LightColumns& lights,
                      const TurnedColumns& turned, const BothWays& out);

}  // namespace skywave
