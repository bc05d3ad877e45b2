#include "job/job.h"

#include <fmt/format.h>
#include <tbb/task_arena.h>

#include <algorithm>
#include <cassert>
#include <cmath>
#include <glm/gtc/constants.hpp>

#include "base/clock.h"
#include "base/error.h"
#include "base/granted.h"
#include "job/choose_camera.h"
#include "job/environment.h"
#include "job/material_changes.h"
#include "job/options.h"
#include "scene/reader.h"
#include "scene/scene_hash.h"
#include "scene/shapes/ground.h"
#include "wavefront/option_checks.h"
#include "wavefront/option_names.h"

namespace skywave {
namespace {

// Seconds that `work` takes.
template <class Work>
double Time(const Work& work) {
  const Clock::time_point start = Clock::now();
  work();
  return SecondsSince(start);
}

// Luminance of the light that a map sends through the disk of a sphere around the scene.
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
  tbb::task_arena arena(ThreadsFor(threads));
  arena.execute(work);
}

// Returns the number of threads for Embree's device: 0, all of the machine, unless there is a
// limit, because Embree holds the whole process to any other number as long as the device lives.
int EmbreeThreads(int threads) {
  return threads == 0 && GrantedHere().limits_threads() ? GrantedHere().threads : threads;
}

// `environment`: whether there is light in the map.
std::unique_ptr<EnvStrategy> MakeUsableStrategy(const std::string& specification,
                                                const EnvironmentMap& map, bool environment,
                                                const RenderOptions& options) {
  std::unique_ptr<EnvStrategy> strategy = MakeStrategy(specification, map);
  if (!options.mis && !strategy->complete()) {
    throw OptionError("strategy", specification,
                      "leaves light to BSDF sampling, so it cannot go with `no-mis`");
  }
  if (Describe(options.integrator).light_paths == LightPaths::kStrategy && environment &&
      !CanEmit(*strategy)) {
    throw OptionError("strategy", specification,
                      fmt::format("no light path can start with its samples, as `integrator {}` "
                                  "needs it: use importance, alias, warp, uniform, presampled, or "
                                  "directional lights with pick=power",
                                  ToString(options.integrator)));
  }
  return strategy;
}

// A sphere around all surfaces. It is larger than need be by what floats may lose of its disk.
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

RenderJob::RenderJob(const JobRequest& request) {
  Scene scene;
  times_.load = Time([&] { scene = ReadScene(request.scene, request.read); });
  BuildOnThreads(std::move(scene), request);
}

RenderJob::RenderJob(Scene scene, const JobRequest& request, double load_seconds) {
  times_.load = load_seconds;
  BuildOnThreads(std::move(scene), request);
}

void RenderJob::BuildOnThreads(Scene scene, const JobRequest& request) {
  RunOnThreads(request.options.threads, [&] { Build(std::move(scene), request); });
}

void RenderJob::Build(Scene scene, const JobRequest& request) {
  notes_ = scene.warnings;
  request_ = ResolveRequest(request, scene.settings, notes_);
  if (options().threads == 0) {
    notes_.insert(notes_.end(), GrantedHere().notes.begin(), GrantedHere().notes.end());
  }
  ChangeMaterials(request_.materials, scene);
  scene.up_axis = request.environment.up_axis.value_or(scene.up_axis);
  EnvironmentLight light;
  times_.load += Time([&] { light = LoadEnvironment(scene, request_, notes_); });

  const Bounds bounds = SceneBounds(scene, request.scene);  // without the ground
  PlaceCamera(scene, bounds);
  if (request.ground) AddGround(scene, bounds);
  geometry_ = std::make_unique<Geometry>(scene, request.scene, EmbreeThreads(options().threads),
                                         request.embree_config, NeedsUvs(options().aovs));
  times_.build = geometry_->build_seconds();
  sphere_ = BoundingSphere(SceneBounds(scene, request.scene));
  PlaceLights(scene, *light.map, BoundingRadius(bounds));
  CheckLightPaths(options().integrator);

  // For the hash the light is part of the scene; for the strategy it is a map.
  scene.environments = {std::move(light)};
  scene_hash_ = SceneHash(scene);
  map_hash_ = MapHash(*scene.environments[0].map);
  map_ = {.latlong = std::move(*scene.environments[0].map),
          .map_from_world = Rows(scene.environments[0].world_from_map)};
  times_.tables = Time([&] { BuildStrategies(); });
}

void RenderJob::PlaceCamera(Scene& scene, const Bounds& bounds) {
  if (!scene.camera && !request_.camera.eye) {
    notes_.push_back(request_.scene + ": has no camera; one that sees the whole scene is used");
  }
  const int width = *request_.width, height = *request_.height;  // of the whole film
  scene.camera = ChooseCamera(scene, bounds, request_.camera, float(width) / float(height));
  filter_offsets_ = FilterOffsets(options().filter, options().filter_radius);
  filter_densities_ = FilterDensities(filter_offsets_, options().filter_radius);
  camera_ = MakeCameraView(*scene.camera, width, height, filter_offsets_.data(), request_.crop);
}

void RenderJob::PlaceLights(const Scene& scene, const Image& map, float radius) {
  brightest_ = *std::max_element(map.rgb.begin(), map.rgb.end());
  if (HasLocalLights(scene)) {
    local_lights_ =
        LocalLights(scene, *geometry_, request_.scene, radius, EnvironmentPower(map, radius));
    brightest_ = std::max(brightest_, local_lights_.brightest());
  }
  if (Sums(options().aovs, AovSum::kLightGroups)) {
    light_groups_ = MakeLightGroups(scene, *geometry_, local_lights_.view());
  }
  if (options().aovs != 0) {
    world_extent_ = WorldExtent(SceneBounds(scene, request_.scene), *scene.camera);
  }
}

void RenderJob::BuildStrategies() {
  strategy_ = MakeUsableStrategy(request_.strategy, map_, has_environment(), options());
  if (!request_.continuation_strategy.empty()) {
    continuation_strategy_ =
        MakeUsableStrategy(request_.continuation_strategy, map_, has_environment(), options());
  }
  const IntegratorDescriptor& integrator = Describe(options().integrator);
  if (integrator.light_paths == LightPaths::kAny && has_environment() && !CanEmit(*strategy_)) {
    emitter_ = MakeStrategy("importance", map_);
  }
  if (options().guide && integrator.has_light_paths() && !has_environment()) {
    notes_.emplace_back(
        "--guide changes nothing: it is for light from a map, which gives none here; light paths "
        "start at the lights by their power");
  }
}

// Throws InputError where no light path can start or is merged with everything.
void RenderJob::CheckLightPaths(Integrator integrator) const {
  if (!Describe(integrator).has_light_paths()) return;
  if (!(brightest_ > 0)) {
    throw InputError(InputPosition::File(request_.scene),
                     "nothing shines: the map is black and there are no lights, so no light path "
                     "can start; give light, as with --env, or render black by --integrator path");
  }
  if (!(sphere_.radius > 0) || !std::isfinite(sphere_.radius * sphere_.radius)) {
    throw InputError(
        InputPosition::File(request_.scene),
        fmt::format("its bounds, of radius {}, are no place for light paths; use --integrator path",
                    sphere_.radius));
  }
  if (const auto check = Describe(integrator).check_scene) check(options(), *geometry_, sphere_);
}

FrameView RenderJob::frame(Integrator integrator, const EnvStrategy& strategy) const {
  RenderOptions changed = options();
  changed.integrator = integrator;
  const EnvStrategy* const emitter = CanEmit(strategy) ? &strategy
                                     : emitter_        ? emitter_.get()
                                                       : strategy_.get();
  assert(!Describe(integrator).has_light_paths() || !has_environment() || CanEmit(*emitter));
  return {.options = changed,
          .geometry = geometry_.get(),
          .strategy = &strategy,
          .continuation_strategy = continuation_strategy_.get(),
          .local_lights = local_lights_.view(),
          .camera = camera_,
          .tracer = {.scene = geometry_->scene(),
                     .closest = options().backend,
                     .occlusion = options().backend,
                     .recorder = nullptr,
                     .first_with_alpha = geometry_->has_alpha()
                                             ? std::optional(geometry_->first_with_alpha())
                                             : std::nullopt},
          .sphere = sphere_,
          .filter = {.density = filter_densities_.data(), .radius = options().filter_radius},
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
  RenderOptions changed = options();
  changed.integrator = integrator;
  CheckIntegrator(changed);
  CheckLightPaths(integrator);
  std::unique_ptr<EnvStrategy> strategy;
  RunOnThreads(options().threads, [&] {
    strategy = MakeUsableStrategy(specification, map_, has_environment(), changed);
  });
  return strategy;
}

Film RenderJob::MakeFilm(Integrator integrator, AovSet layers) const {
  const FilmArea area = {
      int(camera_.width),
      int(camera_.height),
      {options().crop_x - int(camera_.first_column), options().crop_y - int(camera_.first_row),
       options().width, options().height}};
  return Film({.area = area,
               .brightest_radiance = brightest_,
               .aovs = options().aovs | layers,
               .world_extent = world_extent_,
               .shared = Describe(integrator).has_splats,
               .light_groups = light_groups_.names});
}

}  // namespace skywave
