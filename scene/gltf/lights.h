// Reads glTF's KHR_lights_punctual. Photometric units stay as they are: radiance 1 is one candela
// per square metre (nit), so candela become a point light's intensity and lux a distant light's
// irradiance. Node scales do not change a light, and ranges (an aid for renderers that cut lights
// off) are ignored.
#pragma once

#include <tiny_gltf.h>

#include <glm/glm.hpp>
#include <string>

#include "scene/scene.h"
#include "scene/warnings.h"

namespace skywave {

// Appends the light of a node, if it has one, to scene.lights. Throws InputError(path) for lights
// that do not exist or have no usable numbers.
void AddGltfLight(const tinygltf::Model& model, const tinygltf::Node& node, const glm::dmat4& world,
                  const std::string& path, Scene& scene, Warnings& warnings);

}  // namespace skywave
