// Catchers have the colours that a picture of their place shows, and the film sees the place behind
// the scene (kernels/lights/projection.h).
#pragma once

#include <cstdint>

#include "kernels/lights/projection.h"
#include "wavefront/film/film.h"
#include "wavefront/frame.h"
#include "wavefront/worker.h"

namespace skywave {

// Gives the catchers among the current surfaces the colours of the ProjectionView that the frame
// shows. Does nothing without one.
void ColorCatchers(const FrameView& frame, Worker& w);

// Gives the film what paths [0, n), which begin with rays, see of the DomeView that the frame
// shows, and leaves their radiance at 0. Does nothing without one.
void KeepBackdrop(const FrameView& frame, const RayColumns& rays, std::uint32_t n, Worker& w,
                  Film& film);

}  // namespace skywave
