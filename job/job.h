// Everything a frame needs, put together: from a scene and the user's wishes to a FrameView whose
// parts it owns.
#pragma once

#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "lights/strategies/strategy.h"
#include "scene/geometry.h"
#include "scene/local_lights.h"
#include "scene/read_options.h"
#include "scene/scene.h"
#include "wavefront/film/film.h"
#include "wavefront/frame.h"
#include "wavefront/option_names.h"

namespace skywave {

// Deepest path: the pairs of dimensions of its random numbers fit in a block (kernels/sampler.h).
inline constexpr std::uint32_t kMaxDepth = 16384;

// The map of the command line and how it lies in the world.
struct EnvironmentRequest {
  std::string path;                      // empty: the scene's own light
  std::optional<Projection> projection;  // unset: by shape, see DetectProjection
  float rotation_degrees = 0;            // counter-clockwise about the up axis, seen from above
  float intensity = 1;
  std::optional<char> up_axis;  // unset: the scene's
  ReadLimits limits;
};

// What flags say of the camera; unset values are those of the scene's or of the automatic one.
struct CameraRequest {
  std::optional<CameraKind> kind;
  std::optional<glm::vec3> eye, target;  // target: the middle of the scene if only the eye is given
  std::optional<float> fov_degrees;
  std::optional<float> lens_radius;     // world space
  std::optional<float> focal_distance;  // world space; unset: the middle of the scene is sharp
};

// What the user asked for; unset values come from the scene, then from RenderOptions.
struct JobRequest {
  std::string scene;    // file or built-in scene
  bool ground = false;  // a plane under the scene
  ReadOptions read;
  EnvironmentRequest environment;
  CameraRequest camera;
  std::string strategy = "importance";
  std::string continuation_strategy;  // where paths split; empty: the same
  std::string embree_config;
  std::optional<int> width, height;
  std::optional<CropWindow> crop;
  std::optional<Integrator> integrator;
  std::optional<std::uint32_t> samples_per_pixel, max_depth;
  std::optional<PixelFilter> filter;
  RenderOptions options;  // everything that a scene does not say
};

// Points of a pixel's sequence that one of its samples can use up; with the number of samples they
// must stay below 2^32.
std::uint32_t MostPointsOfASample(const RenderOptions& options);

struct JobTimes {
  double load = 0, build = 0, tables = 0;  // [s] scene and map read, BVH built, strategy built
};

class RenderJob {
 public:
  // Reads, checks and builds; throws InputError. No file is touched for writing.
  explicit RenderJob(const JobRequest& request);
  // The same for a scene that is in memory already; `request.scene` only names it in errors.
  RenderJob(Scene scene, const JobRequest& request);

  FrameView frame() const { return frame(options_.integrator, *strategy_); }
  Film MakeFilm() const { return MakeFilm(options_.integrator); }
  // The same scene by another integrator and strategy, the job's own or one of MakeOtherStrategy
  // for it. Where light paths start, that strategy or the job's can emit (CanEmit).
  FrameView frame(Integrator integrator, const EnvStrategy& strategy) const;
  Film MakeFilm(Integrator integrator) const;
  // A strategy for the same map; it must not outlive the job. Throws InputError like the
  // constructor where it is not made for these options and `integrator`, or that not for the scene.
  std::unique_ptr<EnvStrategy> MakeOtherStrategy(const std::string& specification,
                                                 Integrator integrator) const;
  const RenderOptions& options() const { return options_; }
  const Geometry& geometry() const { return *geometry_; }
  const EnvStrategy& strategy() const { return *strategy_; }
  const LocalLights& local_lights() const { return local_lights_; }
  const JobTimes& times() const { return times_; }
  std::uint64_t scene_hash() const { return scene_hash_; }
  // What was not understood, repaired or assumed; one line each, for the user.
  const std::vector<std::string>& notes() const { return notes_; }

 private:
  void BuildOnThreads(Scene scene, const JobRequest& request);
  void Build(Scene scene, const JobRequest& request);
  bool has_environment() const;
  void CheckLightPaths(Integrator integrator) const;

  RenderOptions options_;
  std::unique_ptr<Geometry> geometry_;
  EnvironmentMap map_;  // strategies read its pixels
  LocalLights local_lights_;
  LightGroups light_groups_;  // where they are asked for
  std::unique_ptr<EnvStrategy> strategy_, continuation_strategy_;
  std::unique_ptr<EnvStrategy> emitter_;  // of light paths, for strategies that cannot emit
  std::vector<float> filter_offsets_, filter_densities_;
  CameraView camera_;
  SceneSphere sphere_;
  float brightest_ = 0;     // channel of map and local lights [scene radiance]
  float world_extent_ = 0;  // no point that the camera sees is farther from it or from the origin
  std::uint64_t scene_hash_ = 0;
  JobTimes times_;
  std::vector<std::string> notes_;
  std::string scene_name_;  // for errors
};

}  // namespace skywave
