// Makes the photon maps of a frame for tests that render its waves themselves.
#pragma once

#include <functional>

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
