// Computes multiple importance sampling of bidirectional paths by its definition, in double: from
// the list of all vertices of a path, the density of every technique that samples it, as a product
// over all vertices, and the power heuristic of these densities.
#pragma once

#include <vector>

#include "tests/support/random_rows.h"

namespace skywave {

// A surface. Densities refer to sampled directions [1/sr]; a delta BSDF has 1 for both, by the
// convention of kernels/light_paths/bidirectional.h.
struct PathSurface {
  Vec point, normal;
  bool delta = false;
  double pdf_to_light = 1;  // density of the next vertex, given the previous one
  double pdf_to_eye = 1;    // density of the previous vertex, given the next one
};

enum class PathLight {
  kArea,         // a point of a surface
  kPosition,     // a point light or spot
  kEnvironment,  // a direction that BSDFs can find
  kDirection     // a direction that BSDFs cannot find
};

struct BidirectionalPath {
  Vec eye;
  double eye_pdf;      // density of the first direction, with one sample per pixel [1/sr]
  double light_paths;  // light paths of the picture per sample of a pixel
  std::vector<PathSurface> surfaces;  // from the eye to the light, at least one
  PathLight light;
  Vec light_point;   // kEnvironment, kDirection: unit direction towards it
  Vec light_normal;  // kArea
  double light_pdf;  // density of the point [1/length^2] or direction [1/sr], or probability of the
                     // light [1]
  // Density of the first direction from the point [1/sr], or of points on the disk perpendicular to
  // the direction [1/length^2].
  double emission_pdf;
  // Number of light sub-paths with which a surface of the eye is merged, times the area of merging;
  // 0 if merging is not a technique.
  double eta_vcm = 0;

  bool distant() const {
    return light == PathLight::kEnvironment || light == PathLight::kDirection;
  }
};

// Returns the density of the technique with `lights` vertices on the light sub-path, including the
// light, and the others on the eye sub-path; 0 if the technique is impossible. `lights` is at most
// surfaces + 1, for which the last surface is connected to the eye.
double TechniqueDensity(const BidirectionalPath& path, std::size_t lights);

// Returns the density of the technique that merges both sub-paths at a surface that both reach; 0
// if it is impossible.
double MergeDensity(const BidirectionalPath& path, std::size_t surface);

// The weights of all techniques.
struct TechniqueWeights {
  explicit TechniqueWeights(const BidirectionalPath& path);
  std::vector<double> connected;  // by number of vertices on the light sub-path, from 0 on
  std::vector<double> merged;     // by surface
};

}  // namespace skywave
