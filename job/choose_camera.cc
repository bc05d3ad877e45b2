#include "job/choose_camera.h"

#include <fmt/format.h>

#include <cmath>
#include <optional>
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

// Returns what is up in the picture of a camera that looks along `view`.
glm::vec3 UpOf(const Scene& scene, const CameraRequest& request, const glm::vec3& view) {
  const glm::mat3 axes = EnvironmentFrame(scene.up_axis, scene.left_handed, 0);
  const auto is_across = [&](const glm::vec3& up) {
    return glm::length(glm::cross(view, up)) > 1e-5f * glm::length(view) * glm::length(up);
  };
  if (!(glm::length(view) > 0)) {
    throw OptionError({{"eye", ""}, {"target", ""}}, "the camera has to look somewhere");
  }
  if (!request.up) return is_across(axes[2]) ? axes[2] : axes[1];
  if (is_across(*request.up)) return *request.up;
  throw OptionError({{"up", ""}}, "is the direction in which the camera looks, or no direction");
}

// Throws OptionError where the lens of the scene's camera is asked for and is none, or is to be
// another one.
void CheckRealistic(const Camera& camera, const CameraRequest& request) {
  const bool has_one = camera.kind == CameraKind::kRealistic;
  const bool wants_one = request.kind.value_or(camera.kind) == CameraKind::kRealistic;
  if (wants_one && !has_one) {
    throw OptionError("camera", "realistic",
                      "is the camera of a scene with a lens file, as pbrt's are, and this is none");
  }
  if (!has_one || !wants_one) return;
  for (const auto& [name, given] : {std::pair("fov", request.fov_degrees.has_value()),
                                    {"lens-radius", request.lens_radius.has_value()},
                                    {"focal-distance", request.focal_distance.has_value()}}) {
    if (!given) continue;
    throw OptionError(name, "",
                      "is a matter of the lens file of this scene's camera; `camera perspective` "
                      "is one without it");
  }
}

// Returns the camera turned about its view, clockwise as it looks.
glm::mat4 Rolled(const glm::mat4& camera, float degrees) {
  if (degrees == 0) return camera;
  const float angle = glm::radians(degrees), c = std::cos(angle), s = std::sin(angle);
  return {c * camera[0] - s * camera[1], s * camera[0] + c * camera[1], camera[2], camera[3]};
}

}  // namespace

Camera ChooseCamera(const Scene& scene, const Bounds& bounds, const CameraRequest& request,
                    float aspect) {
  const Camera* const of_scene = request.placed && (request.name.empty() || !request.from.empty())
                                     ? &*request.placed
                                     : SceneCamera(scene, request.name);
  Camera camera =
      of_scene ? *of_scene : FrameBounds(bounds, scene.up_axis, scene.left_handed, aspect);
  if (of_scene && request.placed && of_scene == &*request.placed) {
    camera.world_from_camera[3] = glm::vec4(PlaceInScene(scene, request.placed_at), 1);
  }
  const glm::vec3 middle = 0.5f * (bounds.low + bounds.high);
  const auto in_scene = [&](const std::optional<glm::dvec3>& place) {
    return place ? std::optional(PlaceInScene(scene, *place)) : std::nullopt;
  };
  const std::optional<glm::vec3> wanted_eye = in_scene(request.eye),
                                 wanted_target = in_scene(request.target);
  if (request.fov_degrees) {
    camera.fov_degrees = *request.fov_degrees;
    // The angle is across the shorter side of the film, and not of the view that a file describes.
    if (camera.kind == CameraKind::kPerspective && camera.square_pixels) camera.window.reset();
  }
  if (request.eye || request.target || request.up) {
    const glm::vec3 eye = wanted_eye.value_or(glm::vec3(camera.world_from_camera[3]));
    const glm::vec3 ahead = eye + glm::vec3(camera.world_from_camera[2]);
    const glm::vec3 target = wanted_target.value_or(wanted_eye ? middle : ahead);
    camera.world_from_camera = LookAtCamera(eye, target, UpOf(scene, request, target - eye),
                                            camera.fov_degrees, scene.left_handed)
                                   .world_from_camera;
  }
  CheckRealistic(camera, request);
  if (request.kind && request.kind != camera.kind) {
    if (camera.kind == CameraKind::kRealistic) camera.kind = CameraKind::kPerspective;
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
  camera.world_from_camera = Rolled(camera.world_from_camera, request.roll_degrees.value_or(0));
  return Orbited(camera, wanted_target.value_or(middle), request.orbit_degrees.value_or(0), scene);
}

Camera ChooseCamera(const PreparedScene& prepared, const JobRequest& request) {
  return ChooseCamera(*prepared.scene, prepared.placing_bounds, request.camera,
                      float(*request.width) / float(*request.height));
}

}  // namespace skywave
