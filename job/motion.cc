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

// Returns the scene, of which `now` is built, some frames further.
Moment MomentAfter(double frames, JobRequest request, const JobParts& parts,
                   const std::shared_ptr<const BuiltGeometry>& now, std::uint64_t& hash) {
  request.camera.orbit_degrees =
      request.camera.orbit_degrees.value_or(0) + float(frames) * request.camera.orbit_step;
  JobParts other = parts;
  std::shared_ptr<const BuiltGeometry> then = now;
  if (MovesScene(request, parts)) {
    *request.read.frame += frames;
    other = parts.AtFrame(request);
    other.Prepare(request);
    then = other.Build(request);
  }
  const Geometry &here = now->geometry, &there = then->geometry;
  if (there.vertex_count() != here.vertex_count() ||
      there.instance_count() != here.instance_count()) {
    throw InputError(InputPosition::File(request.scene),
                     fmt::format("has other vertices or instances at frame {:g} than at frame "
                                 "{:g}, so there is no flow between them",
                                 *request.read.frame, *request.read.frame - frames));
  }
  const Camera camera = ChooseCamera(other.prepared(), request);
  hash = 31 * hash + other.prepared().content.WithView(camera, {}, glm::mat3(1), {});
  return {{then, &there},
          MakeCameraView(camera, *request.width, *request.height, nullptr, request.crop)};
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
