// Photons are light that arrived at surfaces; surfaces near them reflect radiance of it.
#pragma once

#include <cstdint>

#include "kernels/bsdf/bsdf.h"
#include "kernels/columns.h"
#include "kernels/light_paths/point_tree.h"

namespace skywave {

// One row is one photon: a light path that arrived at a surface with a density. The photon pass
// writes them in the order (light path, surface), then the map in the order of its tree.
struct PhotonColumns {
  float *r, *g, *b;       // flux [radiance * area * sr]
  std::uint32_t* dir;     // EncodeNormal of the direction that it came from, world space
  std::uint32_t* normal;  // EncodeNormal of the geometric normal, on dir's side
  std::uint32_t* depth;   // surfaces that the light path has hit, this one included

  template <class Self, class F>
  static constexpr void ForEachColumn(Self& self, F f) {
    f(self.r), f(self.g), f(self.b);
    f(self.dir), f(self.normal), f(self.depth);
  }
};

// A kernel weighs a photon at distance d from the middle of a disk; each integrates to 1 over the
// disk of radius r.
enum class PhotonKernel {
  kConstant,     // 1 / (pi r^2): T 4.7
  kCone,         // 3 / (pi r^2) (1 - d / r)
  kEpanechnikov  // 2 / (pi r^2) (1 - d^2 / r^2)
};

// The query by which a surface looks for photons around it.
struct PhotonQuery {
  PhotonKernel kernel;
  float radius2;            // squared radius of the disk, > 0
  float normal[3];          // geometric normal of the surface, unit
  std::uint32_t max_depth;  // photons of longer light paths do not count
};

// Photons lie on the same surface if the cosine between normals is larger than this; the sign does
// not matter, so those of its back count too.
inline constexpr float kLeastNormalCosine = 0.5f;

// Turns neighbors [0, n) into light from dir with r, g, b = flux * kernel / |cos|, the cosine
// between dir and the query's normal: times f |cos| it is reflected radiance. It is black where the
// photon does not count. Neighbors of a leaf have to follow each other, as searches find them, or
// it is slow.
void LoadPhotons(const PhotonColumns& photons, const NeighborColumns& found, std::uint32_t n,
                 const PhotonQuery& query, const LightColumns& out);

// Adds the sum of values * light over rows [0, n) to rgb. The order of addition is fixed: sixteen
// sums, row i in sum i % 16, and then these one after the other.
void SumReflected(const BsdfValueColumns& values, const LightColumns& light, std::uint32_t n,
                  float* rgb);

// Copies a surface to rows [0, n) of `to`, and up to the end of the last vector: its BSDF is
// evaluated for a vector of photons at a time. The columns are those that BsdfKernels::evaluate
// reads.
void RepeatSurface(const SurfaceColumns& from, std::uint32_t row, std::uint32_t n,
                   const SurfaceColumns& to);

}  // namespace skywave
