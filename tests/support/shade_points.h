// Surfaces in the form that strategies need, for tests that have nothing but surfaces.
#pragma once

#include "kernels/sampler.h"
#include "lights/strategies/strategy.h"
#include "tests/support/random_rows.h"

namespace skywave {

// Returns rows [0, rows) as surfaces of one BSDF.
inline SurfaceRanges RangesOf(BsdfKind kind, std::uint32_t rows) {
  SurfaceRanges ranges;
  for (std::uint32_t k = std::uint32_t(kind); k < kBsdfKinds; ++k) ranges.begin[k + 1] = rows;
  return ranges;
}

// Rows [0, rows) of `surfaces`, all of them Lambert, each on a path of its own.
class LambertPoints {
 public:
  LambertPoints(const SurfaceColumns& surfaces, std::uint32_t rows)
      : surfaces_(surfaces), ranges_(RangesOf(BsdfKind::kLambert, rows)), paths_(rows) {
    for (std::uint32_t i = 0; i < rows; ++i) paths_->seed[i] = PixelSeed(i, 3, 5);
  }
  operator ShadePoints() const {
    return {.surfaces = surfaces_, .ranges = ranges_, .materials = materials_, .paths = paths_};
  }

 private:
  SurfaceColumns surfaces_;
  SurfaceRanges ranges_;
  MaterialView materials_ = {};
  soa::Table<PathColumns> paths_;  // row by row
};

// Sets a grey surface of the unit sphere about the origin, which faces the eye.
inline void PutSurface(Vec normal, std::uint32_t i, const SurfaceColumns& surfaces) {
  Put(normal, i, surfaces.org_x, surfaces.org_y, surfaces.org_z);
  Put(normal, i, surfaces.ns_x, surfaces.ns_y, surfaces.ns_z);
  Put(normal, i, surfaces.ng_x, surfaces.ng_y, surfaces.ng_z);
  Put(normal, i, surfaces.wo_x, surfaces.wo_y, surfaces.wo_z);
  Put({0.5, 0.5, 0.5}, i, surfaces.color_r, surfaces.color_g, surfaces.color_b);
  Put({1, 1, 1}, i, surfaces.throughput_r, surfaces.throughput_g, surfaces.throughput_b);
  surfaces.lift[i] = 0;
  surfaces.material[i] = 0;
  surfaces.path[i] = i;
}

// Returns portals around the origin: two that overlap, one beside them in another wall, and one
// that lights only what lies beyond it.
inline std::vector<Portal> PortalsAroundTheOrigin() {
  return {{.corner = {-1, -0.5f, 1}, .side_x = {1.5f, 0, 0}, .side_y = {0, 1, 0}},
          {.corner = {-0.25f, 0, 1.5f}, .side_x = {2, 0, 0}, .side_y = {0, 1, 0}},
          {.corner = {2, -1, -1}, .side_x = {0, 1.5f, 0}, .side_y = {0, 0, 1}},
          {.corner = {-1, -1, -1}, .side_x = {1, 0, 0}, .side_y = {0, 1, 0}}};
}

// Returns surfaces with one normal.
inline soa::Table<SurfaceColumns> SurfacesWith(Vec normal, std::uint32_t rows) {
  soa::Table<SurfaceColumns> surfaces(rows);
  for (std::uint32_t i = 0; i < rows; ++i) PutSurface(normal, i, surfaces);
  return surfaces;
}

// One number of a colour, for which no two channels count the same.
inline double Weighted(double r, double g, double b) { return 0.5 * r + 0.3 * g + 0.2 * b; }

}  // namespace skywave
