// Adds a ground plane to models that come without one.
#pragma once

#include "scene/scene.h"

namespace skywave {

// Adds a grey Lambertian square under `bounds`, perpendicular to scene.up_axis and facing up. It is
// large enough to look endless from a camera that frames the bounds, and lies slightly below them
// so that it does not coincide with the flat base of a model.
void AddGround(Scene& scene, const Bounds& bounds);

}  // namespace skywave
