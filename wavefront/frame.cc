#include "wavefront/frame.h"

#include <algorithm>
#include <cmath>
#include <glm/gtc/constants.hpp>

namespace skywave {
namespace {

// Returns the cubic of Mitchell and Netravali 1988 with B = C = 1/3, of radius 2.
double Mitchell(double x) {
  const double t = std::fabs(x);
  if (t > 2) return 0;
  return t < 1 ? ((7 * t - 12) * t * t + 16.0 / 3) / 6
               : (((-7.0 / 3 * t + 12) * t - 20) * t + 32.0 / 3) / 6;
}

double Sinc(double x) {
  const double t = glm::pi<double>() * x;
  return std::fabs(t) < 1e-6 ? 1 : std::sin(t) / t;
}

// Returns the weight at `x` radii, |x| <= 1, of a filter of a radius [pixels], not normalised.
double FilterWeight(PixelFilter filter, double radius, double x) {
  switch (filter) {
    case PixelFilter::kBox:
      return 1;
    case PixelFilter::kTriangle:
      return 1 - std::fabs(x);
    case PixelFilter::kGaussian: {
      // The standard deviation is a third of the radius; the curve is lowered to reach 0 at the
      // rim.
      const auto gauss = [](double t) { return std::exp(-0.5 * 9 * t * t); };
      return gauss(x) - gauss(1);
    }
    case PixelFilter::kBlackmanHarris: {
      // This is the four-term window (Harris 1978).
      const double t = glm::pi<double>() * (x + 1);
      return 0.35875 - 0.48829 * std::cos(t) + 0.14128 * std::cos(2 * t) -
             0.01168 * std::cos(3 * t);
    }
    case PixelFilter::kMitchell:
      return Mitchell(2 * x);
    case PixelFilter::kSinc:
      // The window is pbrt's, of tau 3.
      return Sinc(x * radius) * Sinc(x * radius / 3);
  }
  return 0;
}

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
  frame.options.split = 0;
  if (continuation_strategy != nullptr) frame.strategy = continuation_strategy;
  return frame;
}

LightShares FrameView::light_shares() const {
  LightShares shares;
  shares.plan = has_environment() ? strategy->Plan(light_samples()) : LightPlan{.drawn = 0};
  if (local_lights.count == 0) return shares;
  if (shares.plan.drawn > 0) {
    shares.local = local_lights.shared;
    shares.of_strategy = 1 - shares.local.share;
  } else {
    shares.local = local_lights.alone;
    shares.plan.drawn = light_samples();
  }
  return shares;
}

namespace {

float LengthOf(const float (&v)[3]) { return std::sqrt(v[0] * v[0] + v[1] * v[1] + v[2] * v[2]); }

}  // namespace

float PixelAngle(const CameraView& camera) {
  constexpr float kTurn = 6.28318531f;
  if (camera.kind == CameraKind::kFisheye) return kTurn * camera.turns_per_pixel;
  if (camera.kind != CameraKind::kPerspective) return 0;
  return LengthOf(camera.right) / LengthOf(camera.forward);
}

float PixelSize(const CameraView& camera, float distance) {
  constexpr float kTurn = 6.28318531f;
  const float width = float(camera.whole_width), height = float(camera.whole_height);
  switch (camera.kind) {
    case CameraKind::kPerspective:
    case CameraKind::kFisheye:
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

float DefaultFilterRadius(PixelFilter filter) {
  switch (filter) {
    case PixelFilter::kBox:
      return 0.5f;
    case PixelFilter::kTriangle:
      return 1.0f;
    case PixelFilter::kGaussian:
      return 1.5f;
    case PixelFilter::kBlackmanHarris:
      return 1.5f;
    case PixelFilter::kMitchell:
      return 2.0f;
    case PixelFilter::kSinc:
      return 4.0f;
  }
  return 0.5f;
}

std::vector<float> FilterOffsets(PixelFilter filter, float radius) {
  constexpr int kSteps = 1 << 14;
  std::vector<double> cumulative(kSteps + 1, 0.0);
  for (int i = 0; i < kSteps; ++i) {
    cumulative[i + 1] =
        cumulative[i] + std::fabs(FilterWeight(filter, radius, 2 * (i + 0.5) / kSteps - 1));
  }
  std::vector<float> offsets(kFilterCells + 1);
  int step = 0;
  for (std::uint32_t cell = 0; cell <= kFilterCells; ++cell) {
    const double target = cumulative[kSteps] * cell / kFilterCells;
    while (step < kSteps - 1 && cumulative[step + 1] < target) ++step;
    const double width = cumulative[step + 1] - cumulative[step];
    const double inside = width > 0 ? (target - cumulative[step]) / width : 0;
    offsets[cell] = float(radius * (2 * (step + inside) / kSteps - 1));
  }
  return offsets;
}

std::vector<float> FilterFactors(PixelFilter filter, float radius,
                                 const std::vector<float>& offsets) {
  if (!HasSigns(filter)) return {};
  constexpr int kSteps = 64;
  std::vector<double> integrals(kFilterCells);
  double whole = 0;
  for (std::uint32_t cell = 0; cell < kFilterCells; ++cell) {
    const double width = (double(offsets[cell + 1]) - offsets[cell]) / kSteps;
    for (int i = 0; i < kSteps; ++i) {
      const double at = offsets[cell] + (i + 0.5) * width;
      integrals[cell] += FilterWeight(filter, radius, at / radius) * width;
    }
    whole += integrals[cell];
  }
  std::vector<float> factors(kFilterCells);
  for (std::uint32_t cell = 0; cell < kFilterCells; ++cell) {
    factors[cell] = float(kFilterCells * integrals[cell] / whole);
  }
  return factors;
}

std::vector<float> FilterDensities(const std::vector<float>& offsets, float radius) {
  // The cumulative distribution is linear between the offsets.
  std::size_t k = 0;
  const auto cumulative = [&](double t) {
    while (k < kFilterCells && offsets[k + 1] < t) ++k;
    if (k == kFilterCells) return 1.0;
    const double width = double(offsets[k + 1]) - offsets[k];
    const double inside = width > 0 ? std::clamp((t - offsets[k]) / width, 0.0, 1.0) : 1;
    return (double(k) + inside) / kFilterCells;
  };
  std::vector<float> densities(kFilterCells);
  const double cell = 2 * double(radius) / kFilterCells;
  double below = 0;
  for (std::size_t i = 0; i < kFilterCells; ++i) {
    const bool last = i + 1 == kFilterCells;
    const double up_to = last ? 1 : cumulative(double(i + 1) * cell - radius);
    densities[i] = float((up_to - below) / cell);
    below = up_to;
  }
  return densities;
}

CameraView MakeCameraView(const Camera& camera, int width, int height, const float* filter_offset,
                          const std::optional<CropWindow>& crop) {
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
  }
  const glm::dvec3 middle = perspective ? z : glm::dvec3(world[3]);
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
