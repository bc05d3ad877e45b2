// Directional lights are exported as text for other renderers, each in its own axes and units.
//
// A light carries the irradiance E on a surface that faces it. A Lambert surface of albedo rho
// turns it into the radiance rho E cos / pi, which is what every renderer must show:
//
//   format   axes (map's right, forward, up)   number written               reflected by Lambert
//   pbrt     left-handed:  +x, +z, +y           L = E                        rho L cos / pi
//   povray   left-handed:  +x, +z, +y           colour = E / pi              rho colour cos
//   blender  right-handed: +x, +y, +z           energy * color = E [W/m^2]   rho E cos / pi
//   maya     right-handed: +x, -z, +y           intensity * color = E / pi   rho colour cos
//
// The axes are those in which `skywave render --env` lays a map in a world of the same handedness
// and up axis (EnvironmentFrame in scene/scene.h). Another up axis may be requested. POV-Ray's rho
// is pigment * diffuse, and needs assumed_gamma 1; Maya's is that of its own lambert shader.
#pragma once

#include <optional>
#include <span>
#include <string>
#include <string_view>

#include "base/names.h"
#include "lights/tables/cells.h"

namespace skywave {

enum class LightFormat { kTable, kJson, kPbrt, kPovray, kBlender, kMaya };
template <>
inline constexpr auto kEnumNames<LightFormat> =
    std::to_array<Named<LightFormat>>({{LightFormat::kTable, "table"},
                                       {LightFormat::kJson, "json"},
                                       {LightFormat::kPbrt, "pbrt"},
                                       {LightFormat::kPovray, "povray"},
                                       {LightFormat::kBlender, "blender"},
                                       {LightFormat::kMaya, "maya"}});

// A world has these unit vectors for the map's right, forward and up.
struct WorldAxes {
  Vector3 right, forward, up;
  Vector3 ToWorld(const Vector3& d) const { return d.x * right + d.y * forward + d.z * up; }
};
// up_axis is 'x', 'y' or 'z', or 0 for the format's own. kTable and kJson are in map space.
WorldAxes AxesOf(LightFormat format, char up_axis = 0);

struct ExportOptions {
  LightFormat format = LightFormat::kTable;
  char up_axis = 0;      // up axis of the exported world; 0: the format's own
  std::string source;    // the map, for the comment at the top
  std::string residual;  // file of the rest of the map to be shown as an environment; empty: none
  // Distance of POV-Ray's parallel lights from the origin; all objects must be nearer.
  double distance = 1e6;
};

// Returns the whole text; it ends with a newline and states the total irradiance in a comment.
// Numbers have nine digits: directions and energies parse back to 1e-8. pbrt expects `residual` to
// be an equal-area octahedral square, Blender and POV-Ray a lat-long map; the others leave it out.
std::string ExportLights(std::span<const DirectionalLight> lights, const ExportOptions& options);

}  // namespace skywave
