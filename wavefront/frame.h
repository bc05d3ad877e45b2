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
#include "wavefront/integrators/integrators.h"
#include "wavefront/rays/trace.h"

namespace skywave {

// A way to join sub-paths: how many vertices are from the light, itself counted, and from the eye.
struct SubpathLengths {
  std::uint32_t light = 0, eye = 2;
};

struct EmissionGuide;
struct LightGroups;
struct PhotonMaps;

// Photon mapping. Counts are of photons that are stored, as pbrt's are. Vertex connection and
// merging: light vertices are indirect photons.
struct PhotonOptions {
  std::uint32_t indirect = 200000, caustic = 20000;
  std::uint32_t neighbors = 50;  // of a lookup, at most
  float distance = 0;            // of a lookup, at most [world space]; 0: by the photons
  PhotonKernel kernel = PhotonKernel::kEpanechnikov;
  // Rays of a final gather a surface; 0: photons are looked up where they are seen.
  std::uint32_t gather = 1;
  // More than 1: progressive, everything within a radius that shrinks from pass to pass. 0: one;
  // of vcm, one for each sample of a pixel.
  std::uint32_t passes = 0;
  float alpha = 2.0f / 3;  // how slowly it shrinks
  bool progressive() const { return passes > 1; }
};

struct RenderOptions {
  int width = 640, height = 480;        // of the picture
  int film_width = 0, film_height = 0;  // 0: the picture is the whole film
  int crop_x = 0, crop_y = 0;           // else: the picture's top left corner in the film
  Integrator integrator = Integrator::kPath;
  std::uint32_t samples_per_pixel = 64;
  std::uint32_t first_sample = 0;   // samples [first_sample, first_sample + samples_per_pixel)
  std::uint32_t max_depth = 5;      // surfaces a path scatters at
  std::uint32_t light_samples = 1;  // a hit (direct), a first hit (paths that split)
  std::uint32_t split = 0;          // continuations of a path (path); 0: paths do not split
  bool mis = true;
  std::optional<SubpathLengths> subpath_lengths;  // bdpt: only this one; unset: all
  std::uint32_t seed = 0;
  PixelFilter filter = PixelFilter::kBlackmanHarris;
  float filter_radius = 0;    // [pixels]; 0: the filter's own
  int threads = 0;            // 0: as many as the process may use
  std::uint32_t wave = 2048;  // rows
  Backend backend = Backend::kBest;
  AovSet aovs = 0;  // layers beside the picture
  // Light paths of the sky start where camera paths of a pilot have needed them.
  bool guide = false;
  PhotonOptions photons;
};

// The light samples of a surface: what the strategy plans. Each drawn one goes to a local light or
// to the strategy, by `local`; where the strategy draws none, there are drawn ones for local lights
// alone.
struct LightShares {
  LightPlan plan;
  LightChoice local;      // share 0: there are no local lights
  float of_strategy = 1;  // share of the drawn samples
  float strategy_samples(std::uint32_t requested) const { return float(requested) * of_strategy; }
};

// The const view that stages take. Lives as long as the objects it points into.
struct FrameView {
  RenderOptions options;
  const Geometry* geometry;
  const EnvStrategy* strategy;
  const EnvStrategy* continuation_strategy;  // behind the split; null: the same
  LocalLightView local_lights;
  CameraView camera;
  Tracer tracer;
  SceneSphere sphere = {};  // where light paths from infinity begin
  FilterView filter = {};   // for splats
  // What light paths start with: `strategy`, or, for `photon`, importance where that cannot emit.
  const EnvStrategy* emitter = nullptr;
  const EnvironmentMap* map = nullptr;   // of both
  const EmissionGuide* guide = nullptr;  // of light paths of the sky; null: they start anywhere
  const PhotonMaps* photons = nullptr;   // of the pass at hand
  float eta_vcm = 0;                     // of the pass at hand, see MisTechniques
  const LightGroups* light_groups = nullptr;  // null: nobody asks for them

  MisPolicy mis() const {
    return {.enabled = options.mis, .bsdf_samples = float(splits() ? options.split : 1)};
  }
  MisTechniques mis_techniques() const { return {.mis = mis(), .eta_vcm = eta_vcm}; }
  bool splits() const { return options.split > 0; }
  // Whether light comes from beyond the scene; where it does not, the strategy is not asked.
  bool has_environment() const { return local_lights.count == 0 || local_lights.shared.share < 1; }
  bool has_emitters() const { return local_lights.light_of_triangle != nullptr; }
  // The BSDFs whose rays can still bring light where no further surface is shaded: all of them
  // under multiple importance sampling, else mirrors and glass.
  std::uint32_t first_bsdf_that_sees_light() const {
    const bool shines = has_emitters() || (has_environment() && strategy->shines_on_bsdf_samples());
    return (options.mis || options.subpath_lengths) && shines ? 0 : kFirstDeltaBsdf;
  }
  // Light samples a hit that the user asks for.
  std::uint32_t light_samples() const {
    const LightSamples taken = Describe(options.integrator).light_samples;
    return taken == LightSamples::kRequested || splits() ? options.light_samples : 1;
  }
  // The frame in which continuations go on: paths that do not split again.
  FrameView of_continuations() const;
  LightShares light_shares() const;
  // Whether the picture shows what sub-paths with so many vertices bring.
  bool shows(std::uint32_t light, std::uint32_t eye) const {
    return !options.subpath_lengths ||
           (options.subpath_lengths->light == light && options.subpath_lengths->eye == eye);
  }
  // Light paths that stand for one sample of every pixel.
  std::uint64_t light_paths() const { return std::uint64_t(camera.width) * camera.height; }
};

// Radius of a filter that the user did not give one [pixels].
float DefaultFilterRadius(PixelFilter filter);

// kFilterCells + 1 offsets [pixels]: the inverse of the cumulative distribution of the filter.
std::vector<float> FilterOffsets(PixelFilter filter, float radius);

// kFilterCells densities of the same filter, as FilterView wants them. `offsets`: FilterOffsets.
std::vector<float> FilterDensities(const std::vector<float>& offsets, float radius);

// `width` and `height` are those of the whole film [pixels], of which `crop` is rendered (unset:
// all). `filter_offset` must outlive the view.
CameraView MakeCameraView(const Camera& camera, int width, int height, const float* filter_offset,
                          const std::optional<CropWindow>& crop = std::nullopt);

}  // namespace skywave
