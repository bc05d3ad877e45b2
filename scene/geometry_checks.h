// Checks of a scene before it becomes tables: readers must have refused what these find, and this
// is the last gate, because neither Embree nor the kernels look at their input.
#pragma once

#include <cstddef>
#include <string>

#include "scene/scene.h"

namespace skywave {

inline constexpr std::size_t kMaxRecords = std::size_t{1} << 29;  // kernels use 31 bits of an index

// Checks every index and coordinate of the meshes, and that a table can hold them. Throws
// InputError(path), which names the mesh.
void CheckMeshes(const Scene& scene, const std::string& path);

// Checks that what materials name exists. Throws InputError(path), which names the material.
void CheckMaterials(const Scene& scene, const std::string& path);

}  // namespace skywave
