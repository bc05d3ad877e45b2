// What integrators do with paths between a stage or two: shared pieces of their stage orders, over
// the tables of a worker. Each counts and times what it does.
#pragma once

#include "wavefront/film/film.h"
#include "wavefront/frame.h"
#include "wavefront/stages/stages.h"
#include "wavefront/worker.h"

namespace skywave {

// Shadow rays that are there to be traced or, once traced, that met nothing.
std::uint32_t CountOpen(const LightColumns& lights, std::uint32_t n);

// The surfaces of the bounce at hand, as strategies see them.
ShadePoints Points(const FrameView& frame, const Worker& w);

// Light groups of the paths [0, n) that begin have nothing yet; `film` will get what they gain.
// Nothing where nobody asks for groups.
void StartGroups(const FrameView& frame, std::uint32_t n, Film& film, Worker& w);

// Traces rays [0, n) that arrive at a bounce and writes their queues; returns how many hit nothing.
// `ranges`: where the hits will be in the surface table. `only_delta`: see SortHits.
std::uint32_t TraceAndSort(const FrameView& frame, const PathEnd& end, const RayColumns& rays,
                           std::uint32_t n, std::uint32_t bounce, bool only_delta, Worker& w,
                           SurfaceRanges& ranges, StageClock& clock);

// Makes surfaces to shade of the hits of rays [0, n), as TraceAndSort left them.
void PrepareHits(const FrameView& frame, const PathEnd& end, const RayColumns& rays,
                 std::uint32_t n, std::uint32_t escaped, const SurfaceRanges& ranges, Worker& w,
                 StageClock& clock);

// Where rays come from: the surfaces that they have left, and the frame that plans the light
// samples of those, which are the partners of what the rays see. `paths` takes what they see.
struct Departure {
  const FrameView& frame;
  ShadePoints points;
  PathColumns paths;
};

// From the surfaces of the worker itself, of any bounce: its tables stay where they are.
Departure FromOwnSurfaces(const FrameView& frame, const Worker& w);

// Traces rays [0, n), adds what the escaped ones see, and makes surfaces to shade of the hits. With
// `only_delta`: see SortHits. `from`: if unsaid, the surfaces of the worker itself.
void IntersectSurfaces(const FrameView& frame, const RayColumns& rays, std::uint32_t n,
                       std::uint32_t bounce, bool only_delta, Worker& w, StageClock& clock);
void IntersectSurfaces(const FrameView& frame, const RayColumns& rays, std::uint32_t n,
                       std::uint32_t bounce, bool only_delta, const Departure& from, Worker& w,
                       StageClock& clock);

// The end of a path: only what shines by itself can still be seen. `from`: as in IntersectSurfaces.
void IntersectLights(const FrameView& frame, const RayColumns& rays, std::uint32_t n,
                     std::uint32_t bounce, Worker& w, StageClock& clock);
void IntersectLights(const FrameView& frame, const RayColumns& rays, std::uint32_t n,
                     std::uint32_t bounce, const Departure& from, Worker& w, StageClock& clock);

// Traces the shadow rays of w.lights, one a surface that takes light samples, as TraceShadows does,
// and counts them. What came before on the clock was evaluation.
void TraceLights(const FrameView& frame, const std::uint32_t* keys, Worker& w, StageClock& clock);

// The light samples of every surface, one after the other: draw, evaluate, trace, add. Directional
// lights come light by light, so that a stream of shadow rays has one direction.
void LightSurfaces(const FrameView& frame, std::uint32_t bounce, Worker& w, StageClock& clock);

// Scatters the surfaces at hand of BSDFs [first_kind, kBsdfKinds); returns how many rays go on.
std::uint32_t ScatterSurfaces(const FrameView& frame, const PathEnd& end, std::uint32_t first_kind,
                              std::uint32_t bounce, const RayColumns& rays, Worker& w,
                              StageClock& clock);

// What the film keeps of a bounce beside radiance, where it is asked to.
void KeepAovs(const FrameView& frame, std::uint32_t bounce, std::uint32_t paths, const Worker& w,
              Film& film, StageClock& clock);

// Gives paths [0, n) to the film. `bounce`: at which the last one ended.
void FinishWave(std::uint32_t n, std::uint32_t bounce, Worker& w, Film& film, StageClock& clock);

// Its two parts: what KeepAovs did not see because paths had ended, and all radiance.
void KeepDirectOfEnded(std::uint32_t n, std::uint32_t bounce, const Worker& w, Film& film);
void FinishPaths(std::uint32_t n, Worker& w, Film& film, StageClock& clock);

}  // namespace skywave
