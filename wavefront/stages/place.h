// Catchers are surfaces that stand for what a photograph shows already: the place. What is seen of
// them is how objects, which are all other surfaces, change their light (differential rendering,
// Debevec 1998): their shadows, reflections, caustics and bounced colours.
//
// The light with objects and the light without come from the same paths. A path is a function of
// its random numbers and of what its rays meet, so it is the same without the objects unless one of
// its rays ends at an object, is stopped before its light, or leads to a lamp of an object. Only
// those few are followed again, by the same numbers, in the frame of the place
// (FrameView::of_place). The difference of all others is exactly 0.
#pragma once

#include <cstdint>

#include "wavefront/film/film.h"
#include "wavefront/frame.h"
#include "wavefront/stages/stages.h"
#include "wavefront/worker.h"

namespace skywave {

// Bits of PlaceColumns::met.
inline constexpr std::uint32_t kSeesObject = 1;     // the first surface is of an object
inline constexpr std::uint32_t kSeesCatcher = 2;    // it is of a catcher
inline constexpr std::uint32_t kObjectsMatter = 4;  // the path may be another without them

// One row = one path of the wave.
struct PlaceColumns {
  std::uint32_t* met;
  std::uint32_t* open;  // by surface: whether its current shadow ray is traced
  float *r, *g, *b;     // radiance with the objects; at the end, what they change

  template <class Self, class F>
  static constexpr void ForEachColumn(Self& self, F f) {
    f(self.met), f(self.open), f(self.r), f(self.g), f(self.b);
  }
};

// A worker needs these tables where there are catchers.
struct PlaceTables {
  explicit PlaceTables(std::uint32_t wave) : paths(wave), part(wave) {}
  soa::Table<PlaceColumns> paths;
  soa::Table<RadianceColumns> part;  // of the radiance of the paths, for the film
};

// Adds the tables to a worker that needs them.
void AddPlaceTables(const RenderOptions& options, Worker& worker);

// Remembers which of rays [0, n) have met objects; rays of bounce 0 begin paths. `known`: the hits
// name triangles, and not only whether there is one. Does nothing in scenes without catchers and in
// frames of their place, as all of these functions.
void SeeObjects(const FrameView& frame, const RayColumns& rays, std::uint32_t n,
                std::uint32_t bounce, bool known, const Worker& w);

// Remembers which shadow rays of w.lights are stopped: BeforeShadows comes before they are traced.
void BeforeShadows(const FrameView& frame, const Worker& w);
void AfterShadows(const FrameView& frame, const Worker& w);

// Closes light samples that go to lamps of objects in the frame of the place, and remembers them
// with objects.
void SeeObjectLamps(const FrameView& frame, const LightReach& reach, const Worker& w);

// Gives the film the light of objects of paths [0, n), which are weighted by the filter and have
// all their radiance, and keeps that of catchers.
void KeepLightParts(const FrameView& frame, std::uint32_t n, const Worker& w, Film& film);

// Starts the paths of a wave anew and leaves in w.rays[0] the camera rays of those that see
// catchers and may be others without objects; returns their number.
std::uint32_t ReturnToPlace(const FrameView& place, const WaveRange& range, Worker& w);

// Gives the film the light of catchers without the objects, and what these change of it.
void KeepPlace(const FrameView& place, std::uint32_t n, const Worker& w, Film& film);

// Renders the place of a wave whose paths with objects are in the film: follow(place, n) follows
// paths from their camera rays, [0, n) of w.rays[0], to their ends. Does nothing without catchers.
template <class Follow>
void RenderPlace(const FrameView& frame, const WaveRange& range, Worker& w, Film& film,
                 StageClock& clock, const Follow& follow) {
  if (frame.catchers == nullptr) return;
  const FrameView place = frame.of_place();
  const std::uint32_t n = ReturnToPlace(place, range, w);
  clock.Lap(Stage::kGenerate);
  follow(place, n);
  KeepPlace(place, range.count, w, film);
  clock.Lap(Stage::kFilm);
}

}  // namespace skywave
