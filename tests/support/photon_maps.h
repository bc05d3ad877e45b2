// Makes requests and maps of photons for tests, also for those that render waves themselves.
#pragma once

#include <functional>

#include "scene/shapes/mesh.h"
#include "tests/support/render_scenes.h"
#include "wavefront/passes/photon_pass.h"
#include "wavefront/render.h"

namespace skywave {

// Returns a pool of two workers for the frame.
inline WorkerPool TwoThreads(const FrameView& frame) {
  RenderOptions options = frame.options;
  options.threads = 2;
  return WorkerPool(options);
}

// Returns the photon maps of the first pass.
inline PhotonMaps MapsOf(const FrameView& frame) {
  WorkerPool pool = TwoThreads(frame);
  PhotonMaps maps;
  pool.Run([&] { maps = TracePhotons(frame, PhotonPasses(frame.options).front(), pool); });
  return maps;
}
inline PhotonMaps MapsOf(const RenderJob& job) { return MapsOf(job.frame()); }

inline JobRequest PhotonRequest(int width, int height, std::uint32_t samples,
                                std::uint32_t max_depth) {
  JobRequest request = SmallRequest(width, height, samples);
  request.integrator = Integrator::kPhoton;
  request.max_depth = max_depth;
  request.options.of<PhotonOptions>().indirect = 40000;
  request.options.of<PhotonOptions>().caustic = 20000;
  return request;
}

// Returns a ball of glass above a floor.
inline Scene UnderGlass() {
  Scene scene;
  Place(scene, Quad(2), AddLambert(scene, "floor", glm::vec3(0.7f)), glm::vec3(0));
  Place(scene, Facetted(Sphere(0.5f, 12)), AddGlass(scene, 1.5f), {0, 0.9f, 0});
  scene.camera = LookAtCamera({0, 0.6f, 2}, {0, 0, 0.1f}, {0, 1, 0}, 40, false);
  return scene;
}

// Calls `render` with the frame or, if light paths are stored, with each of its passes.
inline void EachPassOf(const FrameView& frame,
                       const std::function<void(const FrameView&)>& render) {
  WorkerPool pool = TwoThreads(frame);
  PhotonCounts counts;
  const RenderPass render_pass = [&](const FrameView& pass) {
    render(pass);
    return true;
  };
  pool.Run([&] { ForEachPass(frame, pool, counts, render_pass); });
}

}  // namespace skywave
