#include "job/motion.h"

#include <fmt/format.h>

#include <string>

#include "base/error.h"
#include "job/choose_camera.h"
#include "wavefront/frame.h"

namespace skywave {
namespace {

// Whether a frame is one of an animation; else the scene stands still.
bool MovesScene(const JobRequest& request, const JobParts& parts) {
  return request.read.frame && !parts.loaded().animations.empty();
}

// Returns the view of a camera that a request has chosen for a scene.
CameraView ViewOf(const Camera& camera, const JobRequest& request) {
  return MakeCameraView(camera, *request.width, *request.height, nullptr, request.crop);
}

// Returns the scene, of which `now` is built, some frames further.
Moment MomentAfter(double frames, JobRequest request, const JobParts& parts,
                   const std::shared_ptr<const BuiltGeometry>& now, std::uint64_t& hash) {
  request.camera.orbit_degrees =
      request.camera.orbit_degrees.value_or(0) + float(frames) * request.camera.orbit_step;
  if (!MovesScene(request, parts)) {
    const Camera camera = ChooseCamera(parts.prepared(), request);
    hash = 31 * hash + parts.prepared().content.WithView(camera, {}, glm::mat3(1), {});
    return {{now, &now->geometry}, ViewOf(camera, request)};
  }
  const double of_picture = *request.read.frame;
  request.read.frame = of_picture + frames;
  JobParts other = parts.AtFrame(request);
  other.Prepare(request);
  const auto built = other.Build(request);
  const Geometry& then = built->geometry;
  if (then.vertex_count() != now->geometry.vertex_count() ||
      then.instance_count() != now->geometry.instance_count()) {
    throw InputError(InputPosition::File(request.scene),
                     fmt::format("has other vertices or instances at frame {:g} than at frame "
                                 "{:g}, so there is no flow between them",
                                 *request.read.frame, of_picture));
  }
  const Camera camera = ChooseCamera(other.prepared(), request);
  hash = 31 * hash + other.prepared().content.WithView(camera, {}, glm::mat3(1), {});
  return {{built, &then}, ViewOf(camera, request)};
}

}  // namespace

NeighbourFrames FindMotion(const JobRequest& request, const JobParts& parts,
                           const std::shared_ptr<const BuiltGeometry>& geometry,
                           const CameraView& camera) {
  const auto refuse = [&](const std::string& reason) {
    return OptionError("aovs", ToString(request.options.aovs), reason);
  };
  if (!MovesScene(request, parts) && request.camera.orbit_step == 0) {
    throw refuse(
        "flow is between frames: it needs `frame` and a scene that has an animation, or "
        "`orbit-step`");
  }
  if (!HasPlaneFilm(camera.kind)) {
    throw refuse("flow needs a perspective or an orthographic camera");
  }
  NeighbourFrames found;
  found.motion.next = MomentAfter(1, request, parts, geometry, found.hash);
  found.motion.previous = MomentAfter(-1, request, parts, geometry, found.hash);
  return found;
}

}  // namespace skywave
