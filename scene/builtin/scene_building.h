// How the built-in scenes are put together: materials by name, meshes by place.
#pragma once

#include <cstdint>
#include <glm/glm.hpp>
#include <string>
#include <vector>

#include "scene/scene.h"

namespace skywave {

// Each adds a material and returns its index.
std::uint32_t AddLambert(Scene& scene, const std::string& name, const glm::vec3& reflectance);
// `symbol` is one of metals.h; `alpha` the GGX width.
std::uint32_t AddMetal(Scene& scene, const std::string& symbol, float alpha);
std::uint32_t AddMirror(Scene& scene, float reflectance);
std::uint32_t AddGlass(Scene& scene, float ior);

// Adds `mesh` turned about y (counter-clockwise seen from above) and then moved.
void Place(Scene& scene, Mesh mesh, std::uint32_t material, const glm::vec3& position,
           float turn_degrees = 0);

// The sky of procedural_sky.h, upright, its middle towards -z.
void AddProceduralSky(Scene& scene);

// 640 x 480, path tracing.
RenderSettings BuiltinSettings(int samples_per_pixel, int max_depth);

// A material of each BSDF that is described by parameters alone.
std::vector<Material> OneOfEachBsdf();

// The scenes of builtin.h that have a file of their own.
Scene GalleryScene();
Scene MaterialsScene();
Scene RoomScene();

}  // namespace skywave
