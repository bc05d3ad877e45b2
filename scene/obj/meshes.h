// Turns tinyobjloader's corners, each with three indices, into meshes of vertices.
#pragma once

#include <tiny_obj_loader.h>

#include <string>
#include <vector>

#include "scene/obj/check.h"
#include "scene/read_options.h"
#include "scene/scene.h"
#include "scene/warnings.h"

namespace skywave {

// Appends the triangles of `shapes` to the scene, sorted by material and by whether they are
// smooth. tinyobjloader's material i is the scene's material i, and triangles without one get
// material 0. `has_smoothing` says whether the smoothing groups of the shapes are meaningful.
void BuildObjMeshes(const tinyobj::attrib_t& attributes,
                    const std::vector<tinyobj::shape_t>& shapes, bool has_smoothing,
                    const std::string& path, Scene& scene);

// Appends the points and lines of a file, or all its vertices if it has no faces either, where
// `options` have a size for them; else adds a warning.
void BuildObjPoints(const tinyobj::attrib_t& attributes, const ObjStatements& statements,
                    const ReadOptions& options, const std::string& path, Scene& scene,
                    Warnings& warnings);

}  // namespace skywave
