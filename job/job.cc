#include "job/job.h"

#include <fmt/format.h>
#include <tbb/task_arena.h>

#include <algorithm>
#include <cassert>
#include <chrono>
#include <cmath>
#include <glm/gtc/constants.hpp>

#include "base/error.h"
#include "job/environment.h"
#include "scene/reader.h"
#include "scene/shapes/ground.h"
#include "wavefront/option_checks.h"

namespace skywave {
namespace {

// Kernels find rows and columns of pixels by float arithmetic that is exact up to these.
constexpr int kMaxFilmSide = 32768;
constexpr std::int64_t kMaxFilmPixels = std::int64_t{1} << 28;

using Clock = std::chrono::steady_clock;

double SecondsSince(Clock::time_point start) {
  return std::chrono::duration<double>(Clock::now() - start).count();
}

// Luminance of what a map sends through the disk of a sphere around the scene.
double EnvironmentPower(const Image& map, float radius) {
  const std::array<double, 3> mean = SphereMean(map);
  double luminance = 0;
  for (std::size_t c = 0; c < 3; ++c) luminance += double(kLuminance[c]) * mean[c];
  constexpr double kPi = glm::pi<double>();
  return 4 * kPi * luminance * kPi * double(radius) * radius;
}

// Runs `work` with as many threads as the user allows.
template <class Work>
void RunOnThreads(int threads, const Work& work) {
  tbb::task_arena arena(threads > 0 ? threads : tbb::task_arena::automatic);
  arena.execute(work);
}

// `sky`: whether there is light in the map.
std::unique_ptr<EnvStrategy> MakeUsableStrategy(const std::string& specification,
                                                const EnvironmentMap& map, bool environment,
                                                const RenderOptions& options) {
  std::unique_ptr<EnvStrategy> strategy = MakeStrategy(specification, map);
  if (!options.mis && !strategy->complete()) {
    throw InputError(InputPosition::File("--strategy " + specification),
                     "leaves light to BSDF sampling, so it cannot go with --no-mis", kExitUsage);
  }
  if (Describe(options.integrator).light_paths == LightPaths::kStrategy && environment &&
      !CanEmit(*strategy)) {
    throw InputError(InputPosition::File("--strategy " + specification),
                     fmt::format("no light path can start with its samples, as --integrator {} "
                                 "needs it: use importance, alias, warp, uniform, presampled, or "
                                 "directional lights with pick=power",
                                 ToString(options.integrator)),
                     kExitUsage);
  }
  return strategy;
}

// The camera of the scene, or else one that sees all of it, changed as the flags have it.
// `aspect`: width / height of the whole film.
Camera ChooseCamera(const Scene& scene, const Bounds& bounds, const CameraRequest& wish,
                    float aspect) {
  Camera camera =
      scene.camera ? *scene.camera : FrameBounds(bounds, scene.up_axis, scene.left_handed, aspect);
  const glm::vec3 middle = 0.5f * (bounds.low + bounds.high);
  if (wish.fov_degrees) camera.fov_degrees = *wish.fov_degrees;
  if (wish.eye || wish.target) {
    const glm::vec3 eye = wish.eye.value_or(glm::vec3(camera.world_from_camera[3]));
    const glm::vec3 target = wish.target.value_or(middle);
    const glm::vec3 up = EnvironmentFrame(scene.up_axis, scene.left_handed, 0)[2];
    const glm::vec3 view = target - eye;
    if (!(glm::length(glm::cross(view, up)) > 1e-5f * glm::length(view))) {
      throw InputError(InputPosition::File("--eye, --target"),
                       "the camera has to look somewhere, and not straight up or down", kExitUsage);
    }
    camera.world_from_camera =
        LookAtCamera(eye, target, up, camera.fov_degrees, scene.left_handed).world_from_camera;
  }
  if (wish.kind) {
    camera = WithKind(camera, *wish.kind, bounds, scene.up_axis, scene.left_handed);
    if (wish.fov_degrees) camera.fov_degrees = *wish.fov_degrees;
  }
  constexpr float kWidestPlane = 179;
  if (wish.fov_degrees > kWidestPlane && camera.kind != CameraKind::kFisheye) {
    throw InputError(InputPosition::File(fmt::format("--fov {}", *wish.fov_degrees)),
                     fmt::format("a {} camera sees at most {} degrees; --camera fisheye sees more",
                                 ToString(camera.kind), kWidestPlane),
                     kExitUsage);
  }
  const glm::mat3 axes(camera.world_from_camera);
  const float depth = glm::length(axes[2]);
  if (wish.lens_radius) {
    camera.lens_radius = *wish.lens_radius / glm::length(axes[0]);
    const glm::vec3 eye(camera.world_from_camera[3]);
    const float distance = glm::dot(middle - eye, axes[2]) / (depth * depth);
    if (distance > 0) camera.focal_distance = distance;
  }
  if (wish.focal_distance) camera.focal_distance = *wish.focal_distance / depth;
  return camera;
}

// The part of the film that is rendered: as the flag, or else the scene has it. pbrt rounds
// fractions up to pixels.
std::optional<CropWindow> ChooseCrop(const JobRequest& request, const RenderSettings& said,
                                     const RenderOptions& options) {
  std::optional<CropWindow> crop = request.crop;
  if (!crop && said.crop) {
    const auto pixel = [](float fraction, int size) {
      return int(std::ceil(double(fraction) * size));
    };
    const int x = pixel(said.crop->left, options.width), y = pixel(said.crop->top, options.height);
    crop = CropWindow{x, y, pixel(said.crop->right, options.width) - x,
                      pixel(said.crop->bottom, options.height) - y};
  }
  if (!crop) return crop;
  if (crop->x < 0 || crop->y < 0 || crop->width <= 0 || crop->height <= 0 ||
      crop->x > options.width - crop->width || crop->y > options.height - crop->height) {
    throw InputError(
        InputPosition::File(request.scene),
        fmt::format("no pixel, or not all, of the part {}x{}+{}+{} is on the film of "
                    "{} x {}",
                    crop->width, crop->height, crop->x, crop->y, options.width, options.height));
  }
  return crop;
}

// Of all surfaces; larger than need be by what floats may lose of its disk.
SceneSphere BoundingSphere(const Bounds& bounds) {
  const glm::vec3 center = 0.5f * (bounds.low + bounds.high);
  const float radius = BoundingRadius(bounds), margin = radius * 0x1p-10f;
  const glm::vec3 low = bounds.low - margin, high = bounds.high + margin;
  return {.center = {center.x, center.y, center.z},
          .radius = radius + margin,
          .low = {low.x, low.y, low.z},
          .high = {high.x, high.y, high.z}};
}

float WorldExtent(const Bounds& bounds, const Camera& camera) {
  const glm::vec3 farthest = glm::max(glm::abs(bounds.low), glm::abs(bounds.high));
  return glm::length(farthest) + glm::length(glm::vec3(camera.world_from_camera[3]));
}

std::array<float, 9> Rows(const glm::mat3& columns) {
  std::array<float, 9> rows;
  for (int i = 0; i < 9; ++i) rows[std::size_t(i)] = columns[i / 3][i % 3];
  return rows;
}

}  // namespace

std::uint32_t MostPointsOfASample(const RenderOptions& options) {
  return std::max(options.light_samples, options.split);
}

RenderJob::RenderJob(const JobRequest& request) {
  const auto start = Clock::now();
  Scene scene = ReadScene(request.scene, request.read);
  times_.load = SecondsSince(start);
  BuildOnThreads(std::move(scene), request);
}

RenderJob::RenderJob(Scene scene, const JobRequest& request) {
  BuildOnThreads(std::move(scene), request);
}

void RenderJob::BuildOnThreads(Scene scene, const JobRequest& request) {
  RunOnThreads(request.options.threads, [&] { Build(std::move(scene), request); });
}

void RenderJob::Build(Scene scene, const JobRequest& request) {
  notes_ = scene.warnings;
  scene_name_ = request.scene;
  scene.up_axis = request.environment.up_axis.value_or(scene.up_axis);
  options_ = request.options;
  const RenderSettings& said = scene.settings;
  options_.width = request.width.value_or(said.width.value_or(options_.width));
  options_.height = request.height.value_or(said.height.value_or(options_.height));
  options_.samples_per_pixel = request.samples_per_pixel.value_or(
      std::uint32_t(said.samples_per_pixel.value_or(int(options_.samples_per_pixel))));
  options_.max_depth =
      request.max_depth.value_or(std::uint32_t(said.max_depth.value_or(int(options_.max_depth))));
  if (options_.max_depth > kMaxDepth) {
    notes_.push_back(fmt::format("{}: a depth of {} is lowered to {}", request.scene,
                                 options_.max_depth, kMaxDepth));
    options_.max_depth = kMaxDepth;
  }
  options_.integrator = request.integrator.value_or(
      Parse<Integrator>(said.integrator.value_or("")).value_or(options_.integrator));
  const IntegratorDescriptor& integrator = Describe(options_.integrator);
  if (said.photons_each_sample && integrator.has_photons() && !integrator.pass_each_sample) {
    PhotonOptions& photons = options_.photons;
    if (photons.passes == 0) photons.passes = options_.samples_per_pixel;
    if (photons.distance <= 0) photons.distance = said.photon_distance.value_or(0);
  }
  options_.filter = request.filter.value_or(said.filter.value_or(options_.filter));
  if (options_.filter_radius <= 0) {
    options_.filter_radius =
        request.filter ? DefaultFilterRadius(options_.filter)
                       : said.filter_radius.value_or(DefaultFilterRadius(options_.filter));
  }
  if (options_.width <= 0 || options_.height <= 0 || options_.width > kMaxFilmSide ||
      options_.height > kMaxFilmSide ||
      std::int64_t{options_.width} * options_.height > kMaxFilmPixels) {
    throw InputError(InputPosition::File(request.scene),
                     fmt::format("a film of {} x {} pixels cannot be rendered", options_.width,
                                 options_.height));
  }
  const std::optional<CropWindow> crop = ChooseCrop(request, said, options_);
  if (crop) {
    options_.film_width = options_.width, options_.film_height = options_.height;
    options_.width = crop->width, options_.height = crop->height;
    options_.crop_x = crop->x, options_.crop_y = crop->y;
  }
  if (options_.samples_per_pixel == 0) {
    throw InputError(InputPosition::File(request.scene), "0 samples a pixel show nothing");
  }
  if (options_.split == 0 && !request.continuation_strategy.empty()) {
    throw InputError(InputPosition::File("--continuation-strategy"),
                     "is that of paths behind their first hit: give --split S as well", kExitUsage);
  }
  if (std::uint64_t{options_.samples_per_pixel} * MostPointsOfASample(options_) > 0xFFFFFFFFu) {
    throw InputError(InputPosition::File(request.scene),
                     fmt::format("{} samples a pixel with {} light samples or continuations each "
                                 "are more than the 2^32 points of a pixel's sequence",
                                 options_.samples_per_pixel, MostPointsOfASample(options_)),
                     kExitUsage);
  }

  if (options_.max_depth == 0 && ReadsHits(options_.aovs)) {
    throw InputError(InputPosition::File("--aovs " + ToString(options_.aovs)),
                     "at --max-depth 0 no surface is looked at", kExitUsage);
  }

  CheckIntegrator(options_);

  const auto load_start = Clock::now();
  EnvironmentLight light = LoadEnvironment(scene, request, notes_);
  times_.load += SecondsSince(load_start);

  const Bounds bounds = SceneBounds(scene, request.scene);
  if (!scene.camera && !request.camera.eye) {
    notes_.push_back(request.scene + ": has no camera; one that sees the whole scene is used");
  }
  const int film_width = crop ? options_.film_width : options_.width;
  const int film_height = crop ? options_.film_height : options_.height;
  scene.camera =
      ChooseCamera(scene, bounds, request.camera, float(film_width) / float(film_height));
  if (request.ground) AddGround(scene, bounds);
  if (options_.aovs != 0) {
    world_extent_ = WorldExtent(SceneBounds(scene, request.scene), *scene.camera);
  }
  geometry_ = std::make_unique<Geometry>(scene, request.scene, options_.threads,
                                         request.embree_config, NeedsUvs(options_.aovs));
  times_.build = geometry_->build_seconds();

  brightest_ = *std::max_element(light.map->rgb.begin(), light.map->rgb.end());
  if (HasLocalLights(scene)) {
    const float radius = BoundingRadius(bounds);
    local_lights_ =
        LocalLights(scene, *geometry_, request.scene, radius, EnvironmentPower(*light.map, radius));
    brightest_ = std::max(brightest_, local_lights_.brightest());
  }
  sphere_ = BoundingSphere(SceneBounds(scene, request.scene));
  CheckLightPaths(options_.integrator);
  if (Sums(options_.aovs, AovSum::kLightGroups)) {
    light_groups_ = MakeLightGroups(scene, *geometry_, local_lights_.view());
  }
  // For the hash the light is part of the scene; for the strategy it is a map.
  scene.environments = {std::move(light)};
  scene_hash_ = SceneHash(scene);
  map_ = {.latlong = std::move(*scene.environments[0].map),
          .map_from_world = Rows(scene.environments[0].world_from_map)};
  const auto tables_start = Clock::now();
  strategy_ = MakeUsableStrategy(request.strategy, map_, has_environment(), options_);
  if (!request.continuation_strategy.empty()) {
    continuation_strategy_ =
        MakeUsableStrategy(request.continuation_strategy, map_, has_environment(), options_);
  }
  if (integrator.light_paths == LightPaths::kAny && has_environment() && !CanEmit(*strategy_)) {
    emitter_ = MakeStrategy("importance", map_);
  }
  times_.tables = SecondsSince(tables_start);
  if (options_.guide && integrator.has_light_paths() && !has_environment()) {
    notes_.push_back(
        "--guide changes nothing: it is for light from a map, which gives none here; light paths "
        "start at the lights by their power");
  }
  filter_offsets_ = FilterOffsets(options_.filter, options_.filter_radius);
  filter_densities_ = FilterDensities(filter_offsets_, options_.filter_radius);
  camera_ = MakeCameraView(*scene.camera, film_width, film_height, filter_offsets_.data(), crop);
}

// Throws InputError where no light path can start or is merged with everything.
void RenderJob::CheckLightPaths(Integrator integrator) const {
  if (!Describe(integrator).has_light_paths()) return;
  if (!(brightest_ > 0)) {
    throw InputError(InputPosition::File(scene_name_),
                     "nothing shines: the map is black and there are no lights, so no light path "
                     "can start; give light, as with --env, or render black by --integrator path");
  }
  if (!(sphere_.radius > 0) || !std::isfinite(sphere_.radius * sphere_.radius)) {
    throw InputError(
        InputPosition::File(scene_name_),
        fmt::format("its bounds, of radius {}, are no place for light paths; use --integrator path",
                    sphere_.radius));
  }
  if (const auto check = Describe(integrator).check_scene) check(options_, *geometry_, sphere_);
}

FrameView RenderJob::frame(Integrator integrator, const EnvStrategy& strategy) const {
  RenderOptions options = options_;
  options.integrator = integrator;
  const EnvStrategy* const emitter = CanEmit(strategy) ? &strategy
                                     : emitter_        ? emitter_.get()
                                                       : strategy_.get();
  assert(!Describe(integrator).has_light_paths() || !has_environment() || CanEmit(*emitter));
  return {.options = options,
          .geometry = geometry_.get(),
          .strategy = &strategy,
          .continuation_strategy = continuation_strategy_.get(),
          .local_lights = local_lights_.view(),
          .camera = camera_,
          .tracer = {.scene = geometry_->scene(),
                     .closest = options_.backend,
                     .occlusion = options_.backend,
                     .recorder = nullptr,
                     .first_with_alpha = geometry_->has_alpha()
                                             ? std::optional(geometry_->first_with_alpha())
                                             : std::nullopt},
          .sphere = sphere_,
          .filter = {.density = filter_densities_.data(), .radius = options_.filter_radius},
          .emitter = emitter,
          .map = &map_,
          .light_groups = light_groups_.names.empty() ? nullptr : &light_groups_};
}

bool RenderJob::has_environment() const {
  const LocalLightView lights = local_lights_.view();
  return lights.count == 0 || lights.shared.share < 1;
}

std::unique_ptr<EnvStrategy> RenderJob::MakeOtherStrategy(const std::string& specification,
                                                          Integrator integrator) const {
  RenderOptions options = options_;
  options.integrator = integrator;
  CheckIntegrator(options);
  CheckLightPaths(integrator);
  std::unique_ptr<EnvStrategy> strategy;
  RunOnThreads(options_.threads, [&] {
    strategy = MakeUsableStrategy(specification, map_, has_environment(), options);
  });
  return strategy;
}

Film RenderJob::MakeFilm(Integrator integrator) const {
  const FilmArea area = {
      int(camera_.width),
      int(camera_.height),
      {options_.crop_x - int(camera_.first_column), options_.crop_y - int(camera_.first_row),
       options_.width, options_.height}};
  return Film(area, brightest_, options_.aovs, world_extent_, Describe(integrator).has_splats,
              light_groups_.names);
}

}  // namespace skywave
