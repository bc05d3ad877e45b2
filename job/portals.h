// Portals that the user gives (--portal).
#pragma once

#include <string>
#include <vector>

#include "scene/scene.h"

namespace skywave {

// Adds portals to the scene: each text is twelve numbers X,Y,Z,..., four corners (scene/portals.h),
// or the name of a mesh, which then is no longer a surface. Throws OptionError for a text that is
// neither, for corners of no rectangle, for portals from which no part of the scene is lit, and
// where there are too many.
void AddPortals(const std::vector<std::string>& texts, Scene& scene);

}  // namespace skywave
