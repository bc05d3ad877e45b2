// The hash by which pictures identify their scenes.
#pragma once

#include <cstdint>
#include <memory>
#include <span>

#include "scene/scene.h"

namespace skywave {

// The contribution of a scene's meshes, materials and textures to its hash: most of the work, and
// the same for all cameras and lights.
class SceneHashContent {
 public:
  SceneHashContent() = default;
  explicit SceneHashContent(const Scene& scene);
  // Returns the hash of a scene with this content, of which `light` is the only light from
  // infinitely far away; it lies in the world as `world_from_map` says.
  std::uint64_t WithView(const Camera& camera, const EnvironmentLight& light,
                         const glm::mat3& world_from_map,
                         std::span<const PunctualLight> lights) const;

 private:
  friend std::uint64_t SceneHash(const Scene& scene);
  std::shared_ptr<const void> state_;  // of the hash, after the content
};

// Returns a hash of everything that decides what a scene looks like: meshes, materials, camera and
// lights. Two scenes with the same hash give the same picture for the same settings.
std::uint64_t SceneHash(const Scene& scene);

// Returns a hash of the radiance of an illumination map.
std::uint64_t MapHash(const Image& map);

}  // namespace skywave
