// The light from beyond the scene: one map, whatever the user or the file asks for.
#pragma once

#include <string>
#include <vector>

#include "job/job.h"

namespace skywave {

// The map of the request, or else the scene's infinite lights, loaded, repaired and scaled; black
// where only local lights are. Several lights are summed on the grid of the finest: constants
// exactly, other maps interpolated there, their light kept. `notes` gets a line for whatever was
// assumed or repaired. Throws InputError for maps that cannot be read and scenes without any light.
EnvironmentLight LoadEnvironment(const Scene& scene, const JobRequest& request,
                                 std::vector<std::string>& notes);

}  // namespace skywave
