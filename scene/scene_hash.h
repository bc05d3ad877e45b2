// The hash by which pictures tell the scenes that they show apart.
#pragma once

#include <cstdint>

#include "scene/scene.h"

namespace skywave {

// Returns a hash of everything that decides what a scene looks like: meshes, materials, camera and
// lights. Two scenes with the same hash give the same picture for the same settings.
std::uint64_t SceneHash(const Scene& scene);

}  // namespace skywave
