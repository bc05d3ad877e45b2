// Makes the photon maps of a frame for tests that render its waves themselves.
#pragma once

#include <tbb/task_arena.h>

#include <functional>
#include <memory>
#include <vector>

#include "wavefront/photons/photon_pass.h"
#include "wavefront/render.h"

namespace skywave {

// Returns the photon maps of the first pass.
inline PhotonMaps MapsOf(const FrameView& frame) {
  PhotonMaps maps;
  tbb::task_arena arena(2);
  arena.execute([&] {
    std::vector<std::unique_ptr<Worker>> workers(std::size_t(arena.max_concurrency()));
    maps = TracePhotons(frame, PhotonPasses(frame.options).front(), workers, nullptr);
  });
  return maps;
}

// Calls `render` with the frame or, if light paths are stored, with each of its passes.
inline void EachPassOf(const FrameView& frame,
                       const std::function<void(const FrameView&)>& render) {
  tbb::task_arena arena(2);
  arena.execute([&] {
    std::vector<std::unique_ptr<Worker>> workers(std::size_t(arena.max_concurrency()));
    PhotonCounts counts;
    ForEachPass(frame, workers, nullptr, counts, render);
  });
}

}  // namespace skywave
