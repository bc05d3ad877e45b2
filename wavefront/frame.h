// One picture to render: everything that all workers read and none writes.
#pragma once

#include <cstdint>
#include <optional>
#include <vector>

#include "kernels/bsdf/bsdf.h"
#include "kernels/camera.h"
#include "kernels/light_paths/camera_connection.h"
#include "kernels/light_paths/emission.h"
#include "kernels/lights/local_lights.h"
#include "lights/strategies/strategy.h"
#include "scene/geometry.h"
#include "scene/scene.h"
#include "wavefront/film/aovs.h"
#include "wavefront/film/film_area.h"
#include "wavefront/film/filter.h"
#include "wavefront/integrator.h"
#include "wavefront/rays/trace.h"
#include "wavefront/slots.h"

namespace skywave {

struct LightGroups;

// Samples [first, end) of every pixel.
struct SampleRange {
  std::uint32_t first = 0, end = 0;
  std::uint32_t count() const { return end - first; }
  friend bool operator==(const SampleRange&, const SampleRange&) = default;
};

// Which lights a surface takes samples of.
enum class LightSelection {
  kPower,  // as many as asked for, of local lights and the map by their power
  kOne,    // likewise, with all of them equally likely (T 4.2.1, SAMPLE_ONE)
  kTree,   // likewise, of local lights by what each surface would get from them about
  kAll     // one of each local light, and those of the map (SAMPLE_ALL)
};
template <>
inline constexpr auto kEnumNames<LightSelection> =
    std::to_array<Named<LightSelection>>({{LightSelection::kPower, "power"},
                                          {LightSelection::kOne, "one"},
                                          {LightSelection::kTree, "tree"},
                                          {LightSelection::kAll, "all"}});

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
  std::uint32_t light_samples = 1;  // per hit (LightSamples)
  // BSDF samples of the first surface with a density, each of which goes on as a path; 0: one, by
  // the path itself.
  std::uint32_t bsdf_samples = 0;
  LightSelection light_selection = LightSelection::kPower;
  bool mis = true;
  std::uint32_t seed = 0;
  PixelFilter filter = PixelFilter::kBlackmanHarris;
  float filter_radius = 0;    // [pixels]; 0: the filter's own
  int threads = 0;            // 0: as many as the process may use
  std::uint32_t wave = 2048;  // rows
  Backend backend = Backend::kBest;
  AovSet aovs = 0;  // layers in addition to the picture
  ValueSlots own;   // those of integrators and policies, by type

  // The options of a type that an integrator or a policy has. A reference that may be changed is
  // good until the next copy of the options.
  template <class Options>
  const Options& of() const {
    return own.of<Options>();
  }
  template <class Options>
  Options& of() {
    return own.of<Options>();
  }
};

// Returns the samples that are rendered, and those of the whole picture that they are a part of.
SampleRange SamplesOf(const RenderOptions& options);
SampleRange PictureSamples(const RenderOptions& options);

// Returns how many light samples a hit takes, or the first hit of a path that splits.
inline std::uint32_t LightSamplesOf(const RenderOptions& options) {
  const LightSamples taken = Describe(options.integrator).light_samples;
  const bool all = taken == LightSamples::kRequested || options.bsdf_samples > 0;
  return all ? options.light_samples : 1;
}

// The light samples of a surface are those that the strategy plans, its fixed ones first; `each`
// local lights take one of their own between these and the drawn ones. Where they take none, each
// drawn sample goes to a local light or to the strategy, as `local` decides; if the strategy draws
// none, there are drawn samples for local lights alone.
struct LightShares {
  LightPlan plan;
  std::uint32_t each = 0;
  LightChoice local;      // share 0: there are no local lights, or each takes its own
  float of_strategy = 1;  // its share of the drawn samples
  float strategy_samples(std::uint32_t requested) const { return float(requested) * of_strategy; }
  std::uint32_t total() const { return plan.total() + each; }
  std::uint32_t first_drawn() const { return plan.fixed + each; }
  // Whether light sample `index` is that of local light `index` - plan.fixed.
  bool is_of_each(std::uint32_t index) const {
    return index >= plan.fixed && index < first_drawn();
  }
  // Returns how light sample `index` picks a local light, and how often surfaces do.
  LightChoice ChoiceOf(const LocalLightView& lights, std::uint32_t index) const {
    if (index >= first_drawn()) return local;
    if (index < plan.fixed) return {};
    return {lights.only + lights.count - (index - plan.fixed), 1};
  }
  float local_samples(std::uint32_t index) const {
    return index >= first_drawn() ? float(plan.drawn) : 1;
  }
  // Returns the same of rays that hit local lights, whichever sample could have found these.
  LightChoice ChoiceOfHits(const LocalLightView& lights) const {
    return each > 0 ? lights.each : local;
  }
  float hit_samples(const LocalLightView& lights) const {
    return each > 0 ? lights.each_samples : float(plan.drawn);
  }
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
  const EnvironmentMap* map = nullptr;        // the map of both
  const LightGroups* light_groups = nullptr;  // null: nobody asks for them
  bool shows_background = true;               // false: camera rays see no light of the map
  // By material: 1 for catchers; null: there are none.
  const std::uint8_t* catchers = nullptr;
  // By local light: 1 for those that are surfaces of objects; null: there are none. Objects are all
  // that is no catcher.
  const std::uint8_t* object_lamps = nullptr;
  ViewSlots shown;  // what passes and policies have for stages, by type

  // Returns what a pass or a policy shows; null: there is none.
  template <class Data>
  const Data* find() const {
    return shown.find<Data>();
  }
  template <class Data>
  void Show(const Data* data) {
    shown.Set(data);
  }

  // Returns how many light samples a hit takes.
  std::uint32_t light_samples() const { return LightSamplesOf(options); }
  MisPolicy mis() const {
    return {.enabled = options.mis,
            .bsdf_samples = options.bsdf_samples > 0 ? float(options.bsdf_samples) : 1};
  }
  // True if light comes from beyond the scene; if not, the strategy is not used.
  bool has_environment() const { return local_lights.count == 0 || local_lights.shared.share < 1; }
  bool has_emitters() const { return local_lights.light_of_triangle != nullptr; }
  // Returns the first of the BSDFs whose rays can still bring light when no further surface is
  // shaded: under multiple importance sampling those of all BSDFs can, else those of mirrors and
  // glass.
  std::uint32_t first_bsdf_that_sees_light() const {
    return options.mis && shines_on_bsdf_samples() ? 0 : kFirstDeltaBsdf;
  }
  bool shines_on_bsdf_samples() const {
    return has_emitters() || (has_environment() && strategy->shines_on_bsdf_samples());
  }
  // Returns the frame in which continuations go on as paths that do not split again.
  FrameView of_continuations() const;
  // Returns the frame of the place without objects: rays meet catchers alone. Light samples are
  // drawn as with objects.
  FrameView of_place() const;
  bool is_of_place() const { return tracer.only != nullptr; }
  LightShares light_shares() const;
  // Returns how many light paths stand for one sample of every pixel.
  std::uint64_t light_paths() const { return std::uint64_t(camera.width) * camera.height; }
};

// Returns the angle by which textures are filtered: that of a pixel in the middle of the film; 0
// for cameras whose textures are not filtered.
float PixelAngle(const CameraView& camera);
// Returns the size of a pixel in the middle of the whole film, at a distance along a camera path.
float PixelSize(const CameraView& camera, float distance);

// `width` and `height` are those of the whole film [pixels], of which `crop` is rendered, or all if
// it is unset. `filter_offset` must outlive the view. Rays of an orthographic camera without a lens
// begin no farther away than a sphere around the scene, if there is one: their hits are then as
// exact as those of a camera that stands there.
CameraView MakeCameraView(const Camera& camera, int width, int height, const float* filter_offset,
                          const std::optional<CropWindow>& crop = std::nullopt,
                          const SceneSphere* around = nullptr);

}  // namespace skywave
