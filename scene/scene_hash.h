// The hash by which pictures tell the scenes that they show apart.
#pragma once

#include <cstdint>

#include "scene/scene.h"

namespace skywave {

// Returns a hash of everything that decides what a scene looks like: meshes, materials, camera and
// lights. Two scenes with the same hash give the same picture for the same settings.
std::uint64_t SceneHash(const Scene& scene);

// Returns a hash of the radiance of an illumination map.
std::uint64_t MapHash(const Image& map);

}  // namespace skywave
