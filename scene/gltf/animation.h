// Poses the nodes of a glTF file at a moment of its animations.
//
// Channels move translations, rotations, scales and weights by samplers LINEAR (rotations:
// spherical), STEP and CUBICSPLINE (glTF 2.0, 3.11 and appendix C). Before the first key and after
// the last one a property has the value of that key. Weights of morph targets are animated
// likewise, each by itself.
#pragma once

#include <tiny_gltf.h>

#include <glm/gtc/quaternion.hpp>
#include <optional>
#include <string>
#include <vector>

#include "scene/read_options.h"
#include "scene/scene.h"
#include "scene/warnings.h"

namespace skywave {

// The properties of a node that are animated; the others are those of the file.
struct GltfPose {
  std::optional<glm::dvec3> translation, scale;
  std::optional<glm::dquat> rotation;          // unit
  std::optional<std::vector<double>> weights;  // of the morph targets of its mesh
};

// Returns a pose for each node, all of them empty where `options` ask for no frame. If several
// animations move a property, the first one of the file counts, with a warning. Throws
// InputError(path) for an animation that is asked for and wrong: keys that go back in time, numbers
// that are not finite, rotations of length zero, too few values, nodes that do not exist.
std::vector<GltfPose> PoseGltfNodes(const tinygltf::Model& model, const ReadOptions& options,
                                    const std::string& path, Warnings& warnings);

// Returns what there is to choose from. Animations without a name of their own are called #0, #1
// and so on by their place in the file. An animation whose keys cannot be read becomes a note.
std::vector<AnimationInfo> ListGltfAnimations(const tinygltf::Model& model, const std::string& path,
                                              Warnings& warnings);

}  // namespace skywave
