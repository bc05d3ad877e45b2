// Columns that stages need for a moment, as views by name of what lies idle in the tables of a
// wave.
//
// A view holds its columns for a scope; afterwards nothing is left of what they held
// (kernels/borrowed.h). Views that are needed at the same time lie in different columns:
//
//   lent by           views
//   Scratch::first    FilmUniforms, MixtureUniforms, LightUniforms, DirectionUniforms,
//   PixelUniforms Scratch::second   LensUniforms, LobeUniforms, AimUniforms; SplitRemainder (u),
//   LightReach (v) Scratch::words    RayQueues, RayKeys Worker::hits      LightPlaces
//   Worker::escaped   EmitterHits, EnvironmentDensities
//   Worker::lights    ScatteredDirections
//   Worker::surfaces  CameraRayPoints
#pragma once

#include <cstddef>
#include <cstdint>

#include "kernels/borrowed.h"
#include "kernels/columns.h"
#include "wavefront/soa.h"

namespace skywave {

struct WordColumns {
  std::uint32_t* word;

  template <class Self, class F>
  static constexpr void ForEachColumn(Self& self, F f) {
    f(self.word);
  }
};

// Tables that mean nothing by themselves. Only views name their columns.
struct Scratch {
  explicit Scratch(std::uint32_t wave) : first(wave), second(wave), words(wave) {}
  soa::Table<UniformColumns> first, second;
  soa::Table<WordColumns> words;

  static constexpr std::size_t kBytesPerRow =
      2 * soa::BytesPerRow<UniformColumns>() + soa::BytesPerRow<WordColumns>();
};

// ---- Uniform random numbers, one row a path, ray or surface (kernels/sampler.h) ----

// Where in the pixel's filter a path lies.
struct FilmUniforms : Borrowed<UniformColumns> {
  explicit FilmUniforms(const Scratch& s) : Borrowed(s.first, s.first.rows(), "FilmUniforms") {}
};

// Where on the camera's lens a ray starts or a connection ends. They are drawn only for cameras
// with a lens.
struct LensUniforms : Borrowed<UniformColumns> {
  explicit LensUniforms(const Scratch& s) : Borrowed(s.second, s.second.rows(), "LensUniforms") {}
};

// Which of two mixed materials a hit has (u).
struct MixtureUniforms : Borrowed<UniformColumns> {
  explicit MixtureUniforms(const Scratch& s)
      : Borrowed(s.first, s.first.rows(), "MixtureUniforms") {}
};

// Which light a sample picks, and where on it.
struct LightUniforms : Borrowed<UniformColumns> {
  explicit LightUniforms(const Scratch& s) : Borrowed(s.first, s.first.rows(), "LightUniforms") {}
};

// Where a light path aims: its direction from a local light, or its place on a disk.
struct AimUniforms : Borrowed<UniformColumns> {
  explicit AimUniforms(const Scratch& s) : Borrowed(s.second, s.second.rows(), "AimUniforms") {}
};

// ScatterUniforms::direction and ScatterUniforms::lobe (kernels/bsdf/bsdf.h).
struct DirectionUniforms : Borrowed<UniformColumns> {
  explicit DirectionUniforms(const Scratch& s)
      : Borrowed(s.first, s.first.rows(), "DirectionUniforms") {}
};
struct LobeUniforms : Borrowed<UniformColumns> {
  explicit LobeUniforms(const Scratch& s) : Borrowed(s.second, s.second.rows(), "LobeUniforms") {}
};

// Which of the pixels that a connection to the camera can go to it gets.
struct PixelUniforms : Borrowed<UniformColumns> {
  explicit PixelUniforms(const Scratch& s) : Borrowed(s.first, s.first.rows(), "PixelUniforms") {}
};

// ---- Light samples, one row a surface or light path ----

struct RemainderColumns {
  float* u;  // in [0, 1)

  template <class Self, class F>
  static constexpr void ForEachColumn(Self& self, F f) {
    f(self.u);
  }
};

// What a uniform has left for the strategy once it has not picked a local light (SplitUniforms).
struct SplitRemainder : Borrowed<RemainderColumns> {
  explicit SplitRemainder(const Scratch& s)
      : Borrowed({s.second->u}, s.second.rows(), "SplitRemainder") {}
};

struct ReachColumns {
  float* distance;  // as SampleLocalLights writes it [length]

  template <class Self, class F>
  static constexpr void ForEachColumn(Self& self, F f) {
    f(self.distance);
  }
};

// How far the shadow rays of light samples reach. Where no local light is sampled all of them reach
// infinitely far, and there is no column.
struct LightReach : Borrowed<ReachColumns> {
  LightReach() = default;
  explicit LightReach(const Scratch& s) : Borrowed({s.second->v}, s.second.rows(), "LightReach") {}
  bool limited() const { return (*this)->distance != nullptr; }
};

// Where on triangles light samples are or light paths start, as hits of those triangles
// (SampleLocalLights, EmitFromLocalLights).
struct LightPlaces : Borrowed<HitColumns> {
  explicit LightPlaces(const soa::Table<HitColumns>& hits)
      : Borrowed(hits, hits.rows(), "LightPlaces") {}
};

// Radiance and density of the environment in directions that nothing has escaped in.
struct EnvironmentDensities : Borrowed<EscapeColumns> {
  explicit EnvironmentDensities(const soa::Table<EscapeColumns>& escaped)
      : Borrowed(escaped, escaped.rows(), "EnvironmentDensities") {}
};

// ---- Rays ----

struct QueueColumns {
  std::uint32_t* queue;  // see kernels/partition.h

  template <class Self, class F>
  static constexpr void ForEachColumn(Self& self, F f) {
    f(self.queue);
  }
};

// The queue of each ray, from classification until surfaces have been moved.
struct RayQueues : Borrowed<QueueColumns> {
  explicit RayQueues(const Scratch& s) : Borrowed({s.words->word}, s.words.rows(), "RayQueues") {}
};

struct KeyColumns {
  std::uint32_t* key;  // see kernels/surface/opacity.h

  template <class Self, class F>
  static constexpr void ForEachColumn(Self& self, F f) {
    f(self.key);
  }
};

// The keys that decide which surfaces with alpha rays pass through, while they are traced. Scenes
// without alpha have none; the pointer is null then, as Trace* wants it.
struct RayKeys : Borrowed<KeyColumns> {
  RayKeys() = default;
  explicit RayKeys(const Scratch& s) : Borrowed({s.words->word}, s.words.rows(), "RayKeys") {}
};

// The rays that hit emitters. They come after those that escaped, whose light has been added.
struct EmitterHits : Borrowed<EscapeColumns> {
  explicit EmitterHits(const soa::Table<EscapeColumns>& escaped)
      : Borrowed(escaped, escaped.rows(), "EmitterHits") {}
};

// ---- Sub-paths ----

// The directions (dir) in which surfaces have scattered, row by row; those of rows that have not
// mean nothing.
struct ScatteredDirections : Borrowed<LightColumns> {
  explicit ScatteredDirections(const soa::Table<LightColumns>& lights)
      : Borrowed(lights, lights.rows(), "ScatteredDirections") {}
};

struct PointColumns {
  float *x, *y, *z;  // world space

  template <class Self, class F>
  static constexpr void ForEachColumn(Self& self, F f) {
    f(self.x), f(self.y), f(self.z);
  }
};

// Points on camera rays that have not met a surface yet.
struct CameraRayPoints : Borrowed<PointColumns> {
  explicit CameraRayPoints(const soa::Table<SurfaceColumns>& surfaces)
      : Borrowed({surfaces->org_x, surfaces->org_y, surfaces->org_z}, surfaces.rows(),
                 "CameraRayPoints") {}
  // As ConnectCamera takes points: the other columns are null.
  SurfaceColumns as_surfaces() const {
    return {.org_x = (*this)->x, .org_y = (*this)->y, .org_z = (*this)->z};
  }
};

}  // namespace skywave
