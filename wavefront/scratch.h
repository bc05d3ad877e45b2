// Stages borrow the columns that they need for a moment: named views of columns that lie idle in
// the tables of a wave.
//
// A view holds its columns for a scope; their values are lost afterwards (kernels/borrowed.h).
// Views that are needed at the same time lie in different columns:
//
//   - Scratch::first lends FilmUniforms, MixtureUniforms, LightUniforms, DirectionUniforms and
//     PixelUniforms;
//   - Scratch::second lends LensUniforms, LobeUniforms and AimUniforms, or SplitRemainder (u) and
//     LightReach;
//   - Scratch::words lends RayQueues, CaughtRows and RayKeys;
//   - Worker::hits lends LightPlaces;
//   - Worker::escaped lends EmitterHits and EnvironmentDensities;
//   - Worker::lights lends ScatteredDirections;
//   - Worker::surfaces lends CameraRayPoints.
#pragma once

#include <cstddef>
#include <cstdint>

#include "kernels/borrowed.h"
#include "kernels/columns.h"
#include "kernels/lights/local_lights.h"
#include "wavefront/soa.h"

namespace skywave {

struct WordColumns {
  std::uint32_t* word;

  template <class Self, class F>
  static constexpr void ForEachColumn(Self& self, F f) {
    f(self.word);
  }
};

// These tables have no meaning by themselves; views name their columns.
struct Scratch {
  explicit Scratch(std::uint32_t wave) : first(wave), second(wave), words(wave) {}
  soa::Table<UniformColumns> first, second;
  soa::Table<WordColumns> words;

  static constexpr std::size_t kBytesPerRow =
      2 * soa::BytesPerRow<UniformColumns>() + soa::BytesPerRow<WordColumns>();
};

// ---- Uniform random numbers, one row a path, ray or surface (kernels/sampler.h) ----

// Places a path in the filter of its pixel.
struct FilmUniforms : Borrowed<UniformColumns> {
  explicit FilmUniforms(const Scratch& s) : Borrowed(s.first, s.first.rows(), "FilmUniforms") {}
};

// Places the start of a ray, or the end of a connection, on the camera's lens; drawn only for
// cameras with a lens.
struct LensUniforms : Borrowed<UniformColumns> {
  explicit LensUniforms(const Scratch& s) : Borrowed(s.second, s.second.rows(), "LensUniforms") {}
};

// Selects one of the two materials of a mixture that a ray has hit (u).
struct MixtureUniforms : Borrowed<UniformColumns> {
  explicit MixtureUniforms(const Scratch& s)
      : Borrowed(s.first, s.first.rows(), "MixtureUniforms") {}
};

// Picks the light of a sample, and a place on it.
struct LightUniforms : Borrowed<UniformColumns> {
  explicit LightUniforms(const Scratch& s) : Borrowed(s.first, s.first.rows(), "LightUniforms") {}
};

// Aims a light path: its direction from a local light, or its place on a disk.
struct AimUniforms : Borrowed<UniformColumns> {
  explicit AimUniforms(const Scratch& s) : Borrowed(s.second, s.second.rows(), "AimUniforms") {}
};

// These two are ScatterUniforms::direction and ScatterUniforms::lobe (kernels/bsdf/bsdf.h).
struct DirectionUniforms : Borrowed<UniformColumns> {
  explicit DirectionUniforms(const Scratch& s)
      : Borrowed(s.first, s.first.rows(), "DirectionUniforms") {}
};
struct LobeUniforms : Borrowed<UniformColumns> {
  explicit LobeUniforms(const Scratch& s) : Borrowed(s.second, s.second.rows(), "LobeUniforms") {}
};

// Chooses one of the pixels that a connection to the camera can go to.
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

// The rescaled uniform (SplitUniforms), by which the strategy draws if no local light was picked.
struct SplitRemainder : Borrowed<RemainderColumns> {
  explicit SplitRemainder(const Scratch& s)
      : Borrowed({s.second->u}, s.second.rows(), "SplitRemainder") {}
};

// Length of the shadow ray of each light sample and its local light. Where no local light is
// sampled all lengths are infinite, and there are no columns.
struct LightReach : Borrowed<ReachColumns> {
  LightReach() = default;
  explicit LightReach(const Scratch& s)
      : Borrowed({.distance = s.second->v, .light = s.second->u}, s.second.rows(), "LightReach") {}
  bool limited() const { return (*this)->distance != nullptr; }
};

// Light samples are, or light paths start, in these places on triangles, which are written as hits
// (SampleLocalLights, EmitFromLocalLights).
struct LightPlaces : Borrowed<HitColumns> {
  explicit LightPlaces(const soa::Table<HitColumns>& hits)
      : Borrowed(hits, hits.rows(), "LightPlaces") {}
};

// The strategy says radiance and density of the environment here for directions in which no ray has
// escaped.
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

// Each ray has a queue from classification until surfaces have been moved.
struct RayQueues : Borrowed<QueueColumns> {
  explicit RayQueues(const Scratch& s) : Borrowed({s.words->word}, s.words.rows(), "RayQueues") {}
};

struct CaughtColumns {
  std::uint32_t* row;  // in SurfaceColumns

  template <class Self, class F>
  static constexpr void ForEachColumn(Self& self, F f) {
    f(self.row);
  }
};

// The catchers among the surfaces, before any of them is lit.
struct CaughtRows : Borrowed<CaughtColumns> {
  explicit CaughtRows(const Scratch& s) : Borrowed({s.words->word}, s.words.rows(), "CaughtRows") {}
};

struct KeyColumns {
  std::uint32_t* key;  // see kernels/surface/opacity.h

  template <class Self, class F>
  static constexpr void ForEachColumn(Self& self, F f) {
    f(self.key);
  }
};

// Keys decide which surfaces with alpha rays pass through while they are traced. Scenes without
// alpha have none; the pointer is null then, as TraceClosest and its like take it.
struct RayKeys : Borrowed<KeyColumns> {
  RayKeys() = default;
  explicit RayKeys(const Scratch& s) : Borrowed({s.words->word}, s.words.rows(), "RayKeys") {}
};

// Rays that hit emitters come after those that escaped, whose light has been added by then.
struct EmitterHits : Borrowed<EscapeColumns> {
  explicit EmitterHits(const soa::Table<EscapeColumns>& escaped)
      : Borrowed(escaped, escaped.rows(), "EmitterHits") {}
};

// ---- Sub-paths ----

// Surfaces have scattered in these directions (dir), row by row; rows that have not scattered mean
// nothing.
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

// These points lie on camera rays that have not hit a surface yet.
struct CameraRayPoints : Borrowed<PointColumns> {
  explicit CameraRayPoints(const soa::Table<SurfaceColumns>& surfaces)
      : Borrowed({surfaces->org_x, surfaces->org_y, surfaces->org_z}, surfaces.rows(),
                 "CameraRayPoints") {}
  // Returns the points as ConnectCamera takes them: the other columns are null.
  SurfaceColumns as_surfaces() const {
    return {.org_x = (*this)->x, .org_y = (*this)->y, .org_z = (*this)->z};
  }
};

}  // namespace skywave
