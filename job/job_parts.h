// The parts that a job is put together from, which jobs of the same scene or map can share.
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <memory>
#include <mutex>
#include <string>
#include <utility>
#include <vector>

#include "job/job_cache.h"
#include "job/request.h"
#include "lights/strategies/strategy.h"
#include "lights/tables/vector_irradiance.h"
#include "scene/geometry.h"
#include "scene/light_tree.h"
#include "scene/local_lights.h"
#include "scene/scene.h"
#include "scene/scene_hash.h"

namespace skywave {

// Returns a text that names the scene of a request and how it is read, whatever the frame.
std::string SceneKey(const JobRequest& request);

// Whether a scene has animations.
struct SceneMotion {
  explicit SceneMotion(bool does) : moves(does) {}
  bool moves;
  std::size_t bytes() const { return sizeof(*this); }
};

// A scene as it was read.
struct LoadedScene {
  explicit LoadedScene(Scene read) : scene(std::move(read)) {}
  Scene scene;
  std::size_t bytes() const;
};

// A scene as a request changes it: other materials, another up axis, a ground.
struct PreparedScene {
  std::shared_ptr<const Scene> scene;
  Bounds bounds;               // without the ground
  Bounds placing_bounds;       // where an animation begins: they place ground and cameras
  Bounds whole_bounds;         // with it
  SceneHashContent content;    // of the hash of its pictures
  std::size_t copy_bytes = 0;  // of the scene, unless it is that of a LoadedScene
  std::size_t bytes() const { return copy_bytes; }
};

// The tables and the BVH of a prepared scene.
struct BuiltGeometry {
  Geometry geometry;
  std::size_t bytes() const { return geometry.bytes() + geometry.bvh_bytes(); }
};

// The light from infinitely far away, as a map in memory.
struct LoadedLight {
  EnvironmentLight light;  // with a map
  std::vector<std::string> notes;
  std::uint64_t hash = 0;  // of the map
  double mean_luminance = 0;
  float brightest = 0;  // channel
  std::size_t bytes() const;
};

// A map as it lies in the world. It counts as having the image by itself, which all orientations
// share, because it may be the last that has it; so do tables of strategies.
struct PlacedMap {
  EnvironmentMap map;
  std::size_t bytes() const;
};

// The tables of a strategy for a map.
struct StrategyTables {
  std::shared_ptr<const PlacedMap> map;
  std::unique_ptr<const EnvStrategy> strategy;
  std::size_t bytes() const { return strategy->table_bytes(); }
};

// What was made last of something, as long as somebody has it: what is made next may share it.
template <class Made>
struct LastMade {
  mutable std::mutex mutex;
  mutable std::weak_ptr<const Made> made;  // of `mutex`
  std::shared_ptr<const Made> get() const {
    const std::lock_guard lock(mutex);
    return made.lock();
  }
  void Set(const std::shared_ptr<const Made>& now) const {
    const std::lock_guard lock(mutex);
    made = now;
  }
  std::size_t bytes() const { return sizeof(*this); }
};

// The irradiance of a map on surfaces from which nothing hides it.
struct MapIrradiance {
  VectorIrradiance table;
  std::size_t bytes() const { return table.bytes(); }
};

// The lights of a scene that stand in it. They read tables of the geometry.
struct BuiltLamps {
  std::shared_ptr<const BuiltGeometry> geometry;
  LocalLights lights;
  std::size_t bytes() const { return lights.bytes(); }
};

// The tree over them, and what stages read of it.
struct BuiltLightTree {
  explicit BuiltLightTree(LightTree built) : tree(std::move(built)), view(tree.view()) {}
  LightTree tree;
  LightTreeView view;
  std::size_t bytes() const { return tree.bytes(); }
};

// A scene in memory, and what jobs have made of it for each other. Threads may share it. Maps and
// their tables are shared with the jobs of all other such scenes of the process.
class SharedScene {
 public:
  // Nobody may change the scene any more.
  explicit SharedScene(std::shared_ptr<const LoadedScene> loaded);
  ~SharedScene();  // what is kept of the scene goes, unless a job needs it
  SharedScene(const SharedScene&) = delete;
  SharedScene& operator=(const SharedScene&) = delete;

 private:
  friend class JobParts;
  std::shared_ptr<const LoadedScene> loaded_;
  std::string key_;  // what is kept of this scene begins with it
  std::shared_ptr<JobCache> cache_;
  // The last one, whatever the cache drops: as long as there is the scene there is its BVH.
  mutable std::mutex mutex_;  // of `geometry_`
  mutable std::shared_ptr<const BuiltGeometry> geometry_;
};

// Makes the parts of one job, or gets them from a cache that has them already.
class JobParts {
 public:
  // Reads the scene of `request`. Without a cache all parts are made anew.
  JobParts(const JobRequest& request, JobCache* cache);
  // Takes a scene that is in memory, which has to outlive the parts.
  explicit JobParts(const SharedScene& scene);

  const Scene& loaded() const { return loaded_->scene; }
  // Returns the parts of the scene's file at another frame, with the same cache; `request` is that
  // of the frame. Throws InputError, also if the scene is not in a file.
  JobParts AtFrame(const JobRequest& request) const { return {request, cache_}; }

  // These take a resolved request and throw InputError. Prepare comes first.
  void Prepare(const JobRequest& request);
  const PreparedScene& prepared() const { return *prepared_; }
  std::shared_ptr<const LoadedLight> Light(const JobRequest& request) const;
  std::shared_ptr<const BuiltGeometry> Build(const JobRequest& request) const;
  std::shared_ptr<const BuiltLamps> Lamps(
      const JobRequest& request, const LoadedLight& light,
      const std::shared_ptr<const BuiltGeometry>& geometry) const;
  // Null where there is no lamp, or where no tree is asked for.
  std::shared_ptr<const BuiltLightTree> TreeOfLamps(const JobRequest& request,
                                                    const LoadedLight& light,
                                                    const LocalLights& lamps) const;
  std::shared_ptr<const PlacedMap> Place(const JobRequest& request,
                                         const std::shared_ptr<const LoadedLight>& light) const;
  std::shared_ptr<const StrategyTables> Tables(const JobRequest& request,
                                               const std::string& specification,
                                               const StrategyUse& use, const LoadedLight& light,
                                               const std::shared_ptr<const PlacedMap>& map) const;

  std::shared_ptr<const MapIrradiance> Irradiance(const JobRequest& request,
                                                  const LoadedLight& light,
                                                  const PlacedMap& map) const;

  // Returns the columns of the orientation of the light in the world.
  glm::mat3 WorldFromMap(const JobRequest& request, const LoadedLight& light) const;

 private:
  // Returns the part with the key, made by `make` unless the cache has it.
  template <class T, class Make>
  std::shared_ptr<const T> Get(const std::string& key, const Make& make) const;
  std::string GeometryKey(const JobRequest& request, int threads) const;
  std::string LampsKey(const JobRequest& request, const LoadedLight& light) const;
  std::string MapKey(const JobRequest& request) const;
  std::string PlacedKey(const JobRequest& request, const LoadedLight& light) const;

  JobCache* cache_;
  const SharedScene* shared_ = nullptr;
  std::string scene_key_, prepared_key_;
  std::shared_ptr<const LoadedScene> loaded_;
  std::shared_ptr<const PreparedScene> prepared_;
};

}  // namespace skywave
