// The light from infinitely far away that a request and its scene give.
#pragma once

#include <string>
#include <vector>

#include "job/request.h"
#include "scene/scene.h"

namespace skywave {

// The map of the request, or else the sum of the scene's infinite lights: a lat-long map in memory
// that is in the world's units; black where local lights are all that the scene has. Appends to
// `notes` how files were understood and repaired. Throws InputError where there is no light at all
// or a file cannot be used.
EnvironmentLight LoadEnvironment(const Scene& scene, const JobRequest& request,
                                 std::vector<std::string>& notes);

}  // namespace skywave
