// The stages of a wave, in the order in which a path meets them. Each is a free function over
// tables: const inputs first, what it writes last. Views of scratch columns (wavefront/scratch.h)
// are inputs or outputs; a stage that takes the Scratch itself borrows from it what it needs.
#pragma once

#include <algorithm>
#include <cstddef>
#include <cstdint>
#include <span>

#include "kernels/sampler.h"
#include "wavefront/film/film.h"
#include "wavefront/frame.h"
#include "wavefront/scratch.h"
#include "wavefront/worker.h"

namespace skywave {

// A rectangle of the film that is kept, whole blocks [pixels].
struct Tile {
  std::uint32_t x, y, width, height;
};
// The rows of a wave before they are paths: samples [first, first + count) of a tile, numbered beam
// by beam (kernels/camera.h), all beams of a block of pixels in sequence.
struct WaveRange {
  Tile tile;
  std::uint64_t first;  // both are whole beams
  std::uint32_t count;
  // The blocks of the tile whose samples are numbered, as indices row by row; empty: all.
  std::span<const std::uint32_t> blocks = {};
};

// The end of light transport that paths begin at.
struct PathEnd {
  Transport transport;
  std::uint32_t pairs;  // where its pairs of dimensions begin (kernels/sampler.h)
  // Where a path splits into several, they scatter by points of a common sequence, and this says
  // which of them a path takes.
  SampleIndexing split = {};
};
inline constexpr PathEnd kCameraEnd = {Transport::kRadiance, 0};
inline constexpr PathEnd kLightEnd = {Transport::kFlux, kLightPathPairs};

// Starts `range.count` paths: seeds, samples and pixels of `paths`, radiance 0, and their camera
// rays in `rays`, row for row.
void GenerateRays(const FrameView& frame, const WaveRange& range, const FilmUniforms& film,
                  const LensUniforms& lens, const PathColumns& paths, const RayColumns& rays);

// Makes the keys of rays [0, n), none in scenes without alpha. The rays are those of the paths in
// `rows`, traced for what `event` numbers (SamplePair).
RayKeys MakeRayKeys(const FrameView& frame, const PathColumns& paths, const std::uint32_t* rows,
                    std::uint32_t n, std::uint32_t event, const Scratch& scratch);

// Writes the queue of every ray (kernels/partition.h) and the ranges that the queues of the BSDFs
// will take in the surface table; returns the number of rays that hit nothing. With `only_delta`,
// hits of rays that were drawn from a density are dropped: `direct` wants no second bounce of them.
std::uint32_t SortHits(const Geometry& geometry, const RayColumns& rays, const HitColumns& hits,
                       std::uint32_t n, bool only_delta, const RayQueues& queues,
                       SurfaceRanges& ranges);

// Moves what shading needs of hits and their rays to the ranges of their BSDFs.
void MoveSurfaces(const Geometry& geometry, const RayColumns& rays, const HitColumns& hits,
                  const RayQueues& queues, std::uint32_t n, const SurfaceRanges& ranges,
                  const SurfaceColumns& surfaces);

// Does what surface preparation leaves to do where materials have textures or parameters that vary.
// Light paths, which belong to no pixel, look up level 0.
void TextureSurfaces(const FrameView& frame, const PathEnd& end, const SurfaceRanges& ranges,
                     const SurfaceColumns& surfaces);

// Adds the map's radiance along escaped rays to their paths. The strategy may ask for the surfaces
// of the bounce before, `from`. Rays without a density see the map interpolated, unless their path
// has met a BSDF with a density (`met`, see Departure): light paths that come the other way see
// texels.
void AddEscaped(const FrameView& frame, const ShadePoints& from, const std::uint32_t* met,
                const EscapeColumns& escaped, std::uint32_t n, const PathColumns& paths);

// Adds the radiance of rays that hit emitters to their paths. `left` are the surfaces that the rays
// have left.
void AddEmitted(const FrameView& frame, const RayColumns& rays, const HitColumns& hits,
                std::uint32_t n, const SurfaceColumns& left, const EmitterHits& emitter_hits,
                const PathColumns& paths);

// Draws a sample of the strategy for every row, where local lights take the share `local_share` of
// the samples, less than 1. Rows that a local light will take over get one too: dense rows save
// more time than that wastes.
void SampleStrategy(const EnvStrategy& strategy, const ShadePoints& points,
                    const LightUniforms& uniforms, float local_share, std::uint32_t n,
                    const LightCall& call, const Scratch& scratch, const LightColumns& lights);

// Draws light sample `index` of the plan for every surface that takes light samples, of which there
// is at least one, by pair `pair` of dimensions, and returns how far their light is. Where samples
// are on triangles is written to `places` if rays may pass through some of those that shine.
LightReach SampleLights(const FrameView& frame, const ShadePoints& points,
                        const LightShares& shares, std::uint32_t pair, std::uint32_t index,
                        const LightUniforms& uniforms, const Scratch& scratch,
                        const LightColumns& lights, const LightPlaces& places);

// Bounces before this one are never cut by roulette.
inline constexpr std::uint32_t kFirstRouletteBounce = 3;

// What is known beforehand of the light of the environment on diffuse surfaces: stages subtract it
// from samples and add its integral (a control variate). A frame without has none.
struct ControlView {
  IrradianceView irradiance;       // of the map, where nothing hides it
  ControlWeightView weights = {};  // without weights: it weighs 1 everywhere
  bool weighs() const { return weights.weight != nullptr; }
};

// The columns of a control variate: what is subtracted, one row for each light sample or scattered
// ray, and what the control weighs at each surface; null: 1.
struct ControlRows {
  ControlColumns out = {};
  const float* weight = nullptr;
};

// Calls f(surface, light) for those of surfaces [0, n) whose light sample goes to a local light.
// The frame has light groups, links or lamps of objects.
template <class F>
void ForEachLocalLight(const LightReach& reach, std::uint32_t n, const F& f) {
  if (!reach.limited()) return;
  for (std::uint32_t i = 0; i < n; ++i) {
    if (reach->light[i] >= 0) f(i, std::size_t(reach->light[i]));
  }
}

// Multiplies the radiance of paths [0, n) by the factors of a filter with signs.
void WeighByFilter(const FrameView& frame, std::uint32_t n, const Worker& w);

// Turns light samples into contributions and opens or closes their shadow rays. With a control
// variate, `control` gets what is subtracted from the paths of the surfaces; the first light sample
// of a surface subtracts the integral of the control as well.
void EvaluateLights(const FrameView& frame, const SurfaceColumns& surfaces,
                    const SurfaceRanges& ranges, const LightReach& reach, std::uint32_t index,
                    const LightColumns& lights, const ControlRows& control = {});

// Rejects (t_far negative) light samples on transparent texels; their shadow rays stop short of
// these. `keys` are those of the shadow rays.
void CloseTransparentSamples(const FrameView& frame, const LightPlaces& places, const RayKeys& keys,
                             std::uint32_t n, float* t_far);

// Which surfaces scatter, and by which random numbers.
struct Scattering {
  PathEnd end;
  std::uint32_t bounce;          // of the surfaces
  std::uint32_t first_kind = 0;  // those of BSDFs [first_kind, kBsdfKinds) scatter
};

// Scatters surfaces and writes the rays that go on; returns their number. With a control variate,
// `control` gets what is subtracted for each of them.
std::uint32_t Scatter(const FrameView& frame, const ShadePoints& points, const Scattering& how,
                      const Scratch& scratch, const RayColumns& rays,
                      const ControlRows& control = {});

}  // namespace skywave
