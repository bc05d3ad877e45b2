// A strategy lights by an illumination map: it says where light samples come from and with what
// density.
//
// Strategies are interchangeable: each is a file pair of this folder, one line in the table of
// strategies.cc, and is run through one suite of statistical tests.
#pragma once

#include <cstddef>
#include <cstdint>
#include <memory>
#include <optional>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "kernels/bsdf/bsdf.h"
#include "kernels/columns.h"
#include "lights/maps/environment_map.h"
#include "lights/parameters.h"

namespace skywave {

// The points that light is sampled for, and what a strategy may need to know about them.
struct ShadePoints {
  const SurfaceColumns& surfaces;
  const SurfaceRanges& ranges;  // rows of each BSDF
  MaterialView materials;
  const PathColumns& paths;  // for strategies that draw more uniforms than they are given
};

// A surface takes so many light samples: `fixed` ones whatever the user asks for (each directional
// light, or each cell, once), then `drawn` random ones. Samples 0..fixed-1 are the fixed ones.
struct LightPlan {
  std::uint32_t fixed = 0, drawn = 1;
  bool random_fixed = false;  // fixed samples need uniforms too
  std::uint32_t total() const { return fixed + drawn; }
};

// The light sample that is wanted is number `index` of a plan for `requested` samples.
struct LightCall {
  std::uint32_t index = 0, requested = 1;
  std::uint32_t pair = 0;  // pair of dimensions of its uniforms (kernels/sampler.h)
  float share = 1;         // of the drawn samples; the others go to local lights
  // A surface can expect so many drawn samples.
  float samples() const { return float(requested) * share; }
};

class EnvStrategy;

// A strategy that a pilot may choose, and about what a light sample of it costs, its density for
// an escaped ray included, in units of what a ray of the scene costs.
struct StrategyCandidate {
  const EnvStrategy* strategy;
  double cost;
};

// Immutable after construction, shared by all threads. Sample and EvaluateEscaped are called once a
// wave and sample; their bodies are kernel calls.
class EnvStrategy {
 public:
  EnvStrategy() = default;
  EnvStrategy(const EnvStrategy&) = delete;  // tables point at each other
  EnvStrategy& operator=(const EnvStrategy&) = delete;
  virtual ~EnvStrategy() = default;
  virtual std::string_view name() const = 0;
  virtual std::size_t table_bytes() const = 0;
  // Describes to the user what the strategy has chosen by itself; empty: nothing.
  virtual std::string note() const { return {}; }

  // Returns the same strategy for the same map in another orientation, with the tables of this one;
  // null: they depend on the orientation.
  virtual std::unique_ptr<EnvStrategy> Turned(const EnvironmentMap&) const { return nullptr; }

  // Returns the samples that a surface takes where the user asks for `requested` of them.
  virtual LightPlan Plan(std::uint32_t requested) const { return {.drawn = requested}; }

  // Draws one light sample for each of surfaces [0, n), which take light samples: writes dir, r, g,
  // b and pdf of `out` (see LightColumns). Densities count all samples of the plan, the drawn ones
  // as call.samples(). t_far means nothing before samples are evaluated, and may be borrowed.
  virtual void Sample(const ShadePoints& points, const UniformColumns& uniforms, std::uint32_t n,
                      LightCall call, const LightColumns& out) const = 0;

  // Writes radiance and light_pdf of rows [0, n): what a ray that leaves the scene sees, and the
  // density of light samples in its direction at surface `from` of `points`, all samples of the
  // plan counted, `samples` drawn ones (LightCall::samples) [1/sr]. Radiance that directional
  // lights stand for is left out, except where pdf is 0: no light sample competes with such a ray,
  // so it sees the whole map, and its light_pdf is unspecified. Rows with a density left surfaces
  // that Sample has been called for; it may have kept light_norm of them.
  virtual void EvaluateEscaped(const ShadePoints& points, std::uint32_t n, float samples,
                               const EscapeColumns& rows) const = 0;

  // False means that the density misses light that is there (it is zero where radiance is not), so
  // the strategy is right only together with BSDF sampling.
  virtual bool complete() const { return true; }
  // True means that samples and densities are those of a surface. Otherwise Sample and
  // EvaluateEscaped do not look at `points`, so light paths can start with a sample
  // (kernels/light_paths/emission.h).
  virtual bool depends_on_surface() const { return false; }
  // False means that directions which BSDF sampling draws see no light (EvaluateEscaped finds black
  // where pdf is not 0), so nobody needs to trace them to see the map.
  virtual bool shines_on_bsdf_samples() const { return true; }
  // False means that lights stand for parts of the map, so the expected picture differs from the
  // map's.
  virtual bool unbiased() const { return true; }

  // Returns the strategies of which a pilot chooses one before a render
  // (wavefront/policies/strategy_pilot.h), the one to keep in doubt first; none: this one is used.
  virtual std::span<const StrategyCandidate> candidates() const { return {}; }
};

struct StrategyFactory {
  std::string_view name, description;
  std::span<const StrategyParameter> parameters;
  std::unique_ptr<EnvStrategy> (*make)(const EnvironmentMap& map, const StrategyValues& values);
  bool needs_portals = false;  // `make` throws for a map without them
};

std::span<const StrategyFactory> Strategies();

// Returns the files that a specification names.
std::vector<std::string> FilesOfStrategy(const std::string& specification);

// Returns whether light paths can start with the strategy's samples: they need one random sample
// that depends on no surface and finds all light there is.
bool CanEmit(const EnvStrategy& strategy);

// Makes the strategy of a specification "name" or "name:key=value,..."; the map must outlive it.
// Throws InputError with the names or keys that there are, where one is unknown.
std::unique_ptr<EnvStrategy> MakeStrategy(const std::string& specification,
                                          const EnvironmentMap& map, const StrategyUse& use = {});

}  // namespace skywave
