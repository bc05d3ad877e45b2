// These kernels sample an illumination map through portals (Bitterli et al. 2015): rectangular
// openings that the light of the map has to pass.
//
// A portal sees the half of the map that lies in front of it in a rectified form: a direction
// (x, y, z) of the portal's frame, whose axes are its sides and its normal, lies at the angles
// atan2(x, z) and atan2(y, z), each in (-pi/2, pi/2). Lines parallel to a side of the portal are
// then lines of one angle, so that any point sees through the portal a rectangle of the rectified
// map. The energy of the texels that it meets is read off a summed-area table, and a direction in
// them is found by two searches.
#pragma once

#include <cstdint>
#include <glm/glm.hpp>

#include "kernels/columns.h"

namespace skywave {

// A rectangle in the world: corner + a side_x + b side_y, a and b in [0, 1], with sides that are
// perpendicular. Light comes in from the side of side_x x side_y and lights what lies on the other.
struct Portal {
  glm::vec3 corner, side_x, side_y;
};

// A portal as kernels read it: 16 words.
struct PortalRecord {
  float corner[3];
  float size_x;  // length of the side
  float x[3];    // axes of the portal, unit vectors
  float size_y;
  float y[3];
  float unit;          // share of the map's energy that a unit of its rectified map stands for
  float z[3];          // into the light
  std::uint32_t sums;  // first entry of its rectified map
};
inline constexpr int kLogPortalWords = 4;
static_assert(sizeof(PortalRecord) == sizeof(std::uint32_t) << kLogPortalWords);

inline constexpr std::uint32_t kMaxPortals = 64;
inline constexpr std::uint32_t kNoPortal = 0xFFFFFFFFu;

// A rectified map is `texels` x `texels` texels of equal size in both angles, constant inside in
// energy per square of angle, which is at least one unit. Summed-area tables hold whole units, so
// their differences are exact; a map has less than 2^31 of them. Entry (row, column) of the
// texels + 1 squared is the sum over [0, column) x [0, row), row-major. A search along a column
// would read another page at every step there, so it has a table of its own.
struct PortalsView {
  const PortalRecord* portals;
  std::uint32_t count;  // at most kMaxPortals
  const std::uint32_t* sums;
  const std::uint32_t* columns;  // as `sums`, column-major, over the rows [0, row) of one column
  std::uint32_t texels;
};

// The portals that rows draw a direction through.
struct PortalPickColumns {
  std::uint32_t* portal;  // kNoPortal: none
  float* u;               // the rest of the uniform number, in [0, 1)

  template <class Self, class F>
  static constexpr void ForEachColumn(Self& self, F f) {
    f(self.portal), f(self.u);
  }
};

// Picks a portal by the energy that the surface sees through it with probability 1 - share, for
// surfaces [0, n); none where it sees no light through any. Writes the sum of these energies, as a
// share of the map's, to `energy`. Where a surface is does not depend on `lift`.
void PickPortals(const PortalsView& view, const SurfaceColumns& surfaces, const float* u,
                 float share, std::uint32_t n, float* energy, const PortalPickColumns& picks);

// Writes directions through the picked portals to dir of rows [0, n), whose density is that of the
// rectified map; rows without a portal get some unit vector.
void SamplePortals(const PortalsView& view, const SurfaceColumns& surfaces,
                   const PortalPickColumns& picks, const float* v, std::uint32_t n,
                   const LightColumns& out);

// Directions are drawn by PickPortals and SamplePortals, and by another technique of density pdf[i]
// where they do not. This replaces pdf[i] by the density of both, times `samples`, for directions
// dir of rows [0, n). `energy` is what PickPortals has written for the surfaces.
struct PortalDirections {
  const float *dir_x, *dir_y, *dir_z;
  // The rows of surfaces, where bsdf_pdf is not 0; other rows left none. Null: row i is surface i.
  const std::uint32_t* from = nullptr;
  const float* bsdf_pdf = nullptr;
};
void MixPortalDensity(const PortalsView& view, const SurfaceColumns& surfaces, const float* energy,
                      const PortalDirections& directions, float share, float samples,
                      std::uint32_t n, float* pdf);

}  // namespace skywave
