// The stages of light paths lead from lights over surfaces to the film, over the tables of a
// worker. Each counts and times what it does.
#pragma once

#include "kernels/bsdf/bsdf.h"
#include "kernels/light_paths/camera_connection.h"
#include "kernels/light_paths/emission.h"
#include "kernels/light_paths/flux.h"
#include "wavefront/film/film.h"
#include "wavefront/frame.h"
#include "wavefront/records/emission_guide.h"
#include "wavefront/stages/path_stages.h"
#include "wavefront/stages/stages.h"
#include "wavefront/worker.h"

namespace skywave {

// Light paths need these tables .
struct LightPathTables {
  explicit LightPathTables(std::uint32_t wave)
      : emission(wave), values(wave), cameras(wave), normals(wave) {}
  soa::Table<EmissionColumns> emission;
  soa::Table<BsdfValueColumns> values;
  soa::Table<CameraColumns> cameras;
  soa::Table<NormalColumns> normals;  // shading normals as the camera sees them
};

// Adds them to the worker of an integrator that has light paths.
inline void AddLightPathTables(const RenderOptions& options, Worker& worker) {
  worker.tables.Add<LightPathTables>(options.wave);
}

// Returns the guide of a frame, or an empty one if it has none.
inline EmissionGuideView GuideOf(const FrameView& frame) {
  const auto* const guide = frame.find<EmissionGuide>();
  return guide != nullptr ? guide->view() : EmissionGuideView();
}

// Starts light paths [first, first + n) of the frame in rows [0, n) of `paths`. All of them are
// points of one sequence, so that the whole set is stratified. Radiance and pixel mean nothing.
void StartLightPaths(const RenderOptions& options, std::uint64_t first, std::uint32_t n,
                     const PathColumns& paths);

// Writes the rays of paths [0, n) that leave the environment and the lights, one a path, to `rays`,
// and what is known of them to LightPathTables::emission. The strategy can emit. Uniforms are those
// of kLightEnd, bounce 0.
void EmitRays(const FrameView& frame, std::uint32_t n, const RayColumns& rays, Worker& w,
              StageClock& clock);

// Traces rays [0, n) that arrive at bounce 1 or a later one and makes surfaces of the hits.
void IntersectLightPathSurfaces(const FrameView& frame, const RayColumns& rays, std::uint32_t n,
                                std::uint32_t bounce, Worker& w, StageClock& clock);

// Returns the frame of light paths that passes store. The strategy of camera paths may need many
// light samples or surfaces to draw them for, so these start with frame.emitter.
FrameView LightPathView(const FrameView& frame);

// Connects every surface that takes light samples to the camera: w.lights gets what the connections
// bring, closed where that is nothing, and LightPathTables::cameras where they go. Shadow rays are
// not traced.
void ConnectSurfaces(const FrameView& frame, std::uint32_t bounce, Worker& w, StageClock& clock);

// Traces the shadow rays of the connections and splats those that arrive, each as one of the light
// paths of a sample.
void SplatConnections(const FrameView& frame, std::uint32_t bounce, Worker& w, Film& film,
                      StageClock& clock);

}  // namespace skywave
