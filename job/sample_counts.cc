#include "job/sample_counts.h"

#include <algorithm>
#include <cmath>

#include "lights/maps/sphere_map.h"
#include "wavefront/render.h"

namespace skywave {

Image CountSamples(const RenderJob& job) {
  const FrameView frame = job.frame();
  const EnvironmentMap& map = *frame.map;
  const Image& latlong = map.latlong;
  std::vector<RayRecorder> recorders;
  Film film = job.MakeFilm();
  RenderFrame(frame, film, {.recorders = &recorders});

  Image counts(latlong.width, latlong.height);
  const auto& m = map.map_from_world;
  for (const RayRecorder& rays : recorders) {
    for (const RayBatch& batch : rays.batches()) {
      if (batch.kind != RayKind::kShadow) continue;
      for (std::size_t i = batch.begin; i < batch.begin + batch.count; ++i) {
        if (!std::isinf(rays.t_far()[i])) continue;  // of a lamp
        const auto row = [&](std::size_t k) {
          return double(m[3 * k]) * double(rays.dir(0)[i]) +
                 double(m[3 * k + 1]) * double(rays.dir(1)[i]) +
                 double(m[3 * k + 2]) * double(rays.dir(2)[i]);
        };
        double u, v;
        UvOfDirection({row(0), row(1), row(2)}, u, v);
        float* const texel = counts.Pixel(std::clamp(int(u * counts.width), 0, counts.width - 1),
                                          std::clamp(int(v * counts.height), 0, counts.height - 1));
        for (int c = 0; c < 3; ++c) texel[c] += 1;
      }
    }
  }
  return counts;
}

}  // namespace skywave
