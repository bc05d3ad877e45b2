#include "job/choose_camera.h"

#include <fmt/format.h>

#include <string_view>
#include <vector>

#include "base/error.h"
#include "base/nearest_name.h"
#include "wavefront/option_names.h"

namespace skywave {

const Camera* SceneCamera(const Scene& scene, const std::string& name) {
  if (name.empty()) return scene.camera ? &*scene.camera : nullptr;
  std::vector<std::string_view> names;
  for (const NamedCamera& named : scene.cameras) {
    if (named.name == name) return &named.camera;
    names.push_back(named.name);
  }
  throw OptionError("scene-camera", name,
                    names.empty()
                        ? "the scene has no camera with a name"
                        : "there is no such camera; there are " + NearestFirst(name, names));
}

namespace {

// Returns the camera turned about the up axis through `middle`.
Camera Orbited(Camera camera, const glm::vec3& middle, float degrees, const Scene& scene) {
  if (degrees == 0) return camera;
  const glm::mat3 turn = EnvironmentTurn(scene.up_axis, scene.left_handed, degrees);
  glm::mat4& world = camera.world_from_camera;
  for (int axis = 0; axis < 3; ++axis) world[axis] = glm::vec4(turn * glm::vec3(world[axis]), 0);
  world[3] = glm::vec4(middle + turn * (glm::vec3(world[3]) - middle), 1);
  return camera;
}

}  // namespace

Camera ChooseCamera(const Scene& scene, const Bounds& bounds, const CameraRequest& request,
                    float aspect) {
  const Camera* const of_scene = request.placed && (request.name.empty() || !request.from.empty())
                                     ? &*request.placed
                                     : SceneCamera(scene, request.name);
  Camera camera =
      of_scene ? *of_scene : FrameBounds(bounds, scene.up_axis, scene.left_handed, aspect);
  const glm::vec3 middle = 0.5f * (bounds.low + bounds.high);
  if (request.fov_degrees) camera.fov_degrees = *request.fov_degrees;
  if (request.eye || request.target) {
    const glm::vec3 eye = request.eye.value_or(glm::vec3(camera.world_from_camera[3]));
    const glm::vec3 target = request.target.value_or(middle);
    const glm::vec3 up = EnvironmentFrame(scene.up_axis, scene.left_handed, 0)[2];
    const glm::vec3 view = target - eye;
    if (!(glm::length(glm::cross(view, up)) > 1e-5f * glm::length(view))) {
      throw OptionError({{"eye", ""}, {"target", ""}},
                        "the camera has to look somewhere, and not straight up or down");
    }
    camera.world_from_camera =
        LookAtCamera(eye, target, up, camera.fov_degrees, scene.left_handed).world_from_camera;
  }
  if (request.kind) {
    camera = WithKind(camera, *request.kind, bounds, scene.up_axis, scene.left_handed);
    if (request.fov_degrees) camera.fov_degrees = *request.fov_degrees;
  }
  constexpr float kWidestPlane = 179;
  if (request.fov_degrees > kWidestPlane && camera.kind != CameraKind::kFisheye) {
    throw OptionError("fov", fmt::format("{}", *request.fov_degrees),
                      fmt::format("a {} camera sees at most {} degrees; `camera fisheye` sees more",
                                  ToString(camera.kind), kWidestPlane));
  }
  const glm::mat3 axes(camera.world_from_camera);
  const float depth = glm::length(axes[2]);
  if (request.lens_radius) {
    camera.lens_radius = *request.lens_radius / glm::length(axes[0]);
    const glm::vec3 eye(camera.world_from_camera[3]);
    const float distance = glm::dot(middle - eye, axes[2]) / (depth * depth);
    if (distance > 0) camera.focal_distance = distance;
  }
  if (request.focal_distance) camera.focal_distance = *request.focal_distance / depth;
  return Orbited(camera, request.target.value_or(middle), request.orbit_degrees.value_or(0), scene);
}

}  // namespace skywave
