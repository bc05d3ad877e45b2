// The stages of sub-paths that are connected: connections of their vertices, and the weights of all
// techniques that make a path. They work on the tables of a worker; each counts and times what it
// does.
#pragma once

#include <cstdint>
#include <optional>

#include "kernels/columns.h"
#include "kernels/light_paths/bidirectional.h"
#include "wavefront/film/film.h"
#include "wavefront/frame.h"
#include "wavefront/stages/bidirectional_tables.h"
#include "wavefront/stages/stages.h"
#include "wavefront/stats.h"
#include "wavefront/worker.h"

namespace skywave {

// The number of vertices of a path that come from the light, which counts itself, and from the eye.
struct SubpathLengths {
  std::uint32_t light = 0, eye = 2;
};

// Which of the techniques that connect sub-paths a picture shows.
struct ConnectionOptions {
  std::optional<SubpathLengths> shown;  // only paths of these lengths; unset: all
  bool shows(std::uint32_t light, std::uint32_t eye) const {
    return !shown || (shown->light == light && shown->eye == eye);
  }
};

// What passes that merge vertices say to the weights of all techniques.
struct Merging {
  float eta_vcm = 0;  // that of the current pass, see MisTechniques
};

// Returns the techniques that share the paths of a frame.
MisTechniques TechniquesOf(const FrameView& frame);

// Evaluates the BSDFs of surfaces backwards along directions dir of `lights`: value and density of
// wo given dir, as a path that comes from there sees the surface. Rows of delta BSDFs are left as
// they are. `turned` gets the surfaces as they are seen from there.
void EvaluateBackward(const MaterialView& materials, const SurfaceColumns& surfaces,
                      const SurfaceRanges& ranges, const LightColumns& lights,
                      const TurnedColumns& turned, const BsdfValueColumns& out);

// The same, and forwards too. Origins of surfaces that transmit move to the side of dir
// (MoveToSide).
void EvaluateBothDirections(const MaterialView& materials, const SurfaceColumns& surfaces,
                            const SurfaceRanges& ranges, const LightColumns& lights,
                            const TurnedColumns& turned, const BothDirections& out);

// Begins the sub-paths of camera rays [0, n), which were generated with `lens`.
void LeaveCamera(const FrameView& frame, const LensUniforms& lens, std::uint32_t n, Worker& w);

// Scatters the current surfaces as Scatter does, together with their sub-paths: `at` belongs to the
// surfaces, `flying` to the paths.
std::uint32_t ScatterSubpaths(const FrameView& frame, const PathEnd& end, const SubpathColumns& at,
                              std::uint32_t first_kind, std::uint32_t bounce,
                              const RayColumns& rays, const SubpathColumns& flying, Worker& w,
                              StageClock& clock);

// Adds the light that the eye's rays [0, n) have met, `escaped` of them in the environment,
// weighted against the other techniques.
void AddHitLight(const FrameView& frame, const RayColumns& rays, std::uint32_t n,
                 std::uint32_t escaped, std::uint32_t bounce, Worker& w, StageClock& clock);

// Adds a light sample of every surface of the eye, weighted against the other techniques.
void ConnectLights(const FrameView& frame, std::uint32_t bounce, Worker& w, StageClock& clock);

// Connects the surfaces of the eye to the light vertices of one bounce of the same paths.
void ConnectVertices(const FrameView& frame, std::uint32_t bounce, std::uint32_t light_bounce,
                     Worker& w, StageClock& clock);

// Weights connections of light vertices to the camera (ConnectSurfaces) against the other
// techniques.
void WeighCameraConnections(const FrameView& frame, const SubpathColumns& at, Worker& w,
                            StageClock& clock);

// Keeps the current surfaces, which are those of light sub-paths, and which paths they belong to.
void KeepVertices(Worker& w, LightVertices& vertices);

}  // namespace skywave
