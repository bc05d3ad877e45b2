// A plane for a model that was made without one to stand on.
#pragma once

#include "scene/scene.h"

namespace skywave {

// Adds a square of grey Lambert under `bounds`, across scene.up_axis and facing up. It reaches far
// enough to look endless from a camera that frames the bounds, and lies a little lower than they
// do, so that a model with a flat base does not fight with it.
void AddGround(Scene& scene, const Bounds& bounds);

}  // namespace skywave
