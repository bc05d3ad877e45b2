#include "job/job_parts.h"

#include <fmt/format.h>

#include <algorithm>
#include <atomic>
#include <filesystem>
#include <numbers>
#include <utility>

#include "base/files.h"
#include "base/granted.h"
#include "job/environment.h"
#include "job/links.h"
#include "job/map_sequence.h"
#include "job/marks.h"
#include "job/material_changes.h"
#include "job/options.h"
#include "job/portals.h"
#include "lights/maps/environment_map.h"
#include "scene/instances.h"
#include "scene/reader.h"
#include "scene/shapes/ground.h"
#include "scene/working_space.h"

namespace skywave {
namespace {

template <class T>
std::size_t BytesOf(const std::vector<T>& values) {
  return values.size() * sizeof(T);
}

std::size_t BytesOf(const Scene& scene) {
  std::size_t bytes = BytesOf(scene.instances);
  const auto add = [&](const std::vector<Mesh>& meshes) {
    for (const Mesh& mesh : meshes) {
      bytes += BytesOf(mesh.positions) + BytesOf(mesh.normals) + BytesOf(mesh.uvs) +
               BytesOf(mesh.second_uvs) + BytesOf(mesh.tangents) + BytesOf(mesh.colors) +
               BytesOf(mesh.alphas) + BytesOf(mesh.triangles);
    }
  };
  add(scene.meshes);
  for (const Object& object : scene.objects) add(object.meshes);
  for (const CompactImage& image : scene.images) bytes += image.bytes();
  for (const MeasuredBrdf& brdf : scene.measured) bytes += BytesOf(brdf.rgb);
  for (const EnvironmentLight& light : scene.environments) {
    if (light.map) bytes += BytesOf(light.map->rgb);
  }
  return bytes;
}

// Returns the words of the options of `request` for which `counts` is true.
template <class Counts>
std::string Words(const JobRequest& request, const Counts& counts) {
  std::string words;
  for (const JobOption& option : JobOptions()) {
    if (counts(option)) words += CommandWords(option, request);
  }
  return words;
}

// Returns those of the options that change any of `tables`.
std::string WordsOf(const JobRequest& request, std::uint32_t tables) {
  return Words(request, [&](const OptionInfo& option) { return (option.changes & tables) != 0; });
}

// Returns a text that changes when a file is written anew; so does what was made of it.
std::string Stamp(const std::string& name) {
  const std::string path = SplitFileName(name).path;
  std::error_code error;
  const auto time = std::filesystem::last_write_time(path, error);
  if (error) return Quoted(name);
  return fmt::format("{} of {} bytes at {}", Quoted(name), std::filesystem::file_size(path, error),
                     time.time_since_epoch().count());
}

// Luminance of the light that a map sends through the disk of a sphere around the scene.
double EnvironmentPower(double mean_luminance, float radius) {
  constexpr double kPi = std::numbers::pi;
  return 4 * kPi * mean_luminance * kPi * double(radius) * radius;
}

// Returns the largest of finite numbers that are not negative, in lanes that do not wait for each
// other.
float Brightest(const std::vector<float>& values) {
  std::array<float, 12> lanes = {};
  for (std::size_t i = 0; i < values.size(); i += lanes.size()) {
    const std::size_t count = std::min(lanes.size(), values.size() - i);
    for (std::size_t k = 0; k < count; ++k) lanes[k] = std::max(lanes[k], values[i + k]);
  }
  return *std::max_element(lanes.begin(), lanes.end());
}

// Copies the meshes of shared objects that shine now: materials may have changed since the scene
// was read, and only what stands in the world is a lamp.
void CopyNewLamps(const JobRequest& request, Scene& scene) {
  if (scene.instances.empty()) return;
  ReadOptions read = request.read;
  read.instances = InstanceUse::kShare;
  ResolveInstances(read, request.scene, scene);
}

PreparedScene PrepareScene(const std::shared_ptr<const LoadedScene>& loaded,
                           const JobRequest& request) {
  PreparedScene prepared = {.scene = {loaded, &loaded->scene}};
  const bool changes = !WordsOf(request, Tables::kPrepared).empty();
  if (!changes) prepared.bounds = SceneBounds(loaded->scene, request.scene);
  prepared.whole_bounds = prepared.bounds;
  if (changes) {
    auto scene = std::make_shared<Scene>(loaded->scene);
    AddPortals(request.portals, *scene);
    prepared.bounds = prepared.whole_bounds = SceneBounds(*scene, request.scene);
    ChangeMaterials(request.materials, *scene);
    CopyNewLamps(request, *scene);
    if (!request.energy_compensation) LeaveOutCompensation(*scene);
    scene->up_axis = request.environment.up_axis.value_or(scene->up_axis);
    if (request.ground != Ground::kNone) {
      AddGround(*scene, scene->first_bounds.value_or(prepared.bounds));
      prepared.whole_bounds = SceneBounds(*scene, request.scene);
    }
    ConvertScene(request.working_space, *scene);
    if (request.ground == Ground::kCatcher) scene->materials.back().catcher = true;
    Mark("catcher", request.catchers, FlagOf(&Material::catcher), *scene);
    Mark("holdout", request.holdouts, FlagOf(&Material::holdout), *scene);
    MarkLinks(request, *scene);
    prepared.copy_bytes = BytesOf(*scene);
    prepared.scene = std::move(scene);
  }
  prepared.placing_bounds = prepared.scene->first_bounds.value_or(prepared.bounds);
  prepared.content = SceneHashContent(*prepared.scene);
  return prepared;
}

// Returns the number of threads for Embree's device: 0, all of the machine, unless there is a
// limit, because Embree holds the whole process to any other number as long as the device lives.
int EmbreeThreads(int threads) {
  return threads == 0 && GrantedHere().limits_threads() ? GrantedHere().threads : threads;
}

std::array<float, 9> Rows(const glm::mat3& columns) {
  std::array<float, 9> rows;
  for (int i = 0; i < 9; ++i) rows[std::size_t(i)] = columns[i / 3][i % 3];
  return rows;
}

}  // namespace

std::string SceneKey(const JobRequest& request) {
  return "scene " + Quoted(request.scene) + Words(request, [](const OptionInfo& option) {
           return option.of_reading && option.name != "frame";
         });
}

// The cache of all shared scenes, for as long as there are any.
std::shared_ptr<JobCache> CacheOfProcess() {
  static std::mutex mutex;
  static std::weak_ptr<JobCache> shared;
  const std::lock_guard lock(mutex);
  std::shared_ptr<JobCache> cache = shared.lock();
  if (!cache) {
    constexpr std::uint64_t kMost = std::uint64_t{2} << 30;
    cache = std::make_shared<JobCache>(std::min(kMost, GrantedHere().memory_bytes / 10));
    shared = cache;
  }
  return cache;
}

SharedScene::SharedScene(std::shared_ptr<const LoadedScene> loaded)
    : loaded_(std::move(loaded)), cache_(CacheOfProcess()) {
  static std::atomic<std::uint64_t> scenes = 0;
  key_ = fmt::format("scene in memory {};", ++scenes);
}

SharedScene::~SharedScene() { cache_->Forget(key_); }

std::size_t LoadedScene::bytes() const { return BytesOf(scene); }
std::size_t LoadedLight::bytes() const { return BytesOf(light.map->rgb); }
std::size_t PlacedMap::bytes() const { return BytesOf(map.latlong->rgb); }

template <class T, class Make>
std::shared_ptr<const T> JobParts::Get(const std::string& key, const Make& make) const {
  if (cache_ == nullptr) return make();
  return cache_->Get<T>(key, make);
}

JobParts::JobParts(const JobRequest& request, JobCache* cache) : cache_(cache) {
  std::shared_ptr<const LoadedScene> made;
  const auto read = [&] {
    if (!made) made = std::make_shared<LoadedScene>(ReadScene(request.scene, request.read));
    return made;
  };
  scene_key_ = SceneKey(request);
  // All frames of a scene that has no animation are one.
  if (cache != nullptr && request.read.frame) {
    const auto motion = Get<SceneMotion>(scene_key_ + " motion", [&] {
      return std::make_shared<SceneMotion>(!read()->scene.animations.empty());
    });
    if (motion->moves) scene_key_ += fmt::format(" at {}", *request.read.frame);
  }
  loaded_ = Get<LoadedScene>(scene_key_, read);
}

JobParts::JobParts(const SharedScene& scene)
    : cache_(scene.cache_.get()), shared_(&scene), scene_key_(scene.key_), loaded_(scene.loaded_) {}

void JobParts::Prepare(const JobRequest& request) {
  JobRequest changes = request;
  if (changes.environment.up_axis == loaded().up_axis) changes.environment.up_axis.reset();
  prepared_key_ = scene_key_ + " prepared" + WordsOf(changes, Tables::kPrepared);
  prepared_ = Get<PreparedScene>(prepared_key_, [&] {
    return std::make_shared<PreparedScene>(PrepareScene(loaded_, changes));
  });
}

// A map that is asked for is the same however it is turned; the lights of a scene are turned before
// they are summed.
std::string JobParts::MapKey(const JobRequest& request) const {
  const EnvironmentRequest& environment = request.environment;
  if (environment.has_map()) {
    const std::string map = environment.path.empty()
                                ? fmt::format("{:016x}", environment.image_hash)
                                : Stamp(MapFile(request));
    return "map " + map + WordsOf(request, Tables::kMap);
  }
  std::string key = prepared_key_ + " lights" + WordsOf(request, Tables::kSceneLights);
  for (const EnvironmentLight& light : prepared_->scene->environments) {
    if (!light.map_path.empty()) key += " " + Stamp(light.map_path);
  }
  return key;
}

std::shared_ptr<const LoadedLight> JobParts::Light(const JobRequest& request) const {
  return Get<LoadedLight>(MapKey(request), [&] {
    auto loaded = std::make_shared<LoadedLight>();
    loaded->light = LoadEnvironment(*prepared_->scene, request, loaded->notes);
    const Image& map = *loaded->light.map;
    loaded->hash = MapHash(map);
    loaded->brightest = Brightest(map.rgb);
    const std::array<double, 3> mean = SphereMean(map);
    for (std::size_t c = 0; c < 3; ++c) loaded->mean_luminance += double(kLuminance[c]) * mean[c];
    return loaded;
  });
}

std::string JobParts::GeometryKey(const JobRequest& request, int threads) const {
  return fmt::format("{} geometry{} {} {}", prepared_key_, WordsOf(request, Tables::kBvh), threads,
                     NeedsUvs(request.options.aovs));
}

std::shared_ptr<const BuiltGeometry> JobParts::Build(const JobRequest& request) const {
  const int threads = EmbreeThreads(request.options.threads);
  // Scenes that differ in materials alone may share a BVH.
  const auto last = Get<LastMade<BuiltGeometry>>(
      fmt::format("{} triangles{} {}", scene_key_,
                  WordsOf(request, Tables::kTriangles | Tables::kBvh), threads),
      [] { return std::make_shared<LastMade<BuiltGeometry>>(); });
  const auto geometry = Get<BuiltGeometry>(GeometryKey(request, threads), [&] {
    const std::shared_ptr<const BuiltGeometry> twin = last->get();
    const std::shared_ptr<const BuiltGeometry> built(new BuiltGeometry{
        Geometry(*prepared_->scene, request.scene, threads, request.embree_config,
                 NeedsUvs(request.options.aovs),
                 twin ? std::shared_ptr<const Geometry>(twin, &twin->geometry) : nullptr)});
    // One that shares would keep the whole row of those before it.
    if (built->geometry.bvh_bytes() > 0) last->Set(built);
    return built;
  });
  if (shared_ != nullptr) {
    const std::lock_guard lock(shared_->mutex_);
    shared_->geometry_ = geometry;
  }
  return geometry;
}

// The map takes part in the choice between the lamps.
std::string JobParts::LampsKey(const JobRequest& request, const LoadedLight& light) const {
  return fmt::format("{} lamps beside {}", GeometryKey(request, 0), light.mean_luminance);
}

std::shared_ptr<const BuiltLamps> JobParts::Lamps(
    const JobRequest& request, const LoadedLight& light,
    const std::shared_ptr<const BuiltGeometry>& geometry) const {
  const Scene& scene = *prepared_->scene;
  if (!HasLocalLights(scene)) return std::make_shared<BuiltLamps>();
  return Get<BuiltLamps>(LampsKey(request, light), [&] {
    const float radius = BoundingRadius(prepared_->bounds);
    return std::make_shared<BuiltLamps>(
        BuiltLamps{geometry, LocalLights(scene, geometry->geometry, request.scene, radius,
                                         EnvironmentPower(light.mean_luminance, radius))});
  });
}

std::shared_ptr<const BuiltLightTree> JobParts::TreeOfLamps(const JobRequest& request,
                                                            const LoadedLight& light,
                                                            const LocalLights& lamps) const {
  const bool asked = request.options.light_selection == LightSelection::kTree;
  if (!asked || lamps.view().count == 0) return nullptr;
  return Get<BuiltLightTree>(LampsKey(request, light) + " tree", [&] {
    return std::make_shared<BuiltLightTree>(LightTree(lamps, *prepared_->scene));
  });
}

glm::mat3 JobParts::WorldFromMap(const JobRequest& request, const LoadedLight& light) const {
  if (!request.environment.has_map()) return light.light.world_from_map;
  const Scene& scene = *prepared_->scene;
  return EnvironmentFrame(scene.up_axis, scene.left_handed, request.environment.rotation_degrees);
}

std::string JobParts::PlacedKey(const JobRequest& request, const LoadedLight& light) const {
  const std::array<float, 9> rows = Rows(WorldFromMap(request, light));
  const bool portals = !prepared_->scene->portals.empty();
  return fmt::format("{} placed {}{}", MapKey(request), fmt::join(rows, " "),
                     portals ? " portals of " + prepared_key_ : "");
}

std::shared_ptr<const PlacedMap> JobParts::Place(
    const JobRequest& request, const std::shared_ptr<const LoadedLight>& light) const {
  return Get<PlacedMap>(PlacedKey(request, *light), [&] {
    const std::shared_ptr<const Image> image(light, &*light->light.map);
    return std::make_shared<PlacedMap>(
        PlacedMap{{.latlong = SharedImage(image),
                   .map_from_world = Rows(WorldFromMap(request, *light)),
                   .portals = prepared_->scene->portals}});
  });
}

std::shared_ptr<const StrategyTables> JobParts::Tables(
    const JobRequest& request, const std::string& specification, const StrategyUse& use,
    const LoadedLight& light, const std::shared_ptr<const PlacedMap>& map) const {
  std::string key = fmt::format(" strategy {} {} {} {}", specification, use.mis, use.light_samples,
                                use.starts_light_paths);
  for (const std::string& file : FilesOfStrategy(specification)) key += " " + Stamp(file);
  // Orientations of a map share tables that do not depend on them.
  const auto last = Get<LastMade<StrategyTables>>(
      MapKey(request) + key, [] { return std::make_shared<LastMade<StrategyTables>>(); });
  return Get<StrategyTables>(PlacedKey(request, light) + key, [&] {
    const std::shared_ptr<const StrategyTables> twin = last->get();
    std::unique_ptr<const EnvStrategy> strategy = twin ? twin->strategy->Turned(map->map) : nullptr;
    if (!strategy) strategy = MakeStrategy(specification, map->map, use);
    const auto tables =
        std::make_shared<const StrategyTables>(StrategyTables{map, std::move(strategy)});
    last->Set(tables);
    return tables;
  });
}

std::shared_ptr<const MapIrradiance> JobParts::Irradiance(const JobRequest& request,
                                                          const LoadedLight& light,
                                                          const PlacedMap& map) const {
  return Get<MapIrradiance>(PlacedKey(request, light) + " irradiance", [&] {
    return std::make_shared<MapIrradiance>(MapIrradiance{VectorIrradiance(map.map)});
  });
}

}  // namespace skywave
