// Holes in a scene: the records by which rays pass through triangles (kernels/surface/opacity.h).
#pragma once

#include <vector>

#include "kernels/surface/opacity.h"
#include "scene/scene.h"

namespace skywave {

// Returns the records of all materials, in their order.
std::vector<OpacityRecord> MakeOpacityRecords(const std::vector<Material>& materials);

}  // namespace skywave
