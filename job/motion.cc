#include "job/motion.h"

#include <fmt/format.h>

#include <string>

#include "base/error.h"
#include "job/choose_camera.h"
#include "wavefront/frame.h"

namespace skywave {
namespace {

Moment MomentAt(double frame, JobRequest request, const JobParts& parts, const Geometry& now,
                std::uint64_t& hash) {
  const double of_picture = *request.read.frame;
  request.read.frame = frame;
  JobParts other = parts.AtFrame(request);
  other.Prepare(request);
  const auto built = other.Build(request);
  const Geometry& then = built->geometry;
  if (then.vertex_count() != now.vertex_count() || then.instance_count() != now.instance_count()) {
    throw InputError(InputPosition::File(request.scene),
                     fmt::format("has other vertices or instances at frame {:g} than at frame "
                                 "{:g}, so there is no flow between them",
                                 frame, of_picture));
  }
  const Camera camera = ChooseCamera(other.prepared(), request);
  hash = 31 * hash + other.prepared().content.WithView(camera, {}, glm::mat3(1), {});
  return {{built, &then},
          MakeCameraView(camera, *request.width, *request.height, nullptr, request.crop)};
}

}  // namespace

NeighbourFrames FindMotion(const JobRequest& request, const JobParts& parts,
                           const std::shared_ptr<const BuiltGeometry>& geometry,
                           const CameraView& camera) {
  const auto refuse = [&](const std::string& reason) {
    return OptionError("aovs", ToString(request.options.aovs), reason);
  };
  if (!request.read.frame || parts.loaded().animations.empty()) {
    throw refuse("flow is between frames: it needs `frame` and a scene that has an animation");
  }
  if (!HasPlaneFilm(camera.kind)) {
    throw refuse("flow needs a perspective or an orthographic camera");
  }
  const double frame = *request.read.frame;
  NeighbourFrames found;
  const auto at = [&](double other) {
    return MomentAt(other, request, parts, geometry->geometry, found.hash);
  };
  found.motion.next = at(frame + 1);
  found.motion.previous = at(frame - 1);
  return found;
}

}  // namespace skywave
