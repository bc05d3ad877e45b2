// The list of integrators, and how each of them describes itself in its own file.
#pragma once

#include <cstdint>
#include <functional>
#include <span>
#include <string>
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
  INTEGRATOR(Vcm, "vcm")                \
  INTEGRATOR(Vpl, "vpl")                \
  INTEGRATOR(IrradianceCache, "irradiance-cache")

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
struct RenderOption;
struct RenderOptions;
struct SceneSphere;
struct WaveRange;
struct Worker;
class WorkerPool;

// How many light samples a surface takes that camera paths hit.
enum class LightSamples {
  kNone,      // light paths bring what light samples would
  kOne,       // one at every surface of a path
  kRequested  // as many as the option `light-samples` gives
};

// Which strategy draws the directions of light paths that come from the map.
enum class LightPaths {
  kNone,      // none: there are no light paths
  kStrategy,  // that of light samples, so it has to be one that can emit
  kAny        // that of light samples if it can emit, or else another one
};

// Renders the samples of a pass. Returns false if no further pass is wanted.
using RenderPass = std::function<bool(const FrameView& frame)>;

// Describes what an integrator is, needs and does.
struct IntegratorDescriptor {
  std::string_view help;  // a line of help texts

  bool direct_light_only = false;  // else it computes all light, except for what `help` says
  LightSamples light_samples = LightSamples::kOne;
  bool controls = false;          // subtracts what a control variate knows (ControlView)
  bool has_light_groups = false;  // keeps light groups apart if paths do not split
  bool has_catchers = false;      // follows paths anew without objects if paths do not split
  LightPaths light_paths = LightPaths::kNone;
  bool has_splats = false;        // light paths add to pixels anywhere on the film
  bool biased = false;            // biased: does not converge to the picture with more samples
  bool mixes_light = false;       // direct and indirect light of a surface come together
  bool pass_each_sample = false;  // unless an option says how many passes

  // The options that only it and integrators like it take; null: none. An option that two of them
  // take is described in one place.
  std::span<const RenderOption> (*options)() = nullptr;

  // Throws OptionError if options do not go together with this integrator. CheckIntegrator checks
  // the fields above itself. Null: there is nothing more to check.
  void (*check)(const RenderOptions& options) = nullptr;
  // Throws OptionError if options do not go together with a scene, which lies within `sphere`.
  void (*check_scene)(const RenderOptions& options, const Geometry& geometry,
                      const SceneSphere& sphere) = nullptr;
  // Adds the tables that only this integrator needs to a worker (MakeWorker).
  void (*add_tables)(const RenderOptions& options, Worker& worker) = nullptr;
  // Calls `render` for each pass, with the frame as the samples of the pass see it. Null: the frame
  // itself is the only pass.
  void (*for_each_pass)(const FrameView& frame, WorkerPool& pool, PhotonCounts& counts,
                        const RenderPass& render) = nullptr;
  // Returns a line for people about what the passes have made; null: there is nothing to say.
  std::string (*describe_passes)(const PhotonCounts& counts) = nullptr;
  // Renders the samples of a wave with a worker that has the tables.
  void (*render_wave)(const FrameView& frame, const WaveRange& range, Worker& worker,
                      Film& film) = nullptr;

  bool has_light_paths() const { return light_paths != LightPaths::kNone; }
};

const IntegratorDescriptor& Describe(Integrator integrator);

#define SKYWAVE_DECLARE(integrator, name) IntegratorDescriptor integrator##Integrator();
SKYWAVE_INTEGRATORS(SKYWAVE_DECLARE)
#undef SKYWAVE_DECLARE

}  // namespace skywave
