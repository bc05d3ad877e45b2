// One picture to render: everything that all workers read and none writes.
#pragma once

#include <cstdint>
#include <optional>
#include <vector>

#include "kernels/bsdf/bsdf.h"
#include "kernels/camera.h"
#include "kernels/light_paths/bidirectional.h"
#include "kernels/light_paths/camera_connection.h"
#include "kernels/light_paths/emission.h"
#include "kernels/light_paths/photons.h"
#include "kernels/lights/local_lights.h"
#include "lights/strategies/strategy.h"
#include "scene/geometry.h"
#include "scene/scene.h"
#include "wavefront/film/aovs.h"
#include "wavefront/film/film_area.h"
#include "wavefront/film/filter.h"
#include "wavefront/integrator.h"
#include "wavefront/rays/trace.h"

namespace skywave {

// The number of vertices of a path that come from the light, which counts itself, and from the eye.
struct SubpathLengths {
  std::uint32_t light = 0, eye = 2;
};

struct EmissionGuide;
struct LightGroups;
struct PhotonMaps;
struct VirtualLights;
class IrradianceCache;

// Samples [first, end) of every pixel.
struct SampleRange {
  std::uint32_t first = 0, end = 0;
  std::uint32_t count() const { return end - first; }
  friend bool operator==(const SampleRange&, const SampleRange&) = default;
};

// Part of the lighting that is known analytically; only the residual is sampled.
enum class ControlVariate {
  kNone,
  kIrradiance  // that of the map on diffuse surfaces from which nothing hides it
};

// Options of photon mapping and of vertex connection and merging, whose light vertices count as
// indirect photons. As in pbrt, the counts are those of stored photons.
struct PhotonOptions {
  std::uint32_t indirect = 200000, caustic = 20000;
  std::uint32_t neighbors = 50;  // photons of a lookup, at most
  float distance = 0;            // largest of a lookup [world space]; 0: chosen by the photons
  PhotonKernel kernel = PhotonKernel::kEpanechnikov;
  // A surface sends this many rays of a final gather; 0: photons are looked up where it is seen.
  std::uint32_t gather = 1;
  // Several passes are progressive: each looks up everything within a radius that shrinks from pass
  // to pass. 0 means one pass, or one for each sample (IntegratorDescriptor::pass_each_sample).
  std::uint32_t passes = 0;
  float alpha = 2.0f / 3;  // how slowly the radius shrinks
  bool progressive() const { return passes > 1; }
};

// Options of virtual point lights.
struct VirtualLightOptions {
  std::uint32_t count = 64;  // of each sample, on average
  // Lights that are nearer than this shine as from there [world space]; negative: chosen by the
  // lights.
  float distance = -1;
};

// Options of the irradiance cache.
struct IrradianceCacheOptions {
  float accuracy = 0.2f;     // largest error of a record that counts (Ward's a)
  std::uint32_t rays = 256;  // of a record
};

struct RenderOptions {
  int width = 640, height = 480;        // size of the picture
  int film_width = 0, film_height = 0;  // 0: the picture is the whole film
  int crop_x = 0, crop_y = 0;           // the picture's top left corner in the film
  Integrator integrator = Integrator::kPath;
  std::uint32_t samples_per_pixel = 64;
  std::uint32_t first_sample = 0;  // samples [first_sample, first_sample + samples_per_pixel)
  // The samples of the whole picture, whose passes of photons are those of its parts too; empty:
  // these are all.
  SampleRange picture_samples;
  std::uint32_t max_depth = 5;      // surfaces at which a path scatters
  std::uint32_t light_samples = 1;  // per hit (LightSamples); paths that split: per first hit
  std::uint32_t split = 0;          // continuations of a path; 0: paths do not split
  bool mis = true;
  ControlVariate control = ControlVariate::kNone;
  std::optional<SubpathLengths> subpath_lengths;  // only these; unset: all
  std::uint32_t seed = 0;
  PixelFilter filter = PixelFilter::kBlackmanHarris;
  float filter_radius = 0;    // [pixels]; 0: the filter's own
  int threads = 0;            // 0: as many as the process may use
  std::uint32_t wave = 2048;  // rows
  Backend backend = Backend::kBest;
  AovSet aovs = 0;  // layers in addition to the picture
  // Light paths from the environment start where camera paths of a pilot needed them.
  bool guide = false;
  PhotonOptions photons;
  VirtualLightOptions virtual_lights;
  IrradianceCacheOptions irradiance_cache;
};

// Returns the samples that are rendered, and those of the whole picture that they are a part of.
SampleRange SamplesOf(const RenderOptions& options);
SampleRange PictureSamples(const RenderOptions& options);

// Returns how many light samples a hit takes, or the first hit of a path that splits.
inline std::uint32_t LightSamplesOf(const RenderOptions& options) {
  const LightSamples taken = Describe(options.integrator).light_samples;
  return taken == LightSamples::kRequested || options.split > 0 ? options.light_samples : 1;
}

// The light samples of a surface are those that the strategy plans. Each drawn sample goes to a
// local light or to the strategy, as `local` decides. If the strategy draws none, there are drawn
// samples for local lights alone.
struct LightShares {
  LightPlan plan;
  LightChoice local;      // share 0: there are no local lights
  float of_strategy = 1;  // its share of the drawn samples
  float strategy_samples(std::uint32_t requested) const { return float(requested) * of_strategy; }
};

// The const view that stages take. It lives as long as the objects that it points to.
struct FrameView {
  RenderOptions options;
  const Geometry* geometry;
  const EnvStrategy* strategy;
  const EnvStrategy* continuation_strategy;  // after the split; null: the same
  LocalLightView local_lights;
  CameraView camera;
  Tracer tracer;
  SceneSphere sphere = {};  // where light paths from infinity begin
  FilterView filter = {};   // for splats
  // Light paths start with `strategy`, or with importance if that cannot emit (LightPaths::kAny).
  const EnvStrategy* emitter = nullptr;
  const EnvironmentMap* map = nullptr;            // the map of both
  const EmissionGuide* guide = nullptr;           // null: light paths from the map start anywhere
  const PhotonMaps* photons = nullptr;            // those of the current pass
  const VirtualLights* virtual_lights = nullptr;  // those of the current pass
  const IrradianceCache* irradiance_cache = nullptr;
  float eta_vcm = 0;                          // that of the current pass, see MisTechniques
  const LightGroups* light_groups = nullptr;  // null: nobody asks for them
  IrradianceView irradiance = {};             // that of the map; without nodes: no control variate
  ControlWeightView control_weights = {};     // without weights: the control weighs 1 everywhere

  MisPolicy mis() const {
    return {.enabled = options.mis, .bsdf_samples = float(splits() ? options.split : 1)};
  }
  MisTechniques mis_techniques() const { return {.mis = mis(), .eta_vcm = eta_vcm}; }
  bool splits() const { return options.split > 0; }
  bool controls() const { return irradiance.nodes != nullptr; }
  bool weighs_control() const { return control_weights.weight != nullptr; }
  // True if light comes from beyond the scene; if not, the strategy is not used.
  bool has_environment() const { return local_lights.count == 0 || local_lights.shared.share < 1; }
  bool has_emitters() const { return local_lights.light_of_triangle != nullptr; }
  // Returns the first of the BSDFs whose rays can still bring light when no further surface is
  // shaded: under multiple importance sampling those of all BSDFs can, else those of mirrors and
  // glass.
  std::uint32_t first_bsdf_that_sees_light() const {
    const bool shines = has_emitters() || (has_environment() && strategy->shines_on_bsdf_samples());
    return (options.mis || options.subpath_lengths) && shines ? 0 : kFirstDeltaBsdf;
  }
  // Returns how many light samples a hit takes.
  std::uint32_t light_samples() const { return LightSamplesOf(options); }
  // Returns the frame in which continuations go on as paths that do not split again.
  FrameView of_continuations() const;
  LightShares light_shares() const;
  // True if the picture shows what sub-paths with this many vertices bring.
  bool shows(std::uint32_t light, std::uint32_t eye) const {
    return !options.subpath_lengths ||
           (options.subpath_lengths->light == light && options.subpath_lengths->eye == eye);
  }
  // Returns how many light paths stand for one sample of every pixel.
  std::uint64_t light_paths() const { return std::uint64_t(camera.width) * camera.height; }
};

// Returns the angle by which textures are filtered: that of a pixel in the middle of the film; 0
// for cameras whose textures are not filtered.
float PixelAngle(const CameraView& camera);
// Returns the size of a pixel in the middle of the whole film, at a distance along a camera path.
float PixelSize(const CameraView& camera, float distance);

// `width` and `height` are those of the whole film [pixels], of which `crop` is rendered, or all if
// it is unset. `filter_offset` must outlive the view.
CameraView MakeCameraView(const Camera& camera, int width, int height, const float* filter_offset,
                          const std::optional<CropWindow>& crop = std::nullopt);

}  // namespace skywave
