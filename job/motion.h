// The frames of an animation beside that of a picture.
#pragma once

#include <cstdint>
#include <memory>

#include "job/job_parts.h"
#include "job/request.h"
#include "kernels/camera.h"
#include "wavefront/film/flow.h"

namespace skywave {

struct NeighbourFrames {
  FrameMotion motion;
  std::uint64_t hash = 0;  // of their meshes and cameras
};

// Returns the scene at the frames before and after that of a resolved request, whose `parts`,
// `geometry` and `camera` are given. Throws InputError where there are none, and where vertices or
// instances come or go.
NeighbourFrames FindMotion(const JobRequest& request, const JobParts& parts,
                           const std::shared_ptr<const BuiltGeometry>& geometry,
                           const CameraView& camera);

}  // namespace skywave
