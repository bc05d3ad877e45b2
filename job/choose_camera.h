// The camera that a request and its scene give.
#pragma once

#include <string>

#include "job/job_parts.h"
#include "job/request.h"
#include "scene/scene.h"

namespace skywave {

// Returns the camera of that name, or the first one if the name is empty; null if the scene has
// none. Throws OptionError, listing the cameras, if it has none of the name.
const Camera* SceneCamera(const Scene& scene, const std::string& name);

// The camera of the scene, or else one that sees all of `bounds`, with the changes of the request.
// `aspect`: width / height of the whole film. Throws InputError for a view without a direction, for
// a field of view that the camera cannot have, and for a name that no camera of the scene has.
Camera ChooseCamera(const Scene& scene, const Bounds& bounds, const CameraRequest& request,
                    float aspect);
// The same of a scene that is prepared for a resolved request.
Camera ChooseCamera(const PreparedScene& prepared, const JobRequest& request);

}  // namespace skywave
