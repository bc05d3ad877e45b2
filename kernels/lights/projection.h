// These kernels project a picture of a place back onto it: a photograph from the camera that took
// it, or an illumination map from the point above the ground where it was taken.
#pragma once

#include <cstdint>

#include "kernels/columns.h"
#include "kernels/lights/environment.h"
#include "kernels/lights/irradiance.h"

namespace skywave {

// A photograph, three floats per pixel from the top left corner on. A point of the world has the
// position (x / depth, y / depth) on it [pixels]; the rows of the matrix give x, y and depth.
struct PhotographView {
  const float* rgb = nullptr;
  std::uint32_t width = 0, height = 0;
  float pixel_from_world[3][4] = {};
};

// A map that was taken at `center`, `height` above a level ground, inside a sphere of which the
// ground cuts off the lower part.
struct DomeView {
  EnvironmentView map;  // as it is seen; it needs no texels of a light
  float center[3];      // world space
  float up[3];          // unit
  float height;
  float radius;  // > height; infinite: the ground goes on to the horizon
};

// What surfaces of the place look like: one of the two pictures.
struct ProjectionView {
  const PhotographView* photograph = nullptr;
  const DomeView* dome = nullptr;
  // The light of the place. Without nodes the picture shows reflectances, and not radiance.
  IrradianceView irradiance = {};
};

// Gives surfaces rows[0, n) the reflectance with which a matt surface looks like the picture, under
// the light of the place from which nothing hides it: rho = pi L / E, in [0, 1] (Debevec 1998,
// Section 6.2). Beyond a photograph its border goes on. May write padding rows of `rows`.
void ColorByProjection(const ProjectionView& projection, const std::uint32_t* rows, std::uint32_t n,
                       const SurfaceColumns& surfaces);

// Writes what rays [0, n) see of the map on the ground and on the dome to r, g, b.
void SeeDome(const DomeView& dome, const RayColumns& rays, std::uint32_t n, float* r, float* g,
             float* b);

}  // namespace skywave
