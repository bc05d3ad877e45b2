// Integrators share these pieces of their stage orders, over the tables of a worker. Each counts
// and times what it does.
#pragma once

#include "wavefront/film/film.h"
#include "wavefront/frame.h"
#include "wavefront/stages/stages.h"
#include "wavefront/worker.h"

namespace skywave {

// Counts the shadow rays that are there to be traced or, once traced, that hit nothing.
std::uint32_t CountOpen(const LightColumns& lights, std::uint32_t n);

// Returns the surfaces of the current bounce, as strategies see them.
ShadePoints Points(const FrameView& frame, const Worker& w);
// The same of some of them, which must outlive the points.
ShadePoints PointsIn(const SurfaceRanges& ranges, const FrameView& frame, const Worker& w);

// A control variate needs these tables.
struct ControlTables {
  explicit ControlTables(std::uint32_t wave) : subtracted(wave), weights(wave) {}
  // What is subtracted from the current light samples, then from the rays that scatter.
  soa::Table<ControlColumns> subtracted;
  soa::Table<ControlWeightColumns> weights;  // of the current surfaces
};

// Returns the worker's columns for a control variate; null where there is none.
ControlRows ControlsOf(const FrameView& frame, const Worker& w);

// Starts the light groups of paths [0, n) with nothing; `film` will get what they gain. Does
// nothing if no groups are wanted.
void StartGroups(const FrameView& frame, std::uint32_t n, Film& film, Worker& w);

// Rays between tracing and shading: their hits are in the hit table of the worker.
struct SortedHits {
  RayQueues queues;       // of each ray
  SurfaceRanges ranges;   // where the hits will be in the surface table
  std::uint32_t escaped;  // rays that hit nothing
};

// Traces rays [0, n) that arrive at a bounce and sorts what they hit. `only_delta` is that of
// SortHits.
SortedHits TraceAndSort(const FrameView& frame, const PathEnd& end, const RayColumns& rays,
                        std::uint32_t n, std::uint32_t bounce, bool only_delta, Worker& w,
                        StageClock& clock);

// Makes surfaces to shade of the hits of rays [0, n) that are in the queues of BSDFs. The queues
// end with that if they are moved here, so that later stages may borrow their column.
void PrepareHits(const FrameView& frame, const PathEnd& end, const RayColumns& rays,
                 std::uint32_t n, const SortedHits& sorted, Worker& w, StageClock& clock);
void PrepareHits(const FrameView& frame, const PathEnd& end, const RayColumns& rays,
                 std::uint32_t n, SortedHits&& sorted, Worker& w, StageClock& clock);

// Where rays come from: the surfaces that they have left, and the frame that plans the light
// samples of those, which compete with what the rays see. `paths` takes what they see.
struct Departure {
  const FrameView& frame;
  ShadePoints points;
  PathColumns paths;
  // The kinds of BSDFs that each path has met (HistoryColumns); null: no ray without a density
  // follows one that had one.
  const std::uint32_t* met = nullptr;
};

// Returns the departure from the surfaces of the worker itself, of any bounce: its tables stay
// where they are.
Departure FromOwnSurfaces(const FrameView& frame, const Worker& w);

// Adds the kinds of the current surfaces to what their paths have met.
void RememberSurfaces(const Worker& w);

// Traces rays [0, n), adds what the escaped ones see, and makes surfaces to shade of the hits.
// `only_delta` is that of SortHits. Without `from` rays come from the surfaces of the worker
// itself.
void IntersectSurfaces(const FrameView& frame, const RayColumns& rays, std::uint32_t n,
                       std::uint32_t bounce, bool only_delta, Worker& w, StageClock& clock);
void IntersectSurfaces(const FrameView& frame, const RayColumns& rays, std::uint32_t n,
                       std::uint32_t bounce, bool only_delta, const Departure& from, Worker& w,
                       StageClock& clock);

// Ends paths: traces rays [0, n), which can only see emitters and the environment any more, and
// adds what they see. `from` is that of IntersectSurfaces.
void IntersectLights(const FrameView& frame, const RayColumns& rays, std::uint32_t n,
                     std::uint32_t bounce, Worker& w, StageClock& clock);
void IntersectLights(const FrameView& frame, const RayColumns& rays, std::uint32_t n,
                     std::uint32_t bounce, const Departure& from, Worker& w, StageClock& clock);

// Adds what the first n of rays that have been traced and sorted see of emitters and, `escaped` of
// them, of the environment.
void SeeLights(const FrameView& frame, const RayColumns& rays, const RayQueues& queues,
               std::uint32_t n, std::uint32_t escaped, std::uint32_t bounce, const Departure& from,
               Worker& w, StageClock& clock);

// Where the rays of w.lights lead. The camera does not see all sides of all triangles.
enum class ShadowTarget { kLight, kCamera };

// Traces the shadow rays of w.lights, one a surface that takes light samples, as TraceShadows or
// TraceToCamera does, and counts them. Time on the clock before this call was that of evaluation.
void TraceLights(const FrameView& frame, ShadowTarget target, const RayKeys& keys, Worker& w,
                 StageClock& clock);

// Draws, evaluates, traces and adds the light samples of every surface, one after the other.
// Directional lights come light by light, so that a stream of shadow rays has one direction. The
// pairs of dimensions begin at `pairs`.
void LightSurfaces(const FrameView& frame, std::uint32_t bounce, Worker& w, StageClock& clock,
                   std::uint32_t pairs = kCameraEnd.pairs);

// Scatters the current surfaces of BSDFs [first_kind, kBsdfKinds); returns how many rays go on.
std::uint32_t ScatterSurfaces(const FrameView& frame, const PathEnd& end, std::uint32_t first_kind,
                              std::uint32_t bounce, const RayColumns& rays, Worker& w,
                              StageClock& clock);

// Light samples of this bounce are the first whose light meets two surfaces on its way to the
// camera.
inline constexpr std::uint32_t kFirstIndirectBounce = 1;

// Gives the film what it keeps of a bounce besides radiance, if it keeps anything.
void KeepAovs(const FrameView& frame, std::uint32_t bounce, std::uint32_t paths, const Worker& w,
              Film& film, StageClock& clock);

// Gives paths [0, n) to the film. The last one ended at `bounce`.
void FinishWave(const FrameView& frame, std::uint32_t n, std::uint32_t bounce, Worker& w,
                Film& film, StageClock& clock);

// FinishWave has these two parts: what KeepAovs did not see because paths had ended, and all
// radiance.
void KeepDirectOfEnded(std::uint32_t n, std::uint32_t bounce, const Worker& w, Film& film);
void FinishPaths(const FrameView& frame, std::uint32_t n, Worker& w, Film& film, StageClock& clock);

}  // namespace skywave
