// Reads the lens files of pbrt's realistic cameras.
#pragma once

#include <string>
#include <vector>

#include "scene/lens_system.h"

namespace skywave {

// Reads the interfaces of a lens, from the scene to the film: radius of curvature, thickness, index
// of refraction and diameter of each, in millimetres, and comments after "#". Returns them in
// metres. Throws InputError with the line, or with the interface that is none.
std::vector<LensInterface> ParsePbrtLens(const std::string& text, const std::string& path);

}  // namespace skywave
