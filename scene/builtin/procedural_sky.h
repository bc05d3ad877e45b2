// A clear sky with a small bright sun as a lat-long map lights the built-in scenes.
//
// It is not a physical model: the radiance goes from a hazy horizon to a blue zenith with the sine
// of the elevation (as the thickness of the air does), with a glow around the sun. Below the
// horizon the ground fades into the haze. The sun is a disc of uniform radiance.
#pragma once

#include <glm/glm.hpp>

#include "image/image.h"

namespace skywave {

struct ProceduralSky {
  int width = 1024, height = 512;  // [pixels]
  // The azimuth is measured from the middle of the map towards its right half, the elevation
  // upwards. [degrees]
  float sun_azimuth_degrees = -118, sun_elevation_degrees = 38;
  // The sun is much wider than the real half degree because it has to cover some texels.
  float sun_diameter_degrees = 2;
  // Radiance. The sun is about 10^4 times as bright as the sky around it; together they light a
  // grey floor to about 0.5.
  glm::vec3 sun{3300, 2950, 2450};
  glm::vec3 zenith{0.07f, 0.15f, 0.36f};
  glm::vec3 horizon{0.42f, 0.50f, 0.58f};
  glm::vec3 ground{0.14f, 0.13f, 0.11f};
  glm::vec3 glow{0.55f, 0.48f, 0.36f};  // added at the sun's rim
};

// Returns the map: forward is the centre, the right half lies to the right, and row 0 is up. The
// sun's radiance is spread over the texels that its disc touches, weighted by the covered fraction
// of each, and scaled so that the sum of radiance times solid angle over them is exactly `sun`
// times the solid angle of the disc.
Image MakeProceduralSky(const ProceduralSky& sky);

}  // namespace skywave
