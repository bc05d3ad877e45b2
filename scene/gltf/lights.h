// glTF's KHR_lights_punctual. Photometric units stay as they are: radiance 1 is a candela a square
// metre (nit), so a point's candela are its intensity and a sun's lux its irradiance. Scales of
// nodes change no light, ranges (an aid for renderers that cut lights off) count nothing.
#pragma once

#include <tiny_gltf.h>

#include <glm/glm.hpp>
#include <string>

#include "scene/scene.h"
#include "scene/warnings.h"

namespace skywave {

// Appends the light of a node, if it has one, to scene.lights. Throws InputError(path) for lights
// that are not there or have no usable numbers.
void AddGltfLight(const tinygltf::Model& model, const tinygltf::Node& node, const glm::dmat4& world,
                  const std::string& path, Scene& scene, Warnings& warnings);

}  // namespace skywave
