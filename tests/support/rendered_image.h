// Renders jobs to pictures.
#pragma once

#include <cstddef>

#include "job/job.h"
#include "wavefront/render.h"

namespace skywave {

inline Image Render(const RenderJob& job) {
  Film film = job.MakeFilm();
  RenderFrame(job.frame(), film);
  return film.Resolve(job.options().samples_per_pixel);
}

inline Image Render(const Scene& scene, const JobRequest& request) {
  return Render(RenderJob(scene, request));
}

// Returns the mean of a channel over the picture.
inline double MeanOf(const Image& image, std::size_t channel) {
  double sum = 0;
  for (std::size_t i = channel; i < image.rgb.size(); i += 3) sum += double(image.rgb[i]);
  return 3 * sum / double(image.rgb.size());
}

}  // namespace skywave
