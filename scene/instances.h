// Instances: which objects of a scene are copied, and which stand in it once for many places.
#pragma once

#include <cstddef>
#include <string>

#include "scene/read_options.h"
#include "scene/scene.h"

namespace skywave {

// Copies every instance that is not to be shared into Scene::meshes, where the file has it, and
// leaves the others in Scene::instances. An object is shared if its copies would take more memory
// than they are worth (kAuto), or however few it has (kShare). Copied in any case are
// - meshes that shine, because the tables of lights are in world space,
// - instances whose matrix has no inverse,
// - and mirroring instances of objects with normal maps, because whether y of a map is reversed
//   depends on its kind.
// Objects without an instance disappear. Throws InputError(path) for more triangles than
// `options.max_triangles`, those of a shared object counted once, and for more instances than
// `options.max_instances`.
void ResolveInstances(const ReadOptions& options, const std::string& path, Scene& scene);

}  // namespace skywave
