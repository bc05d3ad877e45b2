#include "job/sample_counts.h"

#include <cmath>
#include <vector>

#include "lights/maps/sphere_map.h"
#include "wavefront/render.h"

namespace skywave {
namespace {

// Adds the shadow rays of `rays` that go to the map, not to a lamp, to the texels they meet.
void CountRays(const RayRecorder& rays, const EnvironmentMap& map, std::vector<double>& counts) {
  const Image& latlong = map.latlong;
  for (const RayBatch& batch : rays.batches()) {
    if (batch.kind != RayKind::kShadow) continue;
    for (std::size_t i = batch.begin; i < batch.begin + batch.count; ++i) {
      if (!std::isinf(rays.t_far()[i])) continue;
      double u, v;
      UvOfDirection(
          MapFromWorld({rays.dir(0)[i], rays.dir(1)[i], rays.dir(2)[i]}, map.map_from_world), u, v);
      counts[TexelOfUv(u, v, latlong.width, latlong.height)] += 1;
    }
  }
}

}  // namespace

Image CountSamples(const RenderJob& job) {
  FrameView frame = job.frame();
  const Image& latlong = frame.map->latlong;
  std::vector<double> counts(std::size_t(latlong.width) * latlong.height);
  // A sample of each pixel at a time, so that its rays are all that is kept.
  RenderOptions& options = frame.options;
  const SampleRange samples = SamplesOf(options);
  options.picture_samples = PictureSamples(options);
  options.samples_per_pixel = 1;
  for (std::uint32_t sample = samples.first; sample < samples.end; ++sample) {
    options.first_sample = sample;
    Film film = job.MakeFilm();
    std::vector<RayRecorder> recorders;
    RenderFrame(frame, film, {.recorders = &recorders});
    for (const RayRecorder& rays : recorders) CountRays(rays, *frame.map, counts);
  }
  Image image(latlong.width, latlong.height);
  for (std::size_t i = 0; i < image.rgb.size(); ++i) image.rgb[i] = float(counts[i / 3]);
  return image;
}

}  // namespace skywave
