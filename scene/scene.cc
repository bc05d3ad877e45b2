#include "scene/scene.h"

#include <algorithm>
#include <glm/gtc/matrix_transform.hpp>
#include <limits>

#include "base/error.h"

namespace skywave {

namespace {

constexpr float kInfinity = std::numeric_limits<float>::infinity();
constexpr Bounds kNoBounds{glm::vec3(kInfinity), glm::vec3(-kInfinity)};

// Only positions used by triangles count, because others are not seen and must not move a camera.
Bounds MeshBounds(const std::vector<Mesh>& meshes) {
  Bounds bounds = kNoBounds;
  for (const Mesh& mesh : meshes) {
    for (const glm::uvec3& t : mesh.triangles) {
      for (int corner = 0; corner < 3; ++corner) {
        bounds.low = glm::min(bounds.low, mesh.positions[t[corner]]);
        bounds.high = glm::max(bounds.high, mesh.positions[t[corner]]);
      }
    }
  }
  return bounds;
}

}  // namespace

bool IsEmpty(const Bounds& bounds) { return bounds.low.x > bounds.high.x; }

glm::vec3 PlaceInScene(const Scene& scene, const glm::dvec3& in_world) {
  return in_world - scene.origin;
}

Bounds BoundsInWorld(const Scene& scene, const Bounds& box) {
  return {scene.origin + glm::dvec3(box.low), scene.origin + glm::dvec3(box.high)};
}

Bounds TransformBounds(const glm::dmat4x3& to, const Bounds& box) {
  Bounds moved = kNoBounds;
  for (int corner = 0; corner < 8; ++corner) {
    const glm::bvec3 high(corner & 1, corner & 2, corner & 4);
    const glm::vec3 p = to * glm::dvec4(glm::mix(box.low, box.high, high), 1);
    moved.low = glm::min(moved.low, p);
    moved.high = glm::max(moved.high, p);
  }
  return moved;
}

std::vector<Bounds> InstanceBounds(const Scene& scene) {
  std::vector<Bounds> of_objects, boxes;
  for (const Object& object : scene.objects) of_objects.push_back(MeshBounds(object.meshes));
  for (const Instance& instance : scene.instances) {
    const Bounds& box = of_objects[instance.object];
    if (!IsEmpty(box)) boxes.push_back(TransformBounds(instance.world_from_object, box));
  }
  return boxes;
}

bool HasCatchers(const Scene& scene) {
  return std::any_of(scene.materials.begin(), scene.materials.end(),
                     [](const Material& material) { return material.catcher; });
}

bool HasHoldouts(const Scene& scene) {
  return std::any_of(scene.materials.begin(), scene.materials.end(),
                     [](const Material& material) { return material.holdout; });
}

Bounds TriangleBounds(const Scene& scene) {
  Bounds bounds = MeshBounds(scene.meshes);
  for (const Bounds& box : InstanceBounds(scene)) {
    bounds.low = glm::min(bounds.low, box.low);
    bounds.high = glm::max(bounds.high, box.high);
  }
  return bounds;
}

Bounds SceneBounds(const Scene& scene, const std::string& path) {
  const Bounds bounds = TriangleBounds(scene);
  if (!IsEmpty(bounds)) return bounds;
  if (scene.environments.empty()) {
    std::string reason = "has no triangle to render";
    for (const auto* remarks : {&scene.warnings, &scene.notes}) {
      for (const std::string& remark : *remarks) reason += "\n  " + remark;
    }
    throw InputError(InputPosition::File(path), reason);
  }
  return {glm::vec3(-1), glm::vec3(1)};
}

Camera LookAtCamera(const glm::vec3& eye, const glm::vec3& target, const glm::vec3& up,
                    float fov_degrees, bool left_handed) {
  const glm::vec3 forward = glm::normalize(target - eye);
  const glm::vec3 cross = glm::normalize(glm::cross(forward, up));
  const glm::vec3 right = left_handed ? -cross : cross;
  const glm::vec3 camera_up = glm::normalize(up - forward * glm::dot(up, forward));
  Camera camera;
  camera.world_from_camera = glm::mat4(glm::vec4(right, 0), glm::vec4(camera_up, 0),
                                       glm::vec4(forward, 0), glm::vec4(eye, 1));
  camera.fov_degrees = fov_degrees;
  return camera;
}

Camera FrameBounds(const Bounds& bounds, char up_axis, bool left_handed, float aspect) {
  constexpr float kFovDegrees = 40, kElevationDegrees = 15, kMargin = 1.05f;
  // The eye is to the right of the front: the view is turned to the left, counter-clockwise.
  constexpr float kTurnDegrees = 35;
  const glm::mat3 frame = EnvironmentTurn(up_axis, left_handed, kTurnDegrees) *
                          EnvironmentFrame(up_axis, left_handed, 0);
  const float elevation = glm::radians(kElevationDegrees);
  const glm::vec3 forward = std::cos(elevation) * frame[1] - std::sin(elevation) * frame[2];
  const glm::vec3 right = frame[0];
  const glm::vec3 up = std::cos(elevation) * frame[2] + std::sin(elevation) * frame[1];

  // This is the nearest eye that has all eight corners inside its pyramid: |x| <= (distance + z)
  // tan. The longer side of the film shows more.
  const glm::vec3 centre = 0.5f * (bounds.low + bounds.high);
  const float slope = std::tan(glm::radians(0.5f * kFovDegrees));
  const float wide = std::max(aspect, 1.0f), tall = std::max(1 / aspect, 1.0f);
  float distance = 0;
  for (int corner = 0; corner < 8; ++corner) {
    const glm::vec3 p = glm::vec3(corner & 1 ? bounds.high.x : bounds.low.x,
                                  corner & 2 ? bounds.high.y : bounds.low.y,
                                  corner & 4 ? bounds.high.z : bounds.low.z) -
                        centre;
    const float side =
        std::max(std::abs(glm::dot(p, right)) / wide, std::abs(glm::dot(p, up)) / tall);
    distance = std::max(distance, side * kMargin / slope - glm::dot(p, forward));
  }
  if (!(distance > 0)) distance = 1;  // a single point
  return LookAtCamera(centre - distance * forward, centre, frame[2], kFovDegrees, left_handed);
}

Camera WithKind(const Camera& camera, CameraKind kind, const Bounds& bounds, char up_axis,
                bool left_handed) {
  Camera other = camera;
  other.kind = kind;
  if (camera.kind != CameraKind::kPerspective) return other;
  if (kind == CameraKind::kFisheye) {
    other.fov_degrees = 180;
    return other;
  }
  const glm::vec3 eye(camera.world_from_camera[3]);
  const glm::vec3 forward = glm::normalize(glm::vec3(camera.world_from_camera[2]));
  if (kind == CameraKind::kOrthographic) {
    const float distance = std::abs(glm::dot(0.5f * (bounds.low + bounds.high) - eye, forward));
    const float scale = std::tan(glm::radians(0.5f * camera.fov_degrees)) * distance;
    if (scale > 0) {
      other.world_from_camera[0] *= scale;
      other.world_from_camera[1] *= scale;
      // The lens radius is measured in camera space, so it is divided by the scale.
      other.lens_radius /= scale;
    }
  } else if (kind != CameraKind::kPerspective) {
    const glm::vec3 up = EnvironmentFrame(up_axis, left_handed, 0)[2];
    const glm::vec3 level = forward - up * glm::dot(forward, up);
    if (glm::length(level) > 1e-4f) {
      other.world_from_camera =
          LookAtCamera(eye, eye + level, up, camera.fov_degrees, left_handed).world_from_camera;
    }
  }
  return other;
}

glm::mat3 EnvironmentFrame(char up_axis, bool left_handed, float rotation_degrees) {
  const glm::vec3 x(1, 0, 0), y(0, 1, 0), z(0, 0, 1);
  glm::mat3 frame = up_axis == 'z'   ? glm::mat3(x, y, z)
                    : up_axis == 'x' ? glm::mat3(-z, y, x)
                                     : glm::mat3(x, -z, y);
  if (left_handed) frame[1] = -frame[1];
  return EnvironmentTurn(up_axis, left_handed, rotation_degrees) * frame;
}

glm::mat3 EnvironmentTurn(char up_axis, bool left_handed, float rotation_degrees) {
  // A positive angle of the rotation formula is counter-clockwise seen from the tip of the axis
  // only in a right-handed world.
  const float angle = glm::radians(left_handed ? -rotation_degrees : rotation_degrees);
  const glm::vec3 up(up_axis == 'x', up_axis == 'y', up_axis == 'z');
  return glm::mat3(glm::rotate(glm::mat4(1), angle, up));
}

}  // namespace skywave
