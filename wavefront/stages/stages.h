// The stages of a wave, in the order in which a path meets them. Each is a free function over
// tables: const inputs first, what it writes last.
#pragma once

#include <cstdint>

#include "kernels/sampler.h"
#include "wavefront/film/film.h"
#include "wavefront/frame.h"
#include "wavefront/worker.h"

namespace skywave {

// The rows of a wave before they are paths: samples [first, first + count) of a tile, numbered beam
// by beam (kernels/camera.h), all beams of a block of pixels in sequence.
struct Tile {
  std::uint32_t x, y, width, height;  // [pixels] of the film that is kept, whole blocks
};
struct WaveRange {
  Tile tile;
  std::uint64_t first;  // both are whole beams
  std::uint32_t count;
};

// Which end of light transport paths begin at.
struct PathEnd {
  Transport transport;
  std::uint32_t pairs;  // where its pairs of dimensions begin (kernels/sampler.h)
  // Of scattering: where a path splits into several, which point of a common sequence this one is.
  SampleIndexing split = {};
};
inline constexpr PathEnd kCameraEnd = {Transport::kRadiance, 0};
inline constexpr PathEnd kLightEnd = {Transport::kFlux, kLightPathPairs};

// Starts `range.count` paths: seeds, samples and pixels of `paths`, radiance 0, and their camera
// rays in `rays`, row for row.
void GenerateRays(const FrameView& frame, const WaveRange& range, const UniformColumns& film,
                  const UniformColumns& lens, const PathColumns& paths, const RayColumns& rays);

// The keys that decide which holes rays [0, n) meet, in `keys`; null in scenes without holes. The
// rays are those of the paths in `rows`, traced for what `event` numbers (SamplePair).
const std::uint32_t* RayKeys(const FrameView& frame, const PathColumns& paths,
                             const std::uint32_t* rows, std::uint32_t n, std::uint32_t event,
                             std::uint32_t* keys);

// Writes the queue of every ray (kernels/partition.h) and the ranges that the queues of the BSDFs
// will take in the surface table; returns the number of rays that hit nothing. With `only_delta`,
// hits of rays that were drawn from a density are dropped: `direct` wants no second bounce of them.
std::uint32_t SortHits(const Geometry& geometry, const RayColumns& rays, const HitColumns& hits,
                       std::uint32_t n, bool only_delta, std::uint32_t* queue,
                       SurfaceRanges& ranges);

// Moves what shading needs of hits and their rays to the ranges of their BSDFs.
void MoveSurfaces(const RayColumns& rays, const HitColumns& hits, const std::uint32_t* queue,
                  std::uint32_t n, const SurfaceRanges& ranges, const SurfaceColumns& surfaces);

// What surface preparation leaves to do where materials have textures or parameters that vary.
// Light paths, which know of no pixel, look up level 0.
void TextureSurfaces(const FrameView& frame, const PathEnd& end, const SurfaceRanges& ranges,
                     const SurfaceColumns& surfaces);

// Adds the map's radiance along escaped rays to their paths. `from`: the surfaces of the bounce
// before, which the strategy may ask.
void AddEscaped(const FrameView& frame, const ShadePoints& from, const EscapeColumns& escaped,
                std::uint32_t n, const PathColumns& paths);

// Adds the radiance of rays that hit what shines to their paths. `met`: room for them.
void AddEmitted(const FrameView& frame, const RayColumns& rays, const HitColumns& hits,
                std::uint32_t n, const EscapeColumns& emitter_hits, const PathColumns& paths);

// Draws light sample `index` of the plan for every surface that takes light samples, of which there
// is at least one. Returns how far the light of every row is, null: infinitely. `rest`: room for
// that and for what local lights leave of the uniforms. `places`: room for where on triangles
// samples are, which is written if some that shine have holes.
const float* SampleLights(const FrameView& frame, const ShadePoints& points,
                          const LightShares& shares, std::uint32_t bounce, std::uint32_t index,
                          const UniformColumns& uniforms, const UniformColumns& rest,
                          const LightColumns& lights, const HitColumns& places);

// Turns light samples into contributions and opens or closes their shadow rays. `reach`: as
// SampleLights returns it.
void EvaluateLights(const FrameView& frame, const SurfaceColumns& surfaces,
                    const SurfaceRanges& ranges, const float* reach, const LightColumns& lights);

// Closes (t_far negative) the light samples that are at a hole of their own triangle, which their
// shadow rays do not reach. `places`: as SampleLights writes them; `keys`: of the shadow rays.
void CloseTransparentSamples(const FrameView& frame, const HitColumns& places,
                             const std::uint32_t* keys, std::uint32_t n, float* t_far);

// Scatters the surfaces of BSDFs [first_kind, kBsdfKinds) and writes the rays that go on; returns
// their number.
std::uint32_t Scatter(const FrameView& frame, const PathEnd& end, const PathColumns& paths,
                      const SurfaceColumns& surfaces, const SurfaceRanges& ranges,
                      std::uint32_t first_kind, std::uint32_t bounce,
                      const UniformColumns& direction, const UniformColumns& lobe,
                      const RayColumns& rays);

}  // namespace skywave
