#include "wavefront/paths/camera_paths.h"

#include <algorithm>
#include <utility>

#include "wavefront/stages/clamps.h"
#include "wavefront/stages/terminator.h"

namespace skywave {

std::uint32_t FollowPaths(const FrameView& frame, const Departure& first, std::uint32_t n,
                          std::uint32_t bounce, Worker& w, Film* film, StageClock& clock) {
  soa::Table<RayColumns>*rays = &w.rays[0], *next = &w.rays[1];
  Departure own = FromOwnSurfaces(frame, w);
  const Departure* from = &first;
  if (frame.geometry->has_deltas()) {
    // Paths that do not begin at the camera begin at surfaces with a density.
    std::fill_n(w.history->met, w.history.rows(), bounce == 0 ? 0 : kMetDense);
    own.met = w.history->met;
  }
  const std::uint32_t paths = n;
  for (; n > 0; ++bounce, from = &own) {
    if (bounce == frame.options.max_depth) {
      IntersectLights(frame, *rays, n, bounce, *from, w, clock);
      break;
    }
    IntersectSurfaces(frame, *rays, n, bounce, /*only_delta=*/false, *from, w, clock);
    if (own.met != nullptr) RememberSurfaces(w);
    ClampDirect(frame, bounce, w);
    if (film != nullptr) KeepAovs(frame, bounce, paths, w, *film, clock);
    RoundTerminator(frame, w);
    LightSurfaces(frame, bounce, w, clock);
    const bool last = bounce + 1 == frame.options.max_depth;
    const std::uint32_t first_kind = last ? frame.first_bsdf_that_sees_light() : 0;
    n = ScatterSurfaces(frame, kCameraEnd, first_kind, bounce, *next, w, clock);
    std::swap(rays, next);
  }
  ClampDirectOfEnded(frame, bounce, w);
  ClampIndirectAndWhole(frame, w);
  return bounce;
}

}  // namespace skywave
