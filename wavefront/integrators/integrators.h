// The integrators: one list, and what each of them says of itself in its own file.
#pragma once

#include <cstdint>
#include <functional>
#include <string_view>

#include "base/names.h"

namespace skywave {

// The integrators, one line each: a file of this folder defines NameIntegrator(), and everything
// else follows. The order is that of help texts.
#define SKYWAVE_INTEGRATORS(INTEGRATOR) \
  INTEGRATOR(Direct, "direct")          \
  INTEGRATOR(Path, "path")              \
  INTEGRATOR(Light, "light")            \
  INTEGRATOR(Bdpt, "bdpt")              \
  INTEGRATOR(Photon, "photon")          \
  INTEGRATOR(Vcm, "vcm")

#define SKYWAVE_VALUE(integrator, name) k##integrator,
enum class Integrator { SKYWAVE_INTEGRATORS(SKYWAVE_VALUE) };
#undef SKYWAVE_VALUE

#define SKYWAVE_NAME(integrator, name) {Integrator::k##integrator, name},
template <>
inline constexpr auto kEnumNames<Integrator> =
    std::to_array<Named<Integrator>>({SKYWAVE_INTEGRATORS(SKYWAVE_NAME)});
#undef SKYWAVE_NAME

class Film;
struct FrameView;
class Geometry;
struct PhotonCounts;
struct RenderOptions;
struct SceneSphere;
struct WaveRange;
struct Worker;
class WorkerPool;

// Light samples that a surface seen by the camera takes.
enum class LightSamples {
  kNone,      // light paths bring what they would bring
  kOne,       // at every surface of a path
  kRequested  // as many as the option `light-samples` says
};

// Who draws the directions of light paths that come from the map.
enum class LightPaths {
  kNone,      // there are no light paths
  kStrategy,  // the strategy that draws light samples, so it has to be one that can
  kAny        // the strategy if it can, or else another one
};

// What passes of light paths leave for the passes of camera paths.
enum class StoredLight {
  kNothing,  // there are no such passes
  kPhotons,  // a caustic and an indirect map, whose photons are looked up
  kVertices  // one map of light vertices, which are merged
};

// Renders the samples of a pass.
using RenderPass = std::function<void(const FrameView& frame)>;

// What an integrator is, needs and does.
struct IntegratorDescriptor {
  std::string_view help;  // a line of help texts

  // What it computes, and which options it takes.
  bool direct_light_only = false;  // else its mean is all light, but for what `help` says
  LightSamples light_samples = LightSamples::kOne;
  bool splits = false;            // takes the option `split`
  bool selects_paths = false;     // takes the option `paths`
  bool has_light_groups = false;  // keeps them apart, where paths do not split
  LightPaths light_paths = LightPaths::kNone;
  bool has_splats = false;  // light paths add to pixels anywhere on the film
  StoredLight stores = StoredLight::kNothing;
  bool pass_each_sample = false;  // of passes, unless the option `progressive` says how many

  // Throws OptionError where options do not go together with this integrator; null: all of them do
  // that the fields above let pass (CheckIntegrator).
  void (*check)(const RenderOptions& options) = nullptr;
  // The same for a scene, whose bounds `sphere` is around.
  void (*check_scene)(const RenderOptions& options, const Geometry& geometry,
                      const SceneSphere& sphere) = nullptr;
  // Adds the tables that the integrator needs besides those of all workers (MakeWorker).
  void (*add_tables)(const RenderOptions& options, Worker& worker) = nullptr;
  // Calls `render` for each pass of a frame, with the frame as its samples see it; null: the frame
  // itself is the only one.
  void (*for_each_pass)(const FrameView& frame, WorkerPool& pool, PhotonCounts& counts,
                        const RenderPass& render) = nullptr;
  // Renders the samples of a wave; the worker has the tables.
  void (*render_wave)(const FrameView& frame, const WaveRange& range, Worker& worker,
                      Film& film) = nullptr;

  bool has_light_paths() const { return light_paths != LightPaths::kNone; }
  bool has_photons() const { return stores != StoredLight::kNothing; }
};

const IntegratorDescriptor& Describe(Integrator integrator);

#define SKYWAVE_DECLARE(integrator, name) IntegratorDescriptor integrator##Integrator();
SKYWAVE_INTEGRATORS(SKYWAVE_DECLARE)
#undef SKYWAVE_DECLARE

}  // namespace skywave
