#include "wavefront/stages/projection.h"

#include <algorithm>

#include "wavefront/stages/stages.h"

namespace skywave {

void ColorCatchers(const FrameView& frame, Worker& w) {
  const auto* const projection = frame.find<ProjectionView>();
  if (projection == nullptr) return;
  const CaughtRows rows(w.scratch);
  std::uint32_t n = 0;
  for (std::uint32_t i = 0; i < w.ranges.total(); ++i) {
    if (frame.geometry->IsCatcher(w.surfaces->triangle[i])) rows->row[n++] = i;
  }
  ColorByProjection(*projection, rows->row, n, w.surfaces);
}

void KeepBackdrop(const FrameView& frame, const RayColumns& rays, std::uint32_t n, Worker& w,
                  Film& film) {
  const auto* const dome = frame.find<DomeView>();
  if (dome == nullptr) return;
  const PathColumns& paths = w.paths;
  SeeDome(*dome, rays, n, paths.r, paths.g, paths.b);
  WeighByFilter(frame, n, w);
  film.AddLightPart(LightPart::kBackdrop, paths, n);
  for (float* const channel : {paths.r, paths.g, paths.b}) std::fill_n(channel, n, 0.0f);
}

}  // namespace skywave
