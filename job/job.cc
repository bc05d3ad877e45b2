#include "job/job.h"

#include <fmt/format.h>

#include <algorithm>
#include <bit>
#include <cassert>
#include <cmath>

#include "base/arena.h"
#include "base/clock.h"
#include "base/error.h"
#include "base/granted.h"
#include "job/backplate.h"
#include "job/camera_file.h"
#include "job/choose_camera.h"
#include "job/denoise/denoise.h"
#include "job/denoise/oidn.h"
#include "job/map_sequence.h"
#include "job/options.h"
#include "job/resolve.h"
#include "wavefront/option_checks.h"
#include "wavefront/option_names.h"
#include "wavefront/policies/emission_pilot.h"

namespace skywave {
namespace {

// Seconds that `work` takes.
template <class Work>
double Time(const Work& work) {
  const Clock::time_point start = Clock::now();
  work();
  return SecondsSince(start);
}

// With this strategy light paths start where that of the camera paths cannot emit.
constexpr char kEmitter[] = "importance";

// Returns what the strategy of an integrator's camera paths is for.
StrategyUse UseOf(const RenderOptions& options, std::uint32_t light_samples) {
  return {.mis = options.mis,
          .light_samples = light_samples,
          .starts_light_paths = Describe(options.integrator).has_light_paths()};
}

// Throws if there are too many local lights for each to take a sample.
void CheckLightCount(const LocalLightView& lights, const RenderOptions& options) {
  if (options.light_selection != LightSelection::kAll || lights.count <= kMostOfEach) return;
  throw OptionError("light-selection", "all",
                    fmt::format("takes a sample of each local light at every surface, of at most "
                                "{}; the scene has {}, triangles that shine counted: use "
                                "`light-selection tree`",
                                kMostOfEach, lights.count));
}

// Throws unless a strategy can be used. `environment`: whether there is light in the map.
void CheckStrategy(const EnvStrategy& strategy, const std::string& specification, bool environment,
                   const RenderOptions& options) {
  if (!options.mis && !strategy.complete()) {
    throw OptionError("strategy", specification,
                      "leaves light to BSDF sampling, so it cannot go with `no-mis`");
  }
  if (options.of<ControlOptions>().control != ControlVariate::kNone &&
      (!strategy.unbiased() || !strategy.shines_on_bsdf_samples() ||
       strategy.Plan(1).total() == 0)) {
    throw OptionError("strategy", specification,
                      fmt::format("has no samples whose density is known wherever the map shines, "
                                  "which `control {}` needs: use importance, product, presampled, "
                                  "alias or warp",
                                  ToString(options.of<ControlOptions>().control)));
  }
  if (Describe(options.integrator).light_paths == LightPaths::kStrategy && environment &&
      !CanEmit(strategy)) {
    throw OptionError("strategy", specification,
                      fmt::format("no light path can start with its samples, as `integrator {}` "
                                  "needs it: use importance, alias, warp, uniform, presampled, or "
                                  "directional lights with pick=power",
                                  ToString(options.integrator)));
  }
}

// Light that is scattered several times is the product of as many factors, and floats end at
// 1e-38.
constexpr float kLeastRadiance = 1e-20f;

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

// Returns whether light passes through some triangle.
bool LetsLightThrough(const Geometry& geometry) {
  for (std::uint32_t kind = 0; kind < kBsdfKinds; ++kind) {
    if ((geometry.bsdfs() >> kind & 1) != 0 && Bsdfs()[kind].transmits) return true;
  }
  return geometry.has_alpha();
}

float DistanceFromOrigin(const SceneSphere& sphere) {
  return std::hypot(sphere.center[0], sphere.center[1], sphere.center[2]);
}

// Returns 1 for each local light that is a triangle of an object; nothing where there are none or
// no catchers.
std::vector<std::uint8_t> ObjectLamps(const Geometry& geometry, const LocalLightView& lights) {
  if (geometry.catchers() == nullptr || lights.light_of_triangle == nullptr) return {};
  std::vector<std::uint8_t> lamps(lights.count, 0);
  for (std::uint32_t i = 0; i < geometry.triangle_count(); ++i) {
    const std::uint32_t light = lights.light_of_triangle[i];
    if (light != kNoLight && !geometry.IsCatcher(i)) lamps[light] = 1;
  }
  return lamps;
}

// Returns the patches of a sky over a scene. North is where the middle of a map looks that is not
// turned.
SkyPatches SkyOf(SkyDivision division, const Scene& scene) {
  const glm::mat3 frame = EnvironmentFrame(scene.up_axis, scene.left_handed, 0);
  const auto axis = [&](int i) { return std::array{frame[i].x, frame[i].y, frame[i].z}; };
  return {.division = division, .east = axis(0), .north = axis(1), .up = axis(2)};
}

// Returns the seed of the random numbers of a frame of an animation, by the finalizer of SplitMix64
// (Steele, Lea and Flood 2014).
std::uint32_t SeedOfFrame(std::uint32_t seed, double frame) {
  std::uint64_t bits = std::bit_cast<std::uint64_t>(frame + 0.0);  // -0 is 0
  bits += (std::uint64_t{seed} + 1) * 0x9E3779B97F4A7C15u;
  bits = (bits ^ (bits >> 30)) * 0xBF58476D1CE4E5B9u;
  bits = (bits ^ (bits >> 27)) * 0x94D049BB133111EBu;
  return std::uint32_t((bits ^ (bits >> 31)) >> 32);
}

float WorldExtent(const Scene& scene, const Bounds& bounds, const Camera& camera) {
  const glm::vec3 farthest = glm::max(glm::abs(bounds.low), glm::abs(bounds.high));
  return glm::length(farthest) + glm::length(glm::vec3(camera.world_from_camera[3])) +
         float(glm::length(scene.origin));
}

}  // namespace

RenderJob::RenderJob(const JobRequest& request, JobCache* cache) {
  ArenaOf(request.options.threads).execute([&] {
    std::optional<JobParts> parts;
    times_.load = Time([&] { parts.emplace(request, cache); });
    Build(std::move(*parts), request);
  });
}

RenderJob::RenderJob(const SharedScene& scene, const JobRequest& request, double load_seconds) {
  times_.load = load_seconds;
  ArenaOf(request.options.threads).execute([&] { Build(JobParts(scene), request); });
}

RenderJob::RenderJob(Scene scene, const JobRequest& request)
    : RenderJob(SharedScene(std::make_shared<LoadedScene>(std::move(scene))), request) {}

void RenderJob::Build(JobParts parts, const JobRequest& request) {
  warnings_ = parts.loaded().warnings;
  notes_ = parts.loaded().notes;
  if (request.read.frame && parts.loaded().animations.empty() &&
      !IsMapSequence(request.environment.path)) {
    notes_.push_back(fmt::format("{}: has no animation, so all of its frames are the same{}",
                                 request.scene, request.coherent_noise ? "" : " but for noise"));
  }
  request_ = request;
  TakeCameraOfFile(request_, warnings_);
  request_ = ResolveRequest(std::move(request_), parts.loaded().settings, notes_);
  if (request_.denoise == Denoiser::kAuto && OidnVersion().empty()) {
    notes_.emplace_back(
        "`denoise auto`: Open Image Denoise is not there (pip install pyoidn brings it), so "
        "statistics alone are used");
  }
  request_.denoise = ResolveDenoiser(request_.denoise);
  if (options().threads == 0) {
    notes_.insert(notes_.end(), GrantedHere().notes.begin(), GrantedHere().notes.end());
  }
  parts.Prepare(request_);
  const PreparedScene& prepared = parts.prepared();
  PlanComposites(*prepared.scene);
  std::shared_ptr<const LoadedLight> light;
  times_.load += Time([&] { light = parts.Light(request_); });
  notes_.insert(notes_.end(), light->notes.begin(), light->notes.end());

  sphere_ = BoundingSphere(prepared.whole_bounds);
  PlaceCamera(prepared);
  times_.build = Time([&] { geometry_ = parts.Build(request_); });
  PlaceLights(parts, *light);
  CheckLightPaths(options().integrator);

  // For the hash the light is part of the scene; for the strategy it is a map.
  scene_hash_ = prepared.content.WithView(
      scene_camera_, light->light, parts.WorldFromMap(request_, *light), prepared.scene->lights);
  map_hash_ = light->hash;
  times_.tables = Time([&] {
    BuildStrategies(parts, light);
    PlaceProjection(parts, *light);
    if (NeedsMotion(options().aovs)) {
      const NeighbourFrames beside = FindMotion(request_, parts, geometry_, camera_);
      motion_ = beside.motion;
      scene_hash_ ^= beside.hash;
    }
  });
  // Light of a map comes into a closed room through edges alone. Openings that are given let it in,
  // and so does what light passes through.
  if (has_environment() && map_->map.portals.empty() && !LetsLightThrough(geometry()) &&
      IsClosedAround(geometry().scene(), camera_.origin)) {
    beside_ = (sphere_.radius + DistanceFromOrigin(sphere_)) * 0x1p-18f;
  }
}

void RenderJob::PlanComposites(const Scene& scene) {
  RenderOptions& options = request_.options;
  AovSet layers = 0;
  if (HasCatchers(scene)) {
    request_.background = request_.background.value_or(Background::kTransparent);
    layers = CatcherAovs();
    // A denoiser needs those of the parts as well.
    if (HasDenoiserLayers(options.aovs)) layers |= DenoiserLayers(layers);
  } else if ((options.aovs & (CatcherAovs() | PartAovs()) & ~AovsOf(AovSum::kAlpha)) != 0) {
    throw OptionError("aovs", ToString(options.aovs),
                      "the scene has no catchers: name some, as in `catcher ground`");
  }
  if (HasHoldouts(scene) || !request_.backplate.empty() || request_.dome) {
    request_.background = request_.background.value_or(Background::kTransparent);
  }
  if (!request_.backplate.empty()) {
    if (request_.background == Background::kMap) {
      throw OptionError("backplate", request_.backplate,
                        "is behind pictures with alpha, and `background map` has none");
    }
    const Backplate plate = ReadBackplate(request_.backplate, *request_.width, *request_.height);
    if (!plate.note.empty()) notes_.push_back(plate.note);
    if (plate.has_alpha) {
      Warnings found = MakeWarnings(request_.read);
      AddWarning(found, InputPosition::File(request_.backplate),
                 "the alpha of the photograph is left out: it is taken for opaque, with the "
                 "colours that it has where it is not");
      warnings_.push_back(WarningLines(found).front());
    }
  }
  layers |= PlanProjection(request_, HasCatchers(scene));
  PlanLinks(request_, HasCatchers(scene));
  if (request_.background == Background::kTransparent) layers |= AovsOf(AovSum::kAlpha);
  if (request_.sky_patches != SkyDivision::kNone) {
    if (options.of<ControlOptions>().control != ControlVariate::kNone) {
      throw OptionError("sky-patches", std::string(ToString(request_.sky_patches)),
                        "what `control` knows is light of the whole sky");
    }
    layers |= AovsOf(AovSum::kLightGroups);
  }
  options.aovs |= layers;
  if (layers != 0 || options.of<LinkOptions>().count > 0) CheckResolved(request_);
}

void RenderJob::PlaceCamera(const PreparedScene& prepared) {
  if (!prepared.scene->camera && !request_.camera.placed && !request_.camera.eye) {
    notes_.push_back(request_.scene + ": has no camera; one that sees the whole scene is used");
  }
  const int width = *request_.width, height = *request_.height;  // of the whole film
  scene_camera_ = ChooseCamera(prepared, request_);
  filter_offsets_ = FilterOffsets(options().filter, options().filter_radius);
  filter_densities_ = FilterDensities(filter_offsets_, options().filter_radius);
  filter_factors_ = FilterFactors(options().filter, options().filter_radius, filter_offsets_);
  camera_ =
      MakeCameraView(scene_camera_, width, height, filter_offsets_.data(), request_.crop, &sphere_);
}

void RenderJob::PlaceLights(const JobParts& parts, const LoadedLight& light) {
  const PreparedScene& prepared = parts.prepared();
  local_lights_ = parts.Lamps(request_, light, geometry_);
  light_tree_ = parts.TreeOfLamps(request_, light, local_lights());
  brightest_ = std::max(light.brightest, local_lights().brightest());
  if (brightest_ > 0 && brightest_ < kLeastRadiance) {
    throw InputError(
        InputPosition::File(request_.scene),
        fmt::format("the brightest light has a radiance of {:g}, less than {:g}, of which "
                    "floats lose the digits: make it brighter, as with --env-intensity",
                    brightest_, kLeastRadiance));
  }
  if (Sums(options().aovs, AovSum::kLightGroups)) {
    light_groups_ = MakeLightGroups(*prepared.scene, geometry(), local_lights().view(),
                                    SkyOf(request_.sky_patches, *prepared.scene));
  }
  if (Sums(options().aovs, AovSum::kMatte) || Sums(options().aovs, AovSum::kNearestHit)) {
    names_ = std::make_shared<Mattes>(MakeMattes(*prepared.scene));
  }
  CheckLightCount(local_lights().view(), options());
  object_lamps_ = ObjectLamps(geometry(), local_lights().view());
  links_ =
      MakeLinks(request_, *prepared.scene, geometry(), local_lights().view(), has_environment());
  if (options().aovs != 0 || request_.denoise != Denoiser::kNone)
    world_extent_ = WorldExtent(*prepared.scene, prepared.whole_bounds, scene_camera_);
}

void RenderJob::BuildStrategies(const JobParts& parts,
                                const std::shared_ptr<const LoadedLight>& light) {
  map_ = parts.Place(request_, light);
  const auto make = [&](const std::string& specification, std::uint32_t light_samples) {
    StrategyUse use = UseOf(options(), light_samples);
    // Nothing else sees the light of a map whose shadows have links.
    use.mis = use.mis && (links_.view.of_environment & links_.view.of_shadows) == 0;
    auto tables = parts.Tables(request_, specification, use, *light, map_);
    CheckStrategy(*tables->strategy, specification, has_environment(), options());
    const std::string note = tables->strategy->note();
    if (!note.empty()) notes_.push_back(fmt::format("{}: {}", specification, note));
    return tables;
  };
  strategy_ = make(StrategyOfFrame(request_), LightSamplesOf(options()));
  if (!request_.continuation_strategy.empty()) {
    continuation_strategy_ = make(request_.continuation_strategy, 1);
  }
  if (options().of<ControlOptions>().control != ControlVariate::kNone && has_environment()) {
    irradiance_ = parts.Irradiance(request_, *light, *map_);
    control_ = {.irradiance = irradiance_->table.view()};
  }
  const IntegratorDescriptor& integrator = Describe(options().integrator);
  if (NeedsEmitter(options().integrator, strategy())) emitter_ = make(kEmitter, 1);
  if (options().of<GuideOptions>().guide && integrator.has_light_paths() && !has_environment()) {
    notes_.emplace_back(
        "--guide changes nothing: it is for light from a map, which gives none here; light paths "
        "start at the lights by their power");
  }
}

void RenderJob::PlaceProjection(const JobParts& parts, const LoadedLight& light) {
  const auto of_objects = std::count(object_lamps_.begin(), object_lamps_.end(), 1);
  place_ = ProjectPlace({.request = request_,
                         .parts = parts,
                         .light = light,
                         .map = has_environment() ? map_ : nullptr,
                         .camera = scene_camera_,
                         .has_lamps = local_lights().view().count > std::size_t(of_objects)},
                        notes_);
}

// Whether light paths start at the map and the strategy of the camera paths cannot emit them.
bool RenderJob::NeedsEmitter(Integrator integrator, const EnvStrategy& strategy) const {
  return Describe(integrator).light_paths == LightPaths::kAny && has_environment() &&
         !CanEmit(strategy);
}

// Throws InputError where no light path can start or is merged with everything, and where light
// paths would bring light to surfaces that cut holes.
void RenderJob::CheckLightPaths(Integrator integrator) const {
  if (!Describe(integrator).has_light_paths()) return;
  if (scene_camera_.kind == CameraKind::kRealistic && Describe(integrator).has_splats) {
    throw OptionError("integrator", std::string(ToString(integrator)),
                      "has light paths that end at the camera, and no connection goes through the "
                      "lens of a realistic one: use `integrator path`");
  }
  if (geometry().holdouts() != nullptr) {
    throw OptionError("holdout", "",
                      fmt::format("goes with integrators whose paths all begin at the camera, as "
                                  "path and direct, not with `integrator {}`",
                                  ToString(integrator)));
  }
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
  if (const auto check = Describe(integrator).check_scene) check(options(), geometry(), sphere_);
}

FrameView RenderJob::frame(Integrator integrator, const EnvStrategy& strategy,
                           const EnvStrategy* emitter) const {
  RenderOptions changed = options();
  changed.integrator = integrator;
  if (request_.read.frame && !request_.coherent_noise) {
    changed.seed = SeedOfFrame(changed.seed, *request_.read.frame);
  }
  if (emitter == nullptr) emitter = &strategy;
  assert(!Describe(integrator).has_light_paths() || !has_environment() || CanEmit(*emitter));
  FrameView frame = {
      .options = changed,
      .geometry = &geometry(),
      .strategy = &strategy,
      .continuation_strategy =
          continuation_strategy_ ? continuation_strategy_->strategy.get() : nullptr,
      .local_lights = local_lights().view(),
      .camera = camera_,
      .tracer = {.scene = geometry().scene(),
                 .closest = options().backend,
                 .occlusion = options().backend,
                 .recorder = nullptr,
                 .first_with_alpha = geometry().has_alpha()
                                         ? std::optional(geometry().first_with_alpha())
                                         : std::nullopt,
                 .places = geometry().places(),
                 .instances = geometry().instances(),
                 .triangles = geometry().triangles(),
                 .one_sided = geometry().has_one_sided(),
                 // Rays from lights end outside of the room.
                 .beside = Describe(integrator).has_light_paths() ? 0 : beside_},
      .sphere = sphere_,
      .filter = {.density = filter_densities_.data(),
                 .radius = options().filter_radius,
                 .factor = filter_factors_.empty() ? nullptr : filter_factors_.data()},
      .emitter = emitter,
      .map = &map_->map,
      .light_groups = light_groups_.names.empty() ? nullptr : &light_groups_,
      .shows_background = request_.background != Background::kTransparent,
      .catchers = geometry().catchers(),
      .object_lamps = object_lamps_.empty() ? nullptr : object_lamps_.data()};
  if (light_tree_) frame.local_lights.tree = &light_tree_->view;
  if (irradiance_) frame.Show(&control_);
  if (!links_.unlit.empty()) frame.Show(&links_.view);
  if (place_ && Sums(options().aovs, AovSum::kBackdrop)) frame.Show(&place_->dome);
  if (place_ && place_->projects()) frame.Show(&place_->projection);
  if (motion_.next) frame.Show(&motion_);
  return frame;
}

bool RenderJob::has_environment() const {
  const LocalLightView lights = local_lights().view();
  return lights.count == 0 || lights.shared.share < 1;
}

RenderMethod RenderJob::MakeMethod(const std::string& specification, Integrator integrator) const {
  RenderOptions changed = options();
  changed.integrator = integrator;
  CheckIntegrator(changed);
  CheckLightPaths(integrator);
  RenderMethod method = {.integrator = integrator, .strategy = nullptr, .emitter = nullptr};
  ArenaOf(options().threads).execute([&] {
    method.strategy =
        MakeStrategy(specification, map_->map, UseOf(changed, LightSamplesOf(changed)));
    CheckStrategy(*method.strategy, specification, has_environment(), changed);
    if (NeedsEmitter(integrator, *method.strategy)) {
      method.emitter = MakeStrategy(kEmitter, map_->map, UseOf(changed, 1));
    }
  });
  return method;
}

FilmLayout RenderJob::LayoutOfFilm(Integrator integrator, AovSet layers) const {
  const FilmArea area = {
      int(camera_.width),
      int(camera_.height),
      {options().crop_x - int(camera_.first_column), options().crop_y - int(camera_.first_row),
       options().width, options().height}};
  return {.area = area,
          .brightest_radiance = brightest_,
          .aovs = options().aovs | layers |
                  (request_.denoise != Denoiser::kNone ? DenoiserLayers(options().aovs) : 0),
          .world_extent = world_extent_,
          .shared = Describe(integrator).has_splats,
          .light_groups = light_groups_.names,
          .has_signs = options().of<ControlOptions>().control != ControlVariate::kNone ||
                       HasSigns(options().filter),
          .mattes = Sums(options().aovs | layers, AovSum::kMatte) ? names_ : nullptr};
}

Film RenderJob::MakeFilm(Integrator integrator, AovSet layers) const {
  return Film(LayoutOfFilm(integrator, layers));
}

}  // namespace skywave
