// Everything that a frame needs, put together from a request: a FrameView and the objects that it
// points into.
#pragma once

#include <memory>
#include <string>
#include <vector>

#include "job/job_parts.h"
#include "job/links.h"
#include "job/motion.h"
#include "job/projection.h"
#include "job/request.h"
#include "lights/strategies/strategy.h"
#include "scene/geometry.h"
#include "scene/local_lights.h"
#include "scene/scene.h"
#include "wavefront/film/film.h"
#include "wavefront/film/light_groups.h"
#include "wavefront/frame.h"
#include "wavefront/policies/control_pilot.h"

namespace skywave {

struct JobTimes {
  double load = 0, build = 0, tables = 0;  // [s] scene and map read, BVH built, strategy built
};

// An integrator, the strategy of its camera paths, and that with which its light paths start.
struct RenderMethod {
  Integrator integrator = Integrator::kPath;
  std::unique_ptr<const EnvStrategy> strategy;
  // Null where `strategy` itself can emit (CanEmit), and where no light path starts at the map.
  std::unique_ptr<const EnvStrategy> emitter;
};

class RenderJob {
 public:
  // Reads, checks and builds; throws InputError. No file is touched for writing. What jobs have in
  // common comes from `cache`, if there is one.
  explicit RenderJob(const JobRequest& request, JobCache* cache = nullptr);
  // The same for a scene that is in memory already; `request.scene` only names it in errors. What
  // has been made of the scene for other jobs is not made again. `load_seconds` is the time that
  // reading it took.
  RenderJob(const SharedScene& scene, const JobRequest& request, double load_seconds = 0);
  // The same for a scene of this job alone.
  RenderJob(Scene scene, const JobRequest& request);

  FrameView frame() const {
    return frame(options().integrator, strategy(), emitter_ ? emitter_->strategy.get() : nullptr);
  }
  // The same scene by another method, which has to outlive the view.
  FrameView frame(const RenderMethod& method) const {
    return frame(method.integrator, *method.strategy, method.emitter.get());
  }
  // The film keeps `layers` in addition to those of the options.
  Film MakeFilm(AovSet layers = 0) const { return MakeFilm(options().integrator, layers); }
  FilmLayout LayoutOfFilm(Integrator integrator, AovSet layers = 0) const;
  Film MakeFilm(Integrator integrator, AovSet layers = 0) const;
  // A method for the same map; it must not outlive the job. Throws InputError like the constructor
  // where the strategy is not made for these options and `integrator`, or that not for the scene.
  RenderMethod MakeMethod(const std::string& specification, Integrator integrator) const;
  const RenderOptions& options() const { return request_.options; }
  // The request with a value for every option (ResolveRequest).
  const JobRequest& request() const { return request_; }
  const Geometry& geometry() const { return geometry_->geometry; }
  const EnvStrategy& strategy() const { return *strategy_->strategy; }
  const LocalLights& local_lights() const { return local_lights_->lights; }
  const JobTimes& times() const { return times_; }
  // The names of meshes and materials, by their numbers; null: no layer has numbers or mattes.
  const Mattes* names() const { return names_.get(); }
  std::uint64_t scene_hash() const { return scene_hash_; }
  std::uint64_t map_hash() const { return map_hash_; }  // of the illumination map alone
  // One line each, for the user: what is not rendered as the scene file asks,
  const std::vector<std::string>& warnings() const { return warnings_; }
  // and what was repaired or assumed.
  const std::vector<std::string>& notes() const { return notes_; }

 private:
  void Build(JobParts parts, const JobRequest& request);
  // The steps of Build, in their order.
  void PlanComposites(const Scene& scene);
  void PlaceCamera(const PreparedScene& prepared);
  void PlaceLights(const JobParts& parts, const LoadedLight& light);
  void BuildStrategies(const JobParts& parts, const std::shared_ptr<const LoadedLight>& light);
  void PlaceProjection(const JobParts& parts, const LoadedLight& light);
  bool has_environment() const;
  bool NeedsEmitter(Integrator integrator, const EnvStrategy& strategy) const;
  FrameView frame(Integrator integrator, const EnvStrategy& strategy,
                  const EnvStrategy* emitter) const;
  void CheckLightPaths(Integrator integrator) const;

  JobRequest request_;  // resolved
  std::shared_ptr<const BuiltGeometry> geometry_;
  std::shared_ptr<const PlacedMap> map_;  // strategies read its pixels
  std::shared_ptr<const BuiltLamps> local_lights_;
  std::shared_ptr<const BuiltLightTree> light_tree_;  // where it is asked for
  LightGroups light_groups_;                          // where they are asked for
  std::shared_ptr<const Mattes> names_;               // of meshes and materials, likewise
  std::vector<std::uint8_t> object_lamps_;            // FrameView::object_lamps
  LightLinks links_;                                  // where there are some
  std::shared_ptr<const StrategyTables> strategy_, continuation_strategy_;
  std::shared_ptr<const MapIrradiance> irradiance_;  // where there is a control variate
  ControlView control_;                              // that frames show, if there is irradiance_
  std::shared_ptr<const ProjectedPlace> place_;      // null: nothing is projected
  FrameMotion motion_;                               // where layers ask for it
  std::shared_ptr<const StrategyTables> emitter_;    // of light paths; null: `strategy_` can emit
  std::vector<float> filter_offsets_, filter_densities_, filter_factors_;
  Camera scene_camera_;
  CameraView camera_;
  SceneSphere sphere_;
  float beside_ = 0;        // Tracer::beside
  float brightest_ = 0;     // channel of map and local lights [scene radiance]
  float world_extent_ = 0;  // no point that the camera sees is farther from it or from the origin
  std::uint64_t scene_hash_ = 0, map_hash_ = 0;
  JobTimes times_;
  std::vector<std::string> warnings_, notes_;
};

}  // namespace skywave
