// The built-in scenes are assembled with these helpers: materials by name, meshes by position.
#pragma once

#include <cstdint>
#include <glm/glm.hpp>
#include <string>
#include <vector>

#include "scene/scene.h"

namespace skywave {

// Each function adds a material and returns its index.
std::uint32_t AddLambert(Scene& scene, const std::string& name, const glm::vec3& reflectance);
// `symbol` names one of the metals in metals.h; `alpha` is the GGX width.
std::uint32_t AddMetal(Scene& scene, const std::string& symbol, float alpha);
std::uint32_t AddMirror(Scene& scene, float reflectance);
std::uint32_t AddGlass(Scene& scene, float ior);

// Adds `mesh`, turned about y (counter-clockwise seen from above) and then moved.
void Place(Scene& scene, Mesh mesh, std::uint32_t material, const glm::vec3& position,
           float turn_degrees = 0);

// Adds the sky of procedural_sky.h, upright, with its middle towards -z.
void AddProceduralSky(Scene& scene);

// Returns settings for path tracing at 640 x 480.
RenderSettings BuiltinSettings(int samples_per_pixel, int max_depth);

// Returns one material for each BSDF that parameters alone describe.
std::vector<Material> OneOfEachBsdf();

// These scenes of builtin.h have files of their own.
Scene GalleryScene();
Scene MaterialsScene();
Scene MeadowScene();
Scene PlantScene();
Scene RoomScene();

}  // namespace skywave
