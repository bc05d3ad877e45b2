#include "job/job_parts.h"

#include <fmt/format.h>

#include <algorithm>
#include <span>
#include <string_view>
#include <utility>

#include "job/environment.h"
#include "job/map_sequence.h"
#include "job/material_changes.h"
#include "job/options.h"
#include "job/portals.h"
#include "lights/maps/environment_map.h"
#include "scene/instances.h"
#include "scene/reader.h"
#include "scene/shapes/ground.h"

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
               BytesOf(mesh.tangents) + BytesOf(mesh.colors) + BytesOf(mesh.triangles);
    }
  };
  add(scene.meshes);
  for (const Object& object : scene.objects) add(object.meshes);
  for (const Image& image : scene.images) bytes += BytesOf(image.rgb);
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

std::string WordsOf(const JobRequest& request, std::span<const std::string_view> names) {
  return Words(request, [&](const OptionInfo& option) {
    return std::find(names.begin(), names.end(), option.name) != names.end();
  });
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
  const char up_axis = request.environment.up_axis.value_or(loaded->scene.up_axis);
  const bool changes = !request.materials.empty() || !request.energy_compensation ||
                       !request.portals.empty() || request.ground ||
                       up_axis != loaded->scene.up_axis;
  if (!changes) prepared.bounds = SceneBounds(loaded->scene, request.scene);
  prepared.whole_bounds = prepared.bounds;
  if (changes) {
    auto scene = std::make_shared<Scene>(loaded->scene);
    AddPortals(request.portals, *scene);
    prepared.bounds = prepared.whole_bounds = SceneBounds(*scene, request.scene);
    ChangeMaterials(request.materials, *scene);
    CopyNewLamps(request, *scene);
    if (!request.energy_compensation) LeaveOutCompensation(*scene);
    scene->up_axis = up_axis;
    if (request.ground) {
      AddGround(*scene, prepared.bounds);
      prepared.whole_bounds = SceneBounds(*scene, request.scene);
    }
    prepared.copy_bytes = BytesOf(*scene);
    prepared.scene = std::move(scene);
  }
  prepared.content = SceneHashContent(*prepared.scene);
  return prepared;
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

std::size_t LoadedScene::bytes() const { return BytesOf(scene); }
std::size_t LoadedLight::bytes() const { return BytesOf(light.map->rgb); }
std::size_t PlacedMap::bytes() const { return BytesOf(map.latlong.rgb); }

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

JobParts::JobParts(Scene scene)
    : cache_(nullptr), loaded_(std::make_shared<LoadedScene>(std::move(scene))) {}

void JobParts::Prepare(const JobRequest& request) {
  static constexpr std::string_view kChanges[] = {"material", "energy-compensation", "portal",
                                                  "ground", "env-up"};
  prepared_key_ = scene_key_ + " prepared" + WordsOf(request, kChanges);
  prepared_ = Get<PreparedScene>(prepared_key_, [&] {
    return std::make_shared<PreparedScene>(PrepareScene(loaded_, request));
  });
}

// A map in a file is the same however it is turned; the lights of a scene are turned before they
// are summed.
std::string JobParts::MapKey(const JobRequest& request) const {
  static constexpr std::string_view kOfMap[] = {"env-projection", "env-intensity", "trust-input"};
  static constexpr std::string_view kOfLights[] = {"env-rotate", "env-projection", "env-intensity",
                                                   "trust-input"};
  if (!request.environment.path.empty()) {
    return "map " + Quoted(MapFile(request)) + WordsOf(request, kOfMap);
  }
  return prepared_key_ + " lights" + WordsOf(request, kOfLights);
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

std::shared_ptr<const BuiltGeometry> JobParts::Build(const JobRequest& request, int threads) const {
  const bool uvs = NeedsUvs(request.options.aovs);
  const std::string key = fmt::format("{} geometry {} {} {}", prepared_key_,
                                      Quoted(request.embree_config), threads, uvs);
  static constexpr std::string_view kOfTriangles[] = {"ground", "env-up"};
  const auto last =
      Get<LastBuilt>(fmt::format("{} triangles{} {} {}", scene_key_, WordsOf(request, kOfTriangles),
                                 Quoted(request.embree_config), threads),
                     [] { return std::make_shared<LastBuilt>(); });
  return Get<BuiltGeometry>(key, [&] {
    std::shared_ptr<const BuiltGeometry> twin;
    {
      const std::lock_guard lock(last->mutex);
      twin = last->geometry.lock();
    }
    const std::shared_ptr<const BuiltGeometry> built(new BuiltGeometry{
        Geometry(*prepared_->scene, request.scene, threads, request.embree_config, uvs,
                 twin ? std::shared_ptr<const Geometry>(twin, &twin->geometry) : nullptr)});
    // One that shares would keep the whole row of those before it.
    if (built->geometry.bvh_bytes() > 0) {
      const std::lock_guard lock(last->mutex);
      last->geometry = built;
    }
    return built;
  });
}

glm::mat3 JobParts::WorldFromMap(const JobRequest& request, const LoadedLight& light) const {
  if (request.environment.path.empty()) return light.light.world_from_map;
  const Scene& scene = *prepared_->scene;
  return EnvironmentFrame(scene.up_axis, scene.left_handed, request.environment.rotation_degrees);
}

std::string JobParts::PlacedKey(const JobRequest& request, const LoadedLight& light) const {
  const std::array<float, 9> rows = Rows(WorldFromMap(request, light));
  const bool portals = !prepared_->scene->portals.empty();
  return fmt::format("{} placed {}{}", MapKey(request), fmt::join(rows, " "),
                     portals ? " portals of " + prepared_key_ : "");
}

std::shared_ptr<const PlacedMap> JobParts::Place(const JobRequest& request,
                                                 const LoadedLight& light) const {
  return Get<PlacedMap>(PlacedKey(request, light), [&] {
    return std::make_shared<PlacedMap>(
        PlacedMap{{.latlong = *light.light.map,
                   .map_from_world = Rows(WorldFromMap(request, light)),
                   .portals = prepared_->scene->portals}});
  });
}

std::shared_ptr<const StrategyTables> JobParts::Tables(
    const JobRequest& request, const std::string& specification, const StrategyUse& use,
    const LoadedLight& light, const std::shared_ptr<const PlacedMap>& map) const {
  const std::string key =
      fmt::format("{} strategy {} {} {} {}", PlacedKey(request, light), specification, use.mis,
                  use.light_samples, use.starts_light_paths);
  return Get<StrategyTables>(key, [&] {
    return std::make_shared<StrategyTables>(
        StrategyTables{map, MakeStrategy(specification, map->map, use)});
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
