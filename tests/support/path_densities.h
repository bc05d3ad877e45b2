// Multiple importance sampling of bidirectional paths by its definition, in double: from the list
// of all vertices of a path, the density of every way to sample it, each a product over all
// vertices, and the power heuristic of these densities.
#pragma once

#include <vector>

#include "tests/support/random_rows.h"

namespace skywave {

// A surface. Densities are those of sampling a direction [1/sr]; a delta BSDF has 1 for both, by
// the convention of kernels/light_paths/bidirectional.h.
struct PathSurface {
  Vec point, normal;
  bool delta = false;
  double pdf_to_light = 1;  // of the next vertex, given the one before
  double pdf_to_eye = 1;    // of the one before, given the next
};

enum class PathLight {
  kArea,         // a point of a surface
  kPosition,     // a point or spot
  kEnvironment,  // a direction that BSDFs can find
  kDirection     // one that they cannot
};

struct BidirectionalPath {
  Vec eye;
  double eye_pdf;                     // of the first direction, one sample a pixel [1/sr]
  double light_paths;                 // of the picture, for each sample of a pixel
  std::vector<PathSurface> surfaces;  // from the eye to the light, at least one
  PathLight light;
  Vec light_point;   // kEnvironment, kDirection: unit direction towards it
  Vec light_normal;  // kArea
  double light_pdf;  // of the point [1/length^2] or direction [1/sr] or light [1]
  // Of the first direction from the point [1/sr], or of points of the disk across the direction
  // [1/length^2].
  double emission_pdf;
  // Light sub-paths that a surface of the eye is merged with, times the area that they are merged
  // in; 0: there are no such ways.
  double eta_vcm = 0;

  bool distant() const {
    return light == PathLight::kEnvironment || light == PathLight::kDirection;
  }
};

// Density of the way with `lights` vertices on the sub-path from the light, the light counted, and
// the others from the eye; 0 if there is no such way. `lights` up to surfaces + 1: the last one is
// connected to the eye.
double WayDensity(const BidirectionalPath& path, std::size_t lights);

// Density of the way that merges both sub-paths at a surface, to which each of them leads; 0 if
// there is no such way.
double MergeDensity(const BidirectionalPath& path, std::size_t surface);

// The weights of all ways.
struct WayWeights {
  explicit WayWeights(const BidirectionalPath& path);
  std::vector<double> joined;  // by vertices on the sub-path from the light, from 0 on
  std::vector<double> merged;  // by surface
};

}  // namespace skywave
