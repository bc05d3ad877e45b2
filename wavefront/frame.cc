#include "wavefront/frame.h"

#include <algorithm>
#include <cmath>
#include <glm/glm.hpp>
#include <glm/gtc/constants.hpp>

#include "scene/lens_system.h"

namespace skywave {
namespace {

void Copy(const glm::vec3& from, float* to) {
  for (int i = 0; i < 3; ++i) to[i] = from[i];
}

}  // namespace

SampleRange SamplesOf(const RenderOptions& options) {
  return {options.first_sample, options.first_sample + options.samples_per_pixel};
}

SampleRange PictureSamples(const RenderOptions& options) {
  return options.picture_samples.count() > 0 ? options.picture_samples : SamplesOf(options);
}

FrameView FrameView::of_continuations() const {
  FrameView frame = *this;
  frame.options.bsdf_samples = 0;
  if (continuation_strategy != nullptr) frame.strategy = continuation_strategy;
  return frame;
}

FrameView FrameView::of_place() const {
  FrameView frame = *this;
  frame.tracer.only = catchers;
  frame.light_groups = nullptr;
  return frame;
}

LightShares FrameView::light_shares() const {
  LightShares shares;
  shares.plan = has_environment() ? strategy->Plan(light_samples()) : LightPlan{.drawn = 0};
  if (local_lights.count == 0) return shares;
  const LightSelection selection = options.light_selection;
  if (selection == LightSelection::kAll) {
    shares.each = local_lights.count;
    return shares;
  }
  const bool alike = selection == LightSelection::kOne;
  if (shares.plan.drawn > 0) {
    shares.local = alike ? local_lights.alike_shared : local_lights.shared;
    shares.of_strategy = 1 - shares.local.share;
  } else {
    shares.local = alike ? local_lights.alike_alone : local_lights.alone;
    shares.plan.drawn = light_samples();
  }
  if (selection == LightSelection::kTree) shares.local.tree = local_lights.tree;
  return shares;
}

namespace {

float LengthOf(const float (&v)[3]) { return std::sqrt(v[0] * v[0] + v[1] * v[1] + v[2] * v[2]); }

}  // namespace

float PixelAngle(const CameraView& camera) {
  constexpr float kTurn = 6.28318531f;
  const bool has_turns =
      camera.kind == CameraKind::kFisheye || camera.kind == CameraKind::kRealistic;
  if (has_turns) return kTurn * camera.turns_per_pixel;
  if (camera.kind != CameraKind::kPerspective) return 0;
  return LengthOf(camera.right) / LengthOf(camera.forward);
}

float PixelSize(const CameraView& camera, float distance) {
  constexpr float kTurn = 6.28318531f;
  const float width = float(camera.whole_width), height = float(camera.whole_height);
  switch (camera.kind) {
    case CameraKind::kPerspective:
    case CameraKind::kFisheye:
    case CameraKind::kRealistic:
      return distance * PixelAngle(camera);
    case CameraKind::kOrthographic:
      return LengthOf(camera.right);
    case CameraKind::kLatLong:
      return distance * kTurn / width;
    case CameraKind::kEqualArea:
      return distance * std::sqrt(2 * kTurn / (width * height));
  }
  return 0;
}

namespace {

// Returns how far along `axis` the plane of a film at `from` can move without passing a surface.
double DistanceTo(const SceneSphere& sphere, const glm::dvec3& from, const glm::dvec3& axis) {
  const glm::dvec3 center(sphere.center[0], sphere.center[1], sphere.center[2]);
  const glm::dvec3 forward = glm::normalize(axis);
  return std::max(glm::dot(center - from, forward) - double(sphere.radius), 0.0);
}

}  // namespace

CameraView MakeCameraView(const Camera& camera, int width, int height, const float* filter_offset,
                          const std::optional<CropWindow>& crop, const SceneSphere* around) {
  const glm::dmat4 world(camera.world_from_camera);
  const glm::dvec3 x(world[0]), y(world[1]), z(world[2]);
  const CropWindow part = WholeBlocks(crop.value_or(CropWindow{0, 0, width, height}));
  CameraView view = {};
  view.kind = camera.kind;
  view.width = std::uint32_t(part.width), view.height = std::uint32_t(part.height);
  view.first_column = std::uint32_t(part.x), view.first_row = std::uint32_t(part.y);
  view.whole_width = std::uint32_t(width), view.whole_height = std::uint32_t(height);
  view.filter_offset = filter_offset;
  Copy(glm::vec3(world[3]), view.origin);
  if (camera.kind == CameraKind::kRealistic) {
    const double side = camera.realistic->design.film_diagonal / std::hypot(width, height);
    view.realistic = &camera.realistic->view;
    view.pixel_side = float(side);
    const double f = camera.realistic->focal_length;
    if (f > 0) view.turns_per_pixel = float(side / f / glm::two_pi<double>());
    Copy(glm::vec3(x), view.right), Copy(glm::vec3(-y), view.down),
        Copy(glm::vec3(z), view.forward);
    return view;
  }
  if (!HasPlaneFilm(camera.kind)) {
    const double rim = double(camera.fov_degrees) / 720;
    view.turns_per_pixel = float(2 * rim / std::min(width, height));
    view.rim_turns = float(rim);
    Copy(glm::vec3(glm::normalize(x)), view.right);
    Copy(glm::vec3(-glm::normalize(y)), view.down);
    Copy(glm::vec3(glm::normalize(z)), view.forward);
    return view;
  }

  const double shorter = std::min(width, height);
  const bool perspective = camera.kind == CameraKind::kPerspective;
  const double unit = perspective ? std::tan(glm::radians(double(camera.fov_degrees)) / 2) : 1;
  // These are the sides of a pixel and the top left corner of the film, on the plane of the screen
  // window.
  double pixel_x = 2 * unit / shorter, pixel_y = pixel_x;
  double left = -pixel_x * width / 2, top = pixel_y * height / 2;
  if (camera.window) {
    const ScreenWindow& w = *camera.window;
    pixel_x = unit * (double(w.right) - w.left) / width;
    pixel_y = unit * (double(w.top) - w.bottom) / height;
    left = unit * w.left, top = unit * w.top;
    const bool other_film =
        std::int64_t{width} * camera.film_height != std::int64_t{height} * camera.film_width;
    if (camera.square_pixels || (camera.film_width > 0 && other_film)) {
      pixel_x = pixel_y = std::max(pixel_x, pixel_y);
      left = 0.5 * (unit * (double(w.left) + w.right) - pixel_x * width);
      top = 0.5 * (unit * (double(w.top) + w.bottom) + pixel_y * height);
    }
  }
  glm::dvec3 middle = z;
  if (!perspective) {
    middle = glm::dvec3(world[3]);
    if (around != nullptr && camera.lens_radius == 0) {
      middle += glm::normalize(z) * DistanceTo(*around, middle, z);
    }
  }
  Copy(glm::vec3(middle + x * left + y * top), view.corner);
  Copy(glm::vec3(x * pixel_x), view.right);
  Copy(glm::vec3(-y * pixel_y), view.down);
  Copy(glm::vec3(z), view.forward);
  Copy(glm::vec3(x * double(camera.lens_radius)), view.lens_x);
  Copy(glm::vec3(y * double(camera.lens_radius)), view.lens_y);
  view.lens_radius = camera.lens_radius;
  view.focal_distance = camera.focal_distance;
  return view;
}

}  // namespace skywave
