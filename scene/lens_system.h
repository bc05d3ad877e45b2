// The lens of a realistic camera: elements of glass and a stop, as optical designs list them (Kolb,
// Mitchell and Hanrahan 1995; Pharr, Jakob and Humphreys 2016, 6.4).
#pragma once

#include <optional>
#include <vector>

#include "kernels/lens.h"

namespace skywave {

// An interface between two media [camera space]. A radius of curvature of 0 is the stop; a positive
// one has its centre on the side of the film.
struct LensInterface {
  double radius = 0;
  double thickness = 0;  // along the axis, to the next interface or the film
  double ior = 1;        // of the medium up to there
  double aperture = 0;   // radius
};

// How bright the film is: as irradiance, which is cos^4 area / distance^2 of the pupil, or relative
// to the box around the pupil of its middle, so that it is about as bright as that of a pinhole.
enum class LensWeight { kIrradiance, kRelative };

struct LensDesign {
  std::vector<LensInterface> interfaces;  // from the scene to the film
  double film_diagonal = 0;               // [camera space]
  LensWeight weight = LensWeight::kIrradiance;
  double gain = 1;  // factor of all weights
};

// Moves the film to where a point on the axis is sharp that is `distance` from it, by the thick
// lens that paraxial rays see. Returns false, and leaves the film alone, if there is no such place.
bool FocusLens(LensDesign& design, double distance);

// Returns the focal length of the thick lens, 0 if rays along the axis do not pass.
double FocalLength(const LensDesign& design);

// Follows a ray from the film, which is the plane z = 0, to the scene; nothing if it does not pass.
struct LensRayOfFilm {
  double origin[3], dir[3];  // unit
};
std::optional<LensRayOfFilm> FollowFromFilm(const LensDesign& design, const LensRayOfFilm& ray);

// A lens in the form that kernels read, and the columns that it points to.
struct LensSystem {
  explicit LensSystem(const LensDesign& of);
  LensSystem(const LensSystem&) = delete;
  LensSystem& operator=(const LensSystem&) = delete;

  LensDesign design;
  double focal_length = 0;
  std::vector<float> columns;
  LensView view;
};

}  // namespace skywave
